"""From the 5 cm map to the maze of 40 cm cells (§4.3)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import MAZE_RESOLUTION_M
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.maze import Maze, filled_where_unreachable


def approximate_maze(
    map_: OccupancyMap,
    goals: dict[str, Pose],
    starts: dict[str, Pose],
    resolution_m: float = MAZE_RESOLUTION_M,
) -> tuple[Maze, GridFrame]:
    """Return the maze of a map: a cell with any pixel that is not free is blocked, as is what cannot be reached (§4.3).

    Args:
        map_: Occupied and unknown pixels block.
        goals: Name to pose.
        starts: Name to pose.
        resolution_m: Edge of a maze cell, a multiple of the map's.

    Returns:
        The maze, and where its cells lie.

    Raises:
        TwonavError: A goal or start lies off the map, in a blocked cell, or apart from the first one.
    """
    frame = map_.frame.coarser(resolution_m)
    blocked = blocked_cells(~map_.free, map_.frame, resolution_m)
    named = [("start", name, pose) for name, pose in starts.items()]
    named += [("goal", name, pose) for name, pose in goals.items()]
    cells = {(kind, name): _free_cell(kind, name, pose, blocked, frame) for kind, name, pose in named}
    if not cells:
        raise TwonavError("a maze needs a goal: declare one in the scene")
    (first_kind, first_name), source = next(iter(cells.items()))
    unreachable = filled_where_unreachable(blocked, source)
    for (kind, name), cell in cells.items():
        if unreachable[cell]:
            raise TwonavError(
                f"{kind} {name!r} cannot be reached from {first_kind} {first_name!r} in {resolution_m:.2f} m cells: "
                "open a way at least two cells wide between them, or move one of them"
            )
    goal_cells = {name: cells["goal", name] for name in goals}
    return Maze(unreachable, goal_cells, {name: cells["start", name] for name in starts}), frame


def largest_maze(map_: OccupancyMap, resolution_m: float = MAZE_RESOLUTION_M) -> tuple[Maze, GridFrame]:
    """Return the maze of a map that has no goals: of the free cells the largest connected part is kept (§4.3; ours).

    Args:
        map_: Any map.
        resolution_m: Edge of a maze cell; it is rounded to whole pixels of the map.

    Returns:
        The maze without goals and starts, and where its cells lie.

    Raises:
        TwonavError: The map is smaller than a cell, or no cell of it is free.
    """
    from scipy.ndimage import label

    pixel_m = map_.frame.resolution_m
    edge_m = max(round(resolution_m / pixel_m), 1) * pixel_m
    blocked = blocked_cells(~map_.free, map_.frame, edge_m)
    parts, count = label(~blocked)  # side by side, as the agent moves
    if not count:
        raise TwonavError(f"no {edge_m:.2f} m cell of the map is free: make the map again")
    largest = 1 + int(np.bincount(parts.ravel())[1:].argmax())
    return Maze(np.asarray(parts != largest), {}, {}), map_.frame.coarser(edge_m)


def blocked_cells(not_free: NDArray[np.bool_], frame: GridFrame, resolution_m: float) -> NDArray[np.bool_]:
    """Return which cells [R, C] hold any pixel [rows, cols] that is not free (§4.3).

    Raises:
        TwonavError: A cell is not a whole number of pixels wide, or wider than the map.
    """
    pixels = round(resolution_m / frame.resolution_m)
    if pixels < 1 or abs(pixels * frame.resolution_m - resolution_m) > 1e-6:
        raise TwonavError(
            f"maze cells of {resolution_m} m are not whole pixels of {frame.resolution_m} m: choose a multiple of it"
        )
    rows, cols = frame.rows // pixels, frame.cols // pixels
    if rows < 1 or cols < 1:
        raise TwonavError(f"the map is smaller than one maze cell of {resolution_m} m: enlarge it")
    kept = not_free[: rows * pixels, : cols * pixels]  # a last row or column that is not full is dropped
    return np.asarray(kept.reshape(rows, pixels, cols, pixels).any(axis=(1, 3)))


def _free_cell(kind: str, name: str, pose: Pose, blocked: NDArray[np.bool_], frame: GridFrame) -> Cell:
    """Return the free cell of a named pose.

    Raises:
        TwonavError: It lies off the maze or in a blocked cell.
    """
    if not frame.contains(pose.x_m, pose.y_m):
        raise TwonavError(
            f"{kind} {name!r} at ({pose.x_m:.2f}, {pose.y_m:.2f}) lies off the map: move it onto the floor"
        )
    cell = frame.cell_at(pose.x_m, pose.y_m)
    if not blocked[cell]:
        return cell
    free = np.argwhere(~blocked)
    if not free.size:
        raise TwonavError(f"no {frame.resolution_m:.2f} m cell of the map is free: make the map again")
    near = free[np.argmin(((free - np.array(cell)) ** 2).sum(axis=1))]
    x_m, y_m = frame.centre_of(Cell(int(near[0]), int(near[1])))
    raise TwonavError(
        f"{kind} {name!r} at ({pose.x_m:.2f}, {pose.y_m:.2f}) lies in a cell with a wall or furniture in it: "
        f"move it, for example to ({x_m:.2f}, {y_m:.2f})"
    )
