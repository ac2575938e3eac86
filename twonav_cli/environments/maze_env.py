"""A maze of the paper as a Gymnasium environment (§4.3)."""

from __future__ import annotations

from collections.abc import Mapping
from operator import index
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from twonav_cli.config import Rewards
from twonav_cli.environments.drawing import picture_of, text_of
from twonav_cli.environments.places import Goal, Place, goal_of, numbered_goal_of, read_maze, start_of
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell
from twonav_cli.maze import Action, Maze

Observation = int | NDArray[np.int64]

RESET_OPTIONS = ("start", "goal")


class MazeEnv(gymnasium.Env[Any, Any]):
    """Find the way to a goal in a maze.

    Actions: Discrete(4): 0 up, 1 down, 2 left, 3 right; a bump leaves the agent in its cell.

    Observations: with one goal Discrete(rows * cols), the number of the agent's cell, row by row, as in FrozenLake.
    With `goal=None` a goal is drawn for every episode, and the observation is MultiDiscrete([rows * cols, goals]): the
    cell's number and the goal's.

    Rewards: 100 for entering the goal's cell, -2 for a bump, -0.1 for every other action (§4.3).

    An episode begins at one of the maze's starts, drawn at random, and ends at the goal. Start and goal are drawn among
    those that lie in different cells with a way between them. `gymnasium.make` truncates an episode after 500 actions.

    `info`: "cell" (row, col), "goal" its name, "goal_cell" (row, col), "blocked" whether the action was a bump,
    "shortest_way" the number of actions from here to the goal.

    `reset(options={"start": ..., "goal": ...})` sets them for one episode: a name, a number from 0 or (row, col).
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 4}  # noqa: RUF012  # Gymnasium's type

    def __init__(
        self,
        maze: str | Path | Maze = "apartment",
        goal: Place | None = 0,
        number: int = 0,
        seed: int = 0,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment of one maze.

        Args:
            maze: Name or path of a scene, "random", or a maze of one's own.
            goal: Name, number from 0 or (row, col); None draws one of the maze's goals for every episode.
            number: Which of the random mazes of `seed`; other mazes do not need it.
            seed: Of the random mazes. What happens in an episode is seeded by `reset`.
            render_mode: "ansi" for text, "rgb_array" for a picture, None for neither.

        Raises:
            TwonavError: No such scene, goal or render mode, or a maze without a start that leads to the goal.
        """
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise unknown_name("render mode", str(render_mode), self.metadata["render_modes"])
        self.render_mode = render_mode
        self.maze = read_maze(maze, number, seed)
        if not self.maze.goals or not self.maze.starts:
            raise TwonavError("the maze has no goal or no start: give it one of each")
        self._fixed_goal = None if goal is None else goal_of(goal, self.maze)
        self._every_goal = [goal_of(number, self.maze) for number in range(len(self.maze.goals))]
        cells = self.maze.rows * self.maze.cols
        self.action_space = spaces.Discrete(len(Action))
        self.observation_space = (
            spaces.MultiDiscrete([cells, len(self.maze.goals)]) if goal is None else spaces.Discrete(cells)
        )
        rows, cols = self.maze.rows, self.maze.cols
        every = [Cell(row, col) for row in range(rows) for col in range(cols)]
        # Lists, since an action looks up single numbers: NumPy would take several times as long.
        self._next = [[self._number(self.maze.moved(cell, action)) for action in Action] for cell in every]
        self._rewards = Rewards()
        self._ways: dict[Cell, list[int]] = {}
        self._at: int | None = None
        self._goals_from(None, None)

    def reset(
        self, *, seed: int | None = None, options: Mapping[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Args:
            seed: None goes on with the random numbers of the episode before.
            options: "start" and "goal" of this episode; what is left out is drawn, or as the environment was made.

        Returns:
            The observation, and what else is known.

        Raises:
            TwonavError: No such option, start or goal, or one that cannot be reached from the other. The episode before
                then goes on as if nothing had been asked.
        """
        wanted_start, wanted_goal = _read_options(options)
        start = None if wanted_start is None else start_of(wanted_start, self.maze)
        goals = self._goals_from(start, wanted_goal)
        super().reset(seed=seed)
        # Everything is checked: what follows is not refused, so an episode is never half the one before.
        self._goal = goals[int(self.np_random.integers(len(goals)))]
        self._goal_at = self._number(self._goal.cell)
        self._way = self._way_to(self._goal.cell)
        starts = self._starts_to(self._goal, start)
        self._at = self._number(starts[int(self.np_random.integers(len(starts)))])
        return self._observation(), self._info(blocked=False)

    def step(self, action: int) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Carry out an action.

        Returns:
            Observation, reward, whether the goal is reached, False (`gymnasium.make` truncates), what else is known.

        Raises:
            TwonavError: There is no such action.
        """
        before = self._at
        if before is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        after = self._at = self._next[before][_checked(action)]
        blocked, arrived = after == before, after == self._goal_at and after != before
        reward = self._rewards.goal if arrived else self._rewards.blocked if blocked else self._rewards.step
        return self._observation(), reward, arrived, False, self._info(blocked)

    def render(self) -> Any:
        """Return the maze as text or as RGB [rows, cols, 3], as the render mode says."""
        if self._at is None:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        if self.render_mode is None:
            gymnasium.logger.warn('render() shows nothing without a render mode: make(..., render_mode="ansi")')
            return None
        draw = text_of if self.render_mode == "ansi" else picture_of
        return draw(self.maze.blocked, self._cell(self._at), self._goal.cell)

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
        way = self._way_to(goal.cell)
        starts = self.maze.starts.values() if start is None else [start]
        # On the goal the way is 0 long, and UNREACHABLE is less.
        return [cell for cell in starts if way[self._number(cell)] > 0]

    def _way_to(self, cell: Cell) -> list[int]:
        """Return the length of the shortest way to a cell from the cell of every number."""
        if cell not in self._ways:
            self._ways[cell] = self.maze.distances_to(cell).reshape(-1).tolist()
        return self._ways[cell]

    def _observation(self) -> Observation:
        assert self._at is not None
        if self._fixed_goal is not None:
            return self._at
        return np.array([self._at, self._goal.number], dtype=np.int64)

    def _info(self, blocked: bool) -> dict[str, Any]:
        assert self._at is not None
        return {
            "cell": divmod(self._at, self.maze.cols),
            "goal": self._goal.name,
            "goal_cell": tuple(self._goal.cell),
            "blocked": blocked,
            "shortest_way": self._way[self._at],
        }

    def _number(self, cell: Cell) -> int:
        """Return the number of a cell, row by row."""
        return cell.row * self.maze.cols + cell.col

    def _cell(self, number: int) -> Cell:
        """Return the cell of a number."""
        return Cell(*divmod(number, self.maze.cols))


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


def _checked(action: int) -> int:
    """Return the action's number."""
    try:
        number = index(action)
    except TypeError:
        number = -1
    if not 0 <= number < len(Action):
        raise TwonavError(f"there is no action {action!r}: 0 is up, 1 down, 2 left, 3 right")
    return number
