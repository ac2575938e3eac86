"""How far a survey's map and way are from the simulator's truth.

R rows, C columns of the map; K poses.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import MAZE_RESOLUTION_M
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose, wrap_angles
from twonav_cli.grid import Cell
from twonav_cli.mapping.approximate import blocked_cells
from twonav_cli.mapping.occupancy import UNKNOWN, OccupancyMap
from twonav_cli.mapping.scan import StampedPose
from twonav_cli.maze import filled_where_unreachable

BoolGrid = NDArray[np.bool_]


def paired(believed: Sequence[StampedPose], truth: Sequence[StampedPose]) -> tuple[FloatArray, FloatArray]:
    """Return the poses [K, 3] of a trajectory and the true ones [K, 3] of the same stamps.

    Raises:
        TwonavError: The truth has no pose of some stamp.
    """
    at = {stamped.stamp_s: stamped.pose for stamped in truth}
    missing = [stamped.stamp_s for stamped in believed if stamped.stamp_s not in at]
    if missing:
        raise TwonavError(f"no true pose is known for the time {missing[0]:.3f} s: compare ways of the same run")
    ours = np.array([stamped.pose for stamped in believed], dtype=np.float64).reshape(-1, 3)
    return ours, np.array([at[stamped.stamp_s] for stamped in believed], dtype=np.float64).reshape(-1, 3)


def pose_errors(believed: FloatArray, true: FloatArray) -> dict[str, float]:
    """Return the errors of poses [K, 3] in the map frame; nothing is aligned first.

    Returns:
        "pose_mean_m", "pose_worst_m" and "pose_mean_deg".
    """
    away_m = np.hypot(*(believed - true)[:, :2].T)
    turned_rad = np.abs(wrap_angles(believed[:, 2] - true[:, 2]))
    return {
        "pose_mean_m": float(away_m.mean()),
        "pose_worst_m": float(away_m.max()),
        "pose_mean_deg": float(np.rad2deg(turned_rad.mean())),
    }


def map_agreement(ours: OccupancyMap, geometry: OccupancyMap, start: Pose) -> dict[str, Any]:
    """Return how much of two maps of one frame agrees within one cell.

    A cell agrees when the other map holds a cell of its kind within one cell of it, corners included. Counted are
    the occupied cells of the geometry that could be seen (one of their eight neighbours is floor that is connected
    to the start), that floor, and every occupied and every free cell of ours. What is inside furniture and walls, or
    closed off, no beam can reach: where ours says unknown there, the cells are left out and counted by themselves.

    Returns:
        "agreeing" (share of all counted cells), the same share of each of the four kinds, and "hidden_cells".

    Raises:
        TwonavError: The maps lie differently, or the start is not on the geometry's floor.
    """
    if ours.frame != geometry.frame:
        raise TwonavError("the two maps do not lie on the same frame: make them of the same scene")
    floor = connected_floor(geometry, start)
    surface = geometry.occupied & _grown(floor)
    kinds = {
        "walls_found": (surface, ours.occupied),
        "floor_found": (floor, ours.free),
        "walls_right": (ours.occupied, geometry.occupied),
        "floor_right": (ours.free, geometry.free),
    }
    counts = {name: (int((mine & _grown(other)).sum()), int(mine.sum())) for name, (mine, other) in kinds.items()}
    agreeing, counted = (sum(count[k] for count in counts.values()) for k in (0, 1))
    shares = {name: good / of if of else 1.0 for name, (good, of) in counts.items()}
    hidden = (ours.pixels == UNKNOWN) & ~floor & ~surface
    return {"agreeing": agreeing / counted, **shares, "hidden_cells": int(hidden.sum())}


def connected_floor(map_: OccupancyMap, start: Pose) -> BoolGrid:
    """Return the free cells [R, C] that are connected to a pose's, side by side.

    Raises:
        TwonavError: The pose is not on free floor.
    """
    from scipy.ndimage import label

    regions, _ = label(map_.free)
    number = regions[map_.frame.cell_at(start.x_m, start.y_m)]
    if not number:
        raise TwonavError(f"({start.x_m:.2f}, {start.y_m:.2f}) is not on free floor: start elsewhere")
    return np.asarray(regions == number)


def maze_differences(ours: OccupancyMap, geometry: OccupancyMap, start: Pose) -> dict[str, list[list[int]]]:
    """Return which cells [row, col] of the approximated maze (§4.3) only one of two maps of one frame leaves free.

    Returns:
        "blocked_by_us" and "freed_by_us".
    """
    mine, theirs = (_maze_cells(map_, start) for map_ in (ours, geometry))
    return {
        "blocked_by_us": [[int(row), int(col)] for row, col in np.argwhere(mine & ~theirs)],
        "freed_by_us": [[int(row), int(col)] for row, col in np.argwhere(theirs & ~mine)],
    }


def _maze_cells(map_: OccupancyMap, start: Pose) -> BoolGrid:
    """Return the blocked cells [rows, cols] of a map's maze; all are, when the start's cell is."""
    blocked = blocked_cells(~map_.free, map_.frame, MAZE_RESOLUTION_M)
    cell: Cell = map_.frame.coarser(MAZE_RESOLUTION_M).cell_at(start.x_m, start.y_m)
    return filled_where_unreachable(blocked, cell)


def _grown(cells: BoolGrid) -> BoolGrid:
    """Return the cells [R, C] and their eight neighbours."""
    from scipy.ndimage import binary_dilation

    return np.asarray(binary_dilation(cells, np.ones((3, 3), dtype=np.bool_)))
