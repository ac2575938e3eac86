"""The way over the known floor: where the robot fits, what each place costs, and the points on the way.

R rows, C columns of the map.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import ROBOT_INSCRIBED_M
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.occupancy import UNKNOWN, OccupancyMap
from twonav_cli.navigation.dijkstra import FreeSpace, PathTree
from twonav_cli.navigation.distance import distances_m

BoolGrid = NDArray[np.bool_]
FloatGrid = NDArray[np.float64]

SPARE_M = 0.03
"""Room beside the robot that a way must have: the pose is believed to a few centimetres (ours)."""

UNKNOWN_ROOM_M = 0.1
"""The axle stays this far from what nobody has seen yet (ours)."""

PREFERRED_ROOM_M = 0.6
"""Farther than this from an obstacle a place costs its length only (ours)."""

NARROW_COST = 4.0
"""How much more a place costs where the robot just fits (ours)."""

JOIN_M = 0.6
"""A robot that seems to stand too near to something begins its way at the nearest good place within this (ours)."""


@dataclass(frozen=True)
class Ways:
    """Where the robot can be, and the cheapest way to every place from where it is.

    Attributes:
        room_m: [R, C] from each cell's centre to the nearest occupied cell's.
        tree: Ways from the robot's place.
    """

    frame: GridFrame
    room_m: FloatGrid
    tree: PathTree

    def points_to(self, cell: Cell, spacing_m: float) -> list[tuple[float, float]]:
        """Return points of the way to a cell, the last one in it, at most `spacing_m` apart; metres."""
        return spaced([self.frame.centre_of(at) for at in self.tree.path_to(cell)], spacing_m)


def passable(map_: OccupancyMap, refused: BoolGrid) -> tuple[BoolGrid, FloatGrid]:
    """Return where [R, C] the axle can be, and how far [R, C] each cell is from what is occupied, metres.

    Args:
        map_: What is known.
        refused: [R, C] places that were tried in vain.
    """
    resolution_m = map_.frame.resolution_m
    room_m = distances_m(map_.occupied, resolution_m)
    unknown_m = distances_m(map_.pixels == UNKNOWN, resolution_m)
    fits = room_m > ROBOT_INSCRIBED_M + SPARE_M + 0.5 * resolution_m
    return np.asarray(map_.free & fits & (unknown_m > UNKNOWN_ROOM_M) & ~refused), room_m


def place_cost(room_m: FloatGrid) -> FloatGrid:
    """Return the factor [R, C] on a step's length: 1 in the open, 1 + NARROW_COST where the robot just fits."""
    narrow = np.clip((PREFERRED_ROOM_M - room_m) / (PREFERRED_ROOM_M - ROBOT_INSCRIBED_M), 0.0, 1.0)
    return np.asarray(1.0 + NARROW_COST * narrow**2)


def ways_from(map_: OccupancyMap, pose: Pose, refused: BoolGrid) -> Ways | None:
    """Return the ways over the known floor from where the robot believes to be; None if it fits nowhere near."""
    fits, room_m = passable(map_, refused)
    start = nearest_cell(fits, map_.frame, pose)
    if start is None:
        return None
    return Ways(map_.frame, room_m, FreeSpace(fits, place_cost(room_m)).tree(start))


def nearest_cell(cells: BoolGrid, frame: GridFrame, pose: Pose) -> Cell | None:
    """Return the cell of a set [R, C] that is nearest to a pose; None if all are farther than JOIN_M."""
    here = frame.cell_at(pose.x_m, pose.y_m)
    reach = int(JOIN_M / frame.resolution_m)
    row0, col0 = max(here.row - reach, 0), max(here.col - reach, 0)
    near = np.argwhere(cells[row0 : here.row + reach + 1, col0 : here.col + reach + 1]) + np.array([row0, col0])
    if not len(near):
        return None
    away = ((near - np.array(here)) ** 2).sum(axis=1)
    return Cell(*(int(index) for index in near[away.argmin()]))


def spaced(path: list[tuple[float, float]], spacing_m: float) -> list[tuple[float, float]]:
    """Return points along a path of points, equally far apart and at most `spacing_m`; the last one is the path's."""
    line = np.array(path)  # [n, 2]
    if len(line) < 2:
        return [(float(x_m), float(y_m)) for x_m, y_m in line]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])
    pieces = max(1, int(np.ceil(along[-1] / spacing_m)))
    stops = along[-1] * np.arange(1, pieces + 1) / pieces
    xs, ys = (np.interp(stops, along, line[:, axis]) for axis in (0, 1))
    return [(float(x_m), float(y_m)) for x_m, y_m in zip(xs, ys, strict=True)]
