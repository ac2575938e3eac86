"""The tour on which frames are taken: from cell to cell along shortest paths, always to the nearest one left (§4.1).

K cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.navigation.dijkstra import FreeSpace, PathTree

NEAR_M = 1.0
"""Within this the nearest cell is looked for first: most have a neighbour, and a short search is cheap (ours)."""

WAYPOINT_M = 0.25
"""Distance on a path after which the robot finds out where it is by its range finder (ours)."""


def tour(floor: NDArray[np.bool_], frame: GridFrame, centres: FloatArray) -> tuple[NDArray[np.int64], list[FloatArray]]:
    """Return the order in which the cells are visited, and the way to each.

    Args:
        floor: [R, C] pixels where the axle may be, all connected.
        frame: Where the pixels lie.
        centres: [K, 2] centres of the cells, metres; the tour begins at the first.

    Returns:
        The cells in order [K], and for each in that order the points [W, 2] of the shortest path to it from the one
        before, both ends among them (Dijkstra, §4.1); the first has only its own centre.

    Raises:
        TwonavError: A cell cannot be reached.
    """
    space = FreeSpace(floor)
    pixels = [frame.cell_at(x_m, y_m) for x_m, y_m in centres]
    rows, cols = np.array(pixels, dtype=np.int64).reshape(-1, 2).T
    left = np.ones(len(centres), dtype=bool)
    order, ways = [0], [centres[:1]]
    left[0] = False
    while left.any():
        here = order[-1]
        tree = space.tree(pixels[here], NEAR_M / frame.resolution_m)
        lengths = np.where(left, tree.lengths[rows, cols], np.inf)
        if not np.isfinite(lengths.min()):
            tree = space.tree(pixels[here])
            lengths = np.where(left, tree.lengths[rows, cols], np.inf)
        following = int(lengths.argmin())
        if not np.isfinite(lengths[following]):
            raise TwonavError(
                "some places cannot be reached from the others: look at the map with `twonav scenes show`"
            )
        ways.append(_way(tree, pixels[following], frame, centres[here], centres[following]))
        order.append(following)
        left[following] = False
    return np.array(order, dtype=np.int64), ways


def _way(tree: PathTree, goal: Cell, frame: GridFrame, start_m: FloatArray, end_m: FloatArray) -> FloatArray:
    """Return the points [W, 2] of a path from a cell's centre to another's, a waypoint apart."""
    cells = tree.path_to(goal)
    between = cells[1:-1][:: max(1, round(WAYPOINT_M / frame.resolution_m))][1:]
    return np.array([start_m, *(frame.centre_of(cell) for cell in between), end_m])
