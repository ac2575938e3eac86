"""An environment in which a robot drives: what the 2D simulator and the apartment in 3D have in common."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
from gymnasium import spaces

from twonav_cli.config import BASES, Rewards
from twonav_cli.environments.drawing import METADATA, check_render_mode, rendered
from twonav_cli.environments.episodes import Episodes
from twonav_cli.environments.places import Goal, Place, action_of, floor_of
from twonav_cli.errors import unknown_name
from twonav_cli.events import Clock, to_nobody
from twonav_cli.maze import Action
from twonav_cli.navigation.outcomes import REACHED
from twonav_cli.stages.cell_places import nearest_free_cells

if TYPE_CHECKING:
    from twonav_cli.geometry import Pose
    from twonav_cli.stages.sim2d_stage import Sim2dStage
    from twonav_cli.stages.sim3d_stage import Sim3dStage
    from twonav_cli.stages.stage import Observation

SEED = 0
"""Of a stage that is opened. Nothing is drawn from it: every episode draws from the environment's own stream."""

TIME_DIGITS = 6
"""Digits of a time in seconds: two episodes alike give the same, however long the stage has been running (ours)."""


class StageEnv(gymnasium.Env[Any, Any]):
    """Find the way to a goal in a stage; what is observed, and in which stage, the environments say.

    The stage is opened by the first `reset`, so that whatever is wrong with the arguments is said at once.
    """

    metadata = METADATA

    def __init__(
        self, scene: str | Path, goal: Place | None, base: str, map_from: str | None, render_mode: str | None
    ) -> None:
        """Read the floor; the environments explain the arguments.

        Raises:
            TwonavError: No such scene, goal, base, map or render mode, or no start leads to the goal.
        """
        check_render_mode(render_mode)
        if base not in BASES:
            raise unknown_name("base", str(base), BASES)
        self.render_mode = render_mode
        self.floor = floor_of(scene, map_from)
        self.maze = self.floor.maze
        self._base = base
        self._episodes = Episodes(self.maze, goal)
        self.action_space = spaces.Discrete(len(Action))
        self.observation_space = self._episodes.space()
        self._snap = nearest_free_cells(self.maze)
        self._rewards = Rewards()
        self._stage: Sim2dStage | Sim3dStage | None = None
        self._seen: Observation | None = None

    def _opened(self) -> Sim2dStage | Sim3dStage:
        """Open the stage.

        Raises:
            TwonavError: Something that it needs is missing.
        """
        raise NotImplementedError

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin an episode; the first one opens the stage, which takes seconds (and on a new machine compiles first).

        Args:
            seed: Of everything random in the episode: goal, start, heading, odometry and filter. None goes on with the
                random numbers of the episode before.
            options: "start" and "goal" of this episode; what is left out is drawn, or as the environment was made.

        Returns:
            The observation, and what else is known.

        Raises:
            TwonavError: No such option, start or goal, one that cannot be reached from the other, or a start in which
                the robot does not fit. The robot then stays where it was, and so does its goal.
        """
        wanted = self._episodes.wanted(options)
        stage = self._stage = self._stage or self._opened()
        super().reset(seed=seed)
        goal, start = self._episodes.drawn(wanted, self.np_random)
        stage.draw_from(self.np_random)
        seen = stage.place(start)
        self._goal, self._seen = goal, seen
        self._way = self._episodes.way_to(goal.cell)
        self._begun_s, self._touched = stage.time_s, stage.collisions
        return self._observation(seen, goal), self._info(seen)

    def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """Drive to the neighbouring cell, or try to.

        Returns:
            Observation, reward, whether the robot believes to have arrived, False (`gymnasium.make` truncates), what
            else is known.

        Raises:
            TwonavError: There is no such action.
        """
        stage, before = self._stage, self._seen
        if stage is None or before is None:
            raise gymnasium.error.ResetNeeded("call reset() before step()")
        result = stage.act(action_of(action), Clock(), to_nobody)
        seen = self._seen = result.observation
        blocked = result.outcome != REACHED or seen.cell == before.cell
        declared = seen.cell == self._goal.cell
        arrived = declared and seen.true_cell == self._goal.cell
        failed = blocked or declared
        reward = self._rewards.goal if arrived else self._rewards.blocked if failed else self._rewards.step
        info = self._info(seen, result.outcome, blocked, false_arrival=declared and not arrived)
        return self._observation(seen, self._goal), reward, declared, False, info

    def render(self) -> Any:
        """Return the maze as text or as RGB [rows, cols, 3], with the robot where it truly is."""
        if self._seen is None:
            raise gymnasium.error.ResetNeeded("call reset() before render()")
        return rendered(self.render_mode, self.maze.blocked, self._snap[self._seen.true_cell], self._goal.cell)

    def close(self) -> None:
        """Give back what the stage holds; another reset opens it anew."""
        if self._stage is not None:
            self._stage.close()
        self._stage = self._seen = None

    def _observation(self, seen: Observation, goal: Goal) -> Any:
        """Return the number of the cell in which the robot believes to be, with the goal's where goals are drawn."""
        return self._episodes.observed(self._episodes.number_of(seen.cell), goal)

    def _info(
        self, seen: Observation, outcome: str | None = None, blocked: bool = False, false_arrival: bool = False
    ) -> dict[str, Any]:
        """Return what else is known; `outcome` is None before the first action."""
        assert self._stage is not None
        return {
            "cell": tuple(seen.cell),
            "cell_true": tuple(seen.true_cell),
            "goal": self._goal.name,
            "goal_cell": tuple(self._goal.cell),
            "blocked": blocked,
            "shortest_way": self._way[self._episodes.number_of(self._snap[seen.true_cell])],
            "outcome": outcome,
            "pose": numbers_of(seen.pose_true),
            "time_s": round(self._stage.time_s - self._begun_s, TIME_DIGITS),
            "collisions": self._stage.collisions - self._touched,
            "false_arrival": false_arrival,
        }


def numbers_of(pose: Pose | None) -> tuple[float, ...]:
    """Return a pose, which every look of a robot has, as (x_m, y_m, theta_rad)."""
    assert pose is not None
    return tuple(float(number) for number in pose)
