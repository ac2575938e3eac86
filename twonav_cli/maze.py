"""A maze: blocked and free cells, named goals and starts, and what follows from them.

R rows, C columns, A = 4 actions (up, down, left, right), G goals.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field, replace
from enum import IntEnum
from operator import index

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell

UNREACHABLE = -1


class Action(IntEnum):
    """The four actions, in the order of every Q-table (§3.1.1)."""

    UP = 0
    DOWN = 1
    LEFT = 2
    RIGHT = 3


OFFSETS: tuple[tuple[int, int], ...] = ((-1, 0), (1, 0), (0, -1), (0, 1))
"""Row and column step of each action."""


@dataclass(frozen=True)
class Maze:
    """Free and blocked cells with the goals and starts of the learning experiments.

    Attributes:
        blocked: [R, C] bool, True where the agent cannot be.
        goals: Name to cell; the order is the order of every table with a goal axis.
        starts: Name to cell.
    """

    blocked: NDArray[np.bool_]
    goals: dict[str, Cell]
    starts: dict[str, Cell]
    _distances: dict[Cell, NDArray[np.int32]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        for kind, cells in (("goal", self.goals), ("start", self.starts)):
            read = {}
            for name, place in cells.items():
                try:
                    row, col = place
                    cell = read[name] = Cell(index(row), index(col))
                except (TypeError, ValueError):
                    raise TwonavError(f"{kind} {name!r} is no cell ({place!r}): give (row, col)") from None
                inside = 0 <= cell.row < self.rows and 0 <= cell.col < self.cols
                if not inside or self.blocked[cell]:
                    raise TwonavError(f"{kind} {name!r} lies in a blocked cell {tuple(cell)}: move it to free floor")
            # A maze of one's own is written with plain pairs; everything after asks for cell.row and cell.col.
            object.__setattr__(self, f"{kind}s", read)

    @property
    def rows(self) -> int:
        """Number of rows."""
        return int(self.blocked.shape[0])

    @property
    def cols(self) -> int:
        """Number of columns."""
        return int(self.blocked.shape[1])

    @property
    def goal_names(self) -> list[str]:
        """Names of the goals in table order."""
        return list(self.goals)

    @property
    def free_cells(self) -> list[Cell]:
        """Every free cell, row by row."""
        return [Cell(int(r), int(c)) for r, c in np.argwhere(~self.blocked)]

    def with_goal(self, name: str, cell: Cell) -> Maze:
        """Return the maze with one goal more, the last one.

        Raises:
            TwonavError: The name is taken, or the cell is blocked.
        """
        if name in self.goals:
            raise TwonavError(f"there is a goal {name!r} already: choose another name")
        return replace(self, goals={**self.goals, name: cell})

    def moved(self, cell: Cell, action: int) -> Cell:
        """Return the cell that an action leads to; a bump leaves the agent where it is."""
        row, col = cell.row + OFFSETS[action][0], cell.col + OFFSETS[action][1]
        free = 0 <= row < self.rows and 0 <= col < self.cols and not self.blocked[row, col]
        return Cell(row, col) if free else cell

    def distances_to(self, goal: Cell) -> NDArray[np.int32]:
        """Return the length of the shortest way to `goal` from every cell [R, C]; UNREACHABLE where there is none.

        It is searched for once, and what is returned cannot be written to.
        """
        if goal not in self._distances:
            distances = distances_from(self.blocked, goal)
            distances.setflags(write=False)
            self._distances[goal] = distances
        return self._distances[goal]


def distances_from(blocked: NDArray[np.bool_], source: Cell) -> NDArray[np.int32]:
    """Return the number of moves from `source` to every cell [R, C] by breadth-first search."""
    distance = np.full(blocked.shape, UNREACHABLE, dtype=np.int32)
    if blocked[source]:
        return distance
    distance[source] = 0
    queue = deque([source])
    while queue:
        cell = queue.popleft()
        for d_row, d_col in OFFSETS:
            row, col = cell.row + d_row, cell.col + d_col
            if not (0 <= row < blocked.shape[0] and 0 <= col < blocked.shape[1]):
                continue
            if not blocked[row, col] and distance[row, col] == UNREACHABLE:
                distance[row, col] = distance[cell] + 1
                queue.append(Cell(row, col))
    return distance


def filled_where_unreachable(blocked: NDArray[np.bool_], source: Cell) -> NDArray[np.bool_]:
    """Return the maze [R, C] with every cell blocked that cannot be reached from `source` (§4.3)."""
    return np.asarray(distances_from(blocked, source) == UNREACHABLE)
