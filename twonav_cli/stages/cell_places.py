"""Cells of the maze as places on the floor: which free cell stands for a place, and where an action leads."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.floor import Floor
from twonav_cli.maze import Maze

HEADINGS = 16
"""Headings that are tried where the robot does not fit at the one it was to have (ours)."""


class Headings:
    """Which way the robot looks where it is put: as the scene says at a start, else any way."""

    def __init__(self, floor: Floor, rng: np.random.Generator) -> None:
        self.rng = rng
        """Where headings are drawn from that the scene does not name."""
        self._known = {floor.maze.starts[name]: pose.theta_rad for name, pose in floor.scene.starts.items()}

    def drawn(self, cell: Cell) -> float:
        """Return a heading, radians."""
        known = self._known.get(cell)
        return float(self.rng.uniform(-np.pi, np.pi)) if known is None else known

    def tried(self, cell: Cell) -> Iterator[float]:
        """Give one heading after the other, radians, until the robot fits; the first is that of `drawn`."""
        first = self.drawn(cell)
        for number in range(HEADINGS):
            yield first + number * (2 * np.pi / HEADINGS)

    def usual(self, cell: Cell) -> float:
        """Return the scene's heading, radians, or 0 where it names none."""
        return self._known.get(cell, 0.0)


def no_room(cell: Cell) -> TwonavError:
    """Return the error of a robot that fits into a cell at no heading."""
    return TwonavError(f"the robot does not fit into the cell {tuple(cell)}, whichever way it looks")


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
