"""The maze as a stage: every action does what it says, and the agent knows where it is."""

from __future__ import annotations

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Sink
from twonav_cli.grid import Cell
from twonav_cli.maze import Maze
from twonav_cli.navigation.outcomes import BLOCKED, REACHED
from twonav_cli.stages.stage import ActionResult, Observation


class MazeStage:
    """Cells and walls; time stands still."""

    name = "maze"

    def __init__(self, maze: Maze) -> None:
        self.maze = maze
        self._cell: Cell | None = None

    def close(self) -> None:
        """Nothing to give back."""

    @property
    def time_s(self) -> float:
        """Always 0: a maze has no clock."""
        return 0.0

    def draw_from(self, rng: np.random.Generator) -> None:
        """Nothing is random in a maze."""

    def place(self, cell: Cell) -> Observation:
        """Put the robot into a free cell.

        Raises:
            TwonavError: The cell is blocked or outside.
        """
        inside = 0 <= cell.row < self.maze.rows and 0 <= cell.col < self.maze.cols
        if not inside or self.maze.blocked[cell]:
            raise TwonavError(f"the robot cannot start in the blocked cell {tuple(cell)}: choose a free one")
        self._cell = cell
        return Observation(cell, cell)

    def carry(self, cell: Cell) -> Observation:
        """Put the robot into another free cell; in a maze it knows at once where it is.

        Raises:
            TwonavError: The cell is blocked or outside.
        """
        return self.place(cell)

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        """Move to the neighbouring cell, or stay where a wall is.

        Raises:
            TwonavError: The robot was not placed yet.
        """
        if self._cell is None:
            raise TwonavError("the robot stands nowhere yet: place it in a cell first")
        cell = self.maze.moved(self._cell, action)
        outcome = BLOCKED if cell == self._cell else REACHED
        self._cell = cell
        return ActionResult(outcome, Observation(cell, cell))
