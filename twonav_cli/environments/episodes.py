"""Which episodes there can be in a maze: what is asked for, drawn and observed of goal, start and cells.

G goals, R rows, C columns.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from twonav_cli.environments.places import Goal, Place, goal_of, numbered_goal_of, start_of
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell
from twonav_cli.maze import Maze

Observation = int | NDArray[np.int64]

RESET_OPTIONS = ("start", "goal")


@dataclass(frozen=True)
class Wanted:
    """What an episode is drawn among.

    Attributes:
        goals: One at least; to each there is a way from the start.
        start: None for any of the maze's starts.
    """

    goals: list[Goal]
    start: Cell | None


class Episodes:
    """The goals and starts of a maze that belong together, and the cells as numbers."""

    def __init__(self, maze: Maze, goal: Place | None) -> None:
        """Find out which episodes there can be.

        Args:
            maze: Where.
            goal: Name, number from 0 or (row, col); None draws one of the maze's goals for every episode.

        Raises:
            TwonavError: No such goal, or a maze without a start that leads to it.
        """
        self.maze = maze
        if not maze.goals or not maze.starts:
            raise TwonavError("the maze has no goal or no start: give it one of each")
        self._fixed_goal = None if goal is None else goal_of(goal, maze)
        self._every_goal = [goal_of(number, maze) for number in range(len(maze.goals))]
        self._ways: dict[Cell, list[int]] = {}
        self._goals_from(None, None)

    @property
    def draws_goals(self) -> bool:
        """Whether every episode has another goal, which the observation then has to name."""
        return self._fixed_goal is None

    def space(self) -> spaces.Space[Any]:
        """Return the space of `observed`: Discrete(R * C), or MultiDiscrete([R * C, G]) where goals are drawn."""
        cells = self.maze.rows * self.maze.cols
        return spaces.MultiDiscrete([cells, len(self.maze.goals)]) if self.draws_goals else spaces.Discrete(cells)

    def observed(self, number: int, goal: Goal) -> Observation:
        """Return a cell's number, with the goal's beside it [2] where goals are drawn."""
        if self._fixed_goal is not None:
            return number
        return np.array([number, goal.number], dtype=np.int64)

    def wanted(self, options: Mapping[str, Any] | None) -> Wanted:
        """Return what reset() is asked for.

        Raises:
            TwonavError: No such option, start or goal, or one that cannot be reached from the other.
        """
        wanted_start, wanted_goal = _read_options(options)
        start = None if wanted_start is None else start_of(wanted_start, self.maze)
        return Wanted(self._goals_from(start, wanted_goal), start)

    def drawn(self, wanted: Wanted, rng: np.random.Generator) -> tuple[Goal, Cell]:
        """Return the goal of an episode and the cell in which it begins."""
        goal = wanted.goals[int(rng.integers(len(wanted.goals)))]
        starts = self._starts_to(goal, wanted.start)
        return goal, starts[int(rng.integers(len(starts)))]

    def way_to(self, cell: Cell) -> list[int]:
        """Return the length of the shortest way to a cell from the cell of every number."""
        # A list, since an action looks up a single number: NumPy would take several times as long.
        if cell not in self._ways:
            self._ways[cell] = self.maze.distances_to(cell).reshape(-1).tolist()
        return self._ways[cell]

    def number_of(self, cell: Cell) -> int:
        """Return the number of a cell, row by row."""
        return cell.row * self.maze.cols + cell.col

    def cell_of(self, number: int) -> Cell:
        """Return the cell of a number."""
        return Cell(*divmod(number, self.maze.cols))

    def _goals_from(self, start: Cell | None, wanted: Place | None) -> list[Goal]:
        """Return the goals that an episode can have, one at least, from this start or else from any of the maze's.

        Raises:
            TwonavError: The wanted goal is none, or there is no way.
        """
        asked = self._fixed_goal
        if wanted is not None:
            asked = numbered_goal_of(wanted, self.maze) if asked is None else goal_of(wanted, self.maze)
        goals = [goal for goal in (self._every_goal if asked is None else [asked]) if self._starts_to(goal, start)]
        if not goals:
            raise _no_way(start, asked)
        return goals

    def _starts_to(self, goal: Goal, start: Cell | None) -> list[Cell]:
        """Return the starts that do not lie on a goal and lead to it: of this one, or else of all."""
        way = self.way_to(goal.cell)
        starts = self.maze.starts.values() if start is None else [start]
        # On the goal the way is 0 long, and UNREACHABLE is less.
        return [cell for cell in starts if way[self.number_of(cell)] > 0]


def _read_options(options: Mapping[str, Any] | None) -> tuple[Place | None, Place | None]:
    """Return the start and the goal that reset() is asked for."""
    if options is None:
        return None, None
    if not isinstance(options, Mapping):
        raise TwonavError(f'the options of reset() must be a dict such as {{"start": 0}}: {options!r} was given')
    for name in options:
        if name not in RESET_OPTIONS:
            raise unknown_name("option of reset", str(name), RESET_OPTIONS)
    return options.get("start"), options.get("goal")


def _no_way(start: Cell | None, goal: Goal | None) -> TwonavError:
    """Return the error for a start and a goal, None for any of the maze's, without a way between them."""
    if start is None:
        which = "any goal" if goal is None else f"goal {goal.name!r}"
        return TwonavError(f"no start of the maze leads to {which}: choose another goal or give a start that does")
    if goal is None:
        return TwonavError(f"no goal away from {tuple(start)} can be reached from there: choose another start")
    if start == goal.cell:
        return TwonavError(f"the start lies on goal {goal.name!r}: choose another start")
    return TwonavError(f"goal {goal.name!r} cannot be reached from {tuple(start)}: choose another start")
