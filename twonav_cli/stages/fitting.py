"""Whether the robot's body gets where the maze says that there is a way: asked before it learns there.

R, C rows and columns of the 5 cm map.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import ROBOT_INSCRIBED_M
from twonav_cli.dataset.poses import clearance_m
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.floor import Floor


def check_robot_fits(floor: Floor) -> None:
    """Make sure that the robot's body fits into every start and goal, and through the ways between them.

    The circle inside its outline must get through; that is the least that either base needs.

    Raises:
        TwonavError: Says which goal it does not get to, from which start, and what to do.
    """
    regions = _regions(floor)
    starts = {name: _regions_in(regions, floor, cell) for name, cell in floor.maze.starts.items()}
    goals = {name: _regions_in(regions, floor, cell) for name, cell in floor.maze.goals.items()}
    for kind, places in (("start", starts), ("goal", goals)):
        for name, found in places.items():
            if not found:
                raise TwonavError(
                    f"the robot does not fit into the cell of {kind} {name!r}: what stands around it leaves less than "
                    f"{2 * ROBOT_INSCRIBED_M:.2f} m; move the {kind} or the furniture"
                )
    for goal, there in goals.items():
        for start, here in starts.items():
            if not there & here:
                raise TwonavError(
                    f"the robot does not get from start {start!r} to goal {goal!r}: somewhere on the way there is less "
                    f"than its {2 * ROBOT_INSCRIBED_M:.2f} m; widen the passage or move one of them"
                )


def _regions(floor: Floor) -> NDArray[np.int32]:
    """Return the number of the region [R, C] that each pixel belongs to, 0 where the robot's axle cannot be."""
    from scipy.ndimage import label

    half_m = 0.5 * floor.map.frame.resolution_m  # a wall may end anywhere within its pixel
    room = clearance_m(floor.map.occupied, floor.map.frame) >= ROBOT_INSCRIBED_M - half_m
    return np.asarray(label(room, structure=np.ones((3, 3)))[0], dtype=np.int32)  # diagonal neighbours belong together


def _regions_in(regions: NDArray[np.int32], floor: Floor, cell: Cell) -> set[int]:
    """Return the regions of which some pixel lies in a cell of the maze."""
    rows, cols = _pixels_of(floor.maze_frame, floor.map.frame, cell)
    return {int(number) for number in np.unique(regions[rows, cols])} - {0}


def _pixels_of(maze_frame: GridFrame, map_frame: GridFrame, cell: Cell) -> tuple[slice, slice]:
    """Return the pixels that make up a cell."""
    x_m, y_m = maze_frame.centre_of(cell)
    half_m, inset_m = maze_frame.resolution_m / 2, map_frame.resolution_m / 2
    low = map_frame.cell_at(x_m - half_m + inset_m, y_m - half_m + inset_m)
    high = map_frame.cell_at(x_m + half_m - inset_m, y_m + half_m - inset_m)
    return slice(high.row, low.row + 1), slice(low.col, high.col + 1)
