"""A maze of the paper as a Gymnasium environment (§4.3)."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import gymnasium
from gymnasium import spaces

from twonav_cli.config import Rewards
from twonav_cli.environments.drawing import METADATA, check_render_mode, rendered
from twonav_cli.environments.episodes import Episodes, Observation
from twonav_cli.environments.places import Place, action_of, read_maze
from twonav_cli.grid import Cell
from twonav_cli.maze import Action, Maze


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

    metadata = METADATA

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
        check_render_mode(render_mode)
        self.render_mode = render_mode
        self.maze = read_maze(maze, number, seed)
        self._episodes = Episodes(self.maze, goal)
        self.action_space = spaces.Discrete(len(Action))
        self.observation_space = self._episodes.space()
        rows, cols = self.maze.rows, self.maze.cols
        every = [Cell(row, col) for row in range(rows) for col in range(cols)]
        # Lists, since an action looks up single numbers: NumPy would take several times as long.
        number_of = self._episodes.number_of
        self._next = [[number_of(self.maze.moved(cell, action)) for action in Action] for cell in every]
        self._rewards = Rewards()
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
            TwonavError: No such option, start or goal, or one that cannot be reached from the other. The episode before
                then goes on as if nothing had been asked.
        """
        wanted = self._episodes.wanted(options)
        super().reset(seed=seed)
        # Everything is checked: what follows is not refused, so an episode is never half the one before.
        self._goal, start = self._episodes.drawn(wanted, self.np_random)
        self._goal_at = self._episodes.number_of(self._goal.cell)
        self._way = self._episodes.way_to(self._goal.cell)
        at = self._at = self._episodes.number_of(start)
        return self._episodes.observed(at, self._goal), self._info(at, blocked=False)

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
        after = self._at = self._next[before][action_of(action)]
        blocked, arrived = after == before, after == self._goal_at and after != before
        reward = self._rewards.goal if arrived else self._rewards.blocked if blocked else self._rewards.step
        return self._episodes.observed(after, self._goal), reward, arrived, False, self._info(after, blocked)

    def render(self) -> Any:
        """Return the maze as text or as RGB [rows, cols, 3], as the render mode says."""
        if self._at is None:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        return rendered(self.render_mode, self.maze.blocked, self._episodes.cell_of(self._at), self._goal.cell)

    def _info(self, at: int, blocked: bool) -> dict[str, Any]:
        return {
            "cell": divmod(at, self.maze.cols),
            "goal": self._goal.name,
            "goal_cell": tuple(self._goal.cell),
            "blocked": blocked,
            "shortest_way": self._way[at],
        }
