"""A maze of the paper as a Gymnasium environment (§4.3)."""

from __future__ import annotations

from collections.abc import Mapping
from operator import index
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from twonav_cli.config import Rewards
from twonav_cli.environments.drawing import picture_of, text_of
from twonav_cli.environments.places import Place, cell_of, goal_index_of, read_maze
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell
from twonav_cli.maze import UNREACHABLE, Action, Maze

Observation = int | NDArray[np.int64]

RESET_OPTIONS = ("start", "goal")


class MazeEnv(gymnasium.Env[Any, Any]):
    """Find the way to a goal in a maze.

    Actions: Discrete(4): 0 up, 1 down, 2 left, 3 right; a bump leaves the agent in its cell.

    Observations: with one goal Discrete(rows * cols), the number of the agent's cell, row by row, as in FrozenLake.
    With `goal=None` a goal is drawn for every episode, and the observation is MultiDiscrete([rows * cols, goals]): the
    cell's number and the goal's.

    Rewards: 100 for entering the goal's cell, -2 for a bump, -0.1 for every other action (§4.3).

    An episode begins at one of the maze's starts, drawn at random, and ends at the goal. `gymnasium.make` truncates it
    after 500 actions.

    `info`: "cell" (row, col), "goal" its name, "goal_cell" (row, col), "blocked" whether the action was a bump,
    "shortest_way" the number of actions from here to the goal.

    `reset(options={"start": ..., "goal": ...})` sets them for one episode: a name, a number from 0 or (row, col).
    """

    metadata: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 4}  # noqa: RUF012  # Gymnasium's type

    def __init__(
        self,
        maze: str | Maze = "apartment",
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
            TwonavError: No such scene, goal or render mode, or a maze without a goal or start.
        """
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise unknown_name("render mode", render_mode, self.metadata["render_modes"])
        self.render_mode = render_mode
        self.maze = read_maze(maze, number, seed)
        if not self.maze.goals or not self.maze.starts:
            raise TwonavError("the maze has no goal or no start: give it one of each")
        self._fixed_goal = None if goal is None else cell_of("goal", goal, self.maze)
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
            TwonavError: No such option, start or goal, or one that cannot be reached from the other.
        """
        super().reset(seed=seed)
        wanted = dict(options or {})
        for name in wanted:
            if name not in RESET_OPTIONS:
                raise unknown_name("option of reset", str(name), RESET_OPTIONS)
        self._choose_goal(wanted.get("goal"))
        self._at = self._number(self._start(wanted.get("start")))
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
        blocked, arrived = after == before, after == self._goal_number and after != before
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
        return draw(self.maze.blocked, self._cell(self._at), self._goal_cell)

    def _choose_goal(self, wanted: Place | None) -> None:
        """Set the goal of an episode."""
        cells = list(self.maze.goals.values())
        if self._fixed_goal is None:
            drawn = int(self.np_random.integers(len(cells)))
            self._goal = drawn if wanted is None else goal_index_of(wanted, self.maze)
            self._goal_cell, self._goal_name = cells[self._goal], self.maze.goal_names[self._goal]
        else:
            cell = self._fixed_goal if wanted is None else cell_of("goal", wanted, self.maze)
            known = cells.index(cell) if cell in cells else None
            self._goal_cell = cell
            self._goal_name = f"({cell.row}, {cell.col})" if known is None else self.maze.goal_names[known]
        self._goal_number = self._number(self._goal_cell)
        if self._goal_cell not in self._ways:
            self._ways[self._goal_cell] = self.maze.distances_to(self._goal_cell).reshape(-1).tolist()
        self._way = self._ways[self._goal_cell]

    def _start(self, wanted: Place | None) -> Cell:
        """Return the start of an episode: the one asked for, or one of the starts that do not lie on the goal."""
        if wanted is None:
            others = [cell for cell in self.maze.starts.values() if cell != self._goal_cell]
            if not others:
                raise TwonavError(f"every start of the maze lies on goal {self._goal_name!r}: give reset() a start")
            start = others[int(self.np_random.integers(len(others)))]
        else:
            start = cell_of("start", wanted, self.maze)
        if start == self._goal_cell:
            raise TwonavError(f"the start lies on goal {self._goal_name!r}: choose another start")
        if self._way[self._number(start)] == UNREACHABLE:
            raise TwonavError(f"goal {self._goal_name!r} cannot be reached from {tuple(start)}: choose another start")
        return start

    def _observation(self) -> Observation:
        assert self._at is not None
        if self._fixed_goal is not None:
            return self._at
        return np.array([self._at, self._goal], dtype=np.int64)

    def _info(self, blocked: bool) -> dict[str, Any]:
        assert self._at is not None
        return {
            "cell": divmod(self._at, self.maze.cols),
            "goal": self._goal_name,
            "goal_cell": tuple(self._goal_cell),
            "blocked": blocked,
            "shortest_way": self._way[self._at],
        }

    def _number(self, cell: Cell) -> int:
        """Return the number of a cell, row by row."""
        return cell.row * self.maze.cols + cell.col

    def _cell(self, number: int) -> Cell:
        """Return the cell of a number."""
        return Cell(*divmod(number, self.maze.cols))


def _checked(action: int) -> int:
    """Return the action's number."""
    try:
        number = index(action)
    except TypeError:
        number = -1
    if not 0 <= number < len(Action):
        raise TwonavError(f"there is no action {action!r}: 0 is up, 1 down, 2 left, 3 right")
    return number
