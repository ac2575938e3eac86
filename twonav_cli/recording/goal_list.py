"""The goals of a recording in the order of the tables: those of the maze, then those that were added on the way."""

from __future__ import annotations

from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import Maze


class GoalList:
    """Names and places of goals; it grows.

    Attributes:
        at_start: Number of goals that the run began with.
    """

    def __init__(self, maze: Maze, frame: GridFrame) -> None:
        self._cells = dict(maze.goals)
        self._frame = frame
        self.at_start = len(maze.goals)

    def __len__(self) -> int:
        return len(self._cells)

    def __contains__(self, name: str) -> bool:
        return name in self._cells

    @property
    def names(self) -> list[str]:
        """Names of the goals [G]."""
        return list(self._cells)

    def add(self, name: str, cell: Cell) -> None:
        """Append a goal."""
        self._cells[name] = cell

    def name_of(self, index: int) -> str:
        """Return the name of a column of the tables; of one that nobody announced, its number."""
        return self.names[index] if index < len(self) else f"goal {index + 1}"

    def positions(self) -> list[tuple[float, float]]:
        """Return the position of every goal [G, 2] in the map frame, metres."""
        return [self._frame.centre_of(cell) for cell in self._cells.values()]

    def position_of(self, name: str) -> tuple[float, float] | None:
        """Return where a goal is in the map frame, metres; None when nobody said."""
        return self._frame.centre_of(self._cells[name]) if name in self._cells else None
