"""Cells of the maze as places on the floor: which free cell stands for a place, and where an action leads."""

from __future__ import annotations

import numpy as np

from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import Maze


def beyond(frame: GridFrame, cell: Cell, action: int) -> tuple[float, float]:
    """Return the centre of the neighbouring place in an action's direction, also where that is no free cell."""
    x_m, y_m = frame.centre_of(cell)
    dx, dy = ((0, 1), (0, -1), (-1, 0), (1, 0))[action]
    return x_m + dx * frame.resolution_m, y_m + dy * frame.resolution_m


def nearest_free_cells(maze: Maze) -> dict[Cell, Cell]:
    """Return for every cell the free cell nearest to it: an estimate in a wall means the floor beside it."""
    free = np.argwhere(~maze.blocked)
    nearest: dict[Cell, Cell] = {}
    for row in range(maze.rows):
        for col in range(maze.cols):
            away = ((free - (row, col)) ** 2).sum(axis=1)
            nearest[Cell(row, col)] = Cell(*(int(i) for i in free[int(away.argmin())]))
    return nearest
