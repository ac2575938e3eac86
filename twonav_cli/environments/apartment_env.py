"""A furnished scene in 3D, with the robot's camera, as a Gymnasium environment (§4.3.1)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from gymnasium import spaces

from twonav_cli.config import IMAGE_PX, LOCALIZERS
from twonav_cli.environments.places import Goal, Place
from twonav_cli.environments.stage_env import SEED, StageEnv, numbers_of
from twonav_cli.errors import unknown_name
from twonav_cli.stages.opening import load_localize, localizer_folder

if TYPE_CHECKING:
    from twonav_cli.stages.sim3d_stage import Sim3dStage
    from twonav_cli.stages.stage import Observation

OBSERVED = ("image", "cell")
"""What an agent is given: the camera's picture, or the number of the cell in which the robot believes to be."""


class ApartmentEnv(StageEnv):
    """Find the way to a goal with a robot in a furnished scene, from its camera.

    Actions are those of `twonav/Maze-v0`: Discrete(4), 0 up, 1 down, 2 left, 3 right on the map, wherever the robot
    looks. The robot drives to the neighbour of the cell in which it believes to be, or tries to.

    Observations: with `observe="image"` the picture that the robot took last, Box(0, 255, (84, 84, 3), uint8), and with
    `goal=None` a Dict of "image" and "goal", the goal's number. With `observe="cell"` as in `twonav/Sim2D-v0`, but of
    the cell in which the robot believes to be.

    The localizer belongs to the robot, not to the agent: it steers by it, whatever the agent observes. So it is the
    robot that declares to have arrived: an episode ends after an action when the robot believes to be in the goal's
    cell, as a trial of `twonav train --stage 3d` does. Outside a simulator nobody tells it the truth, and an episode
    that ended with the truth would tell the agent. The truth decides the reward only: a robot that stands in the goal's
    cell without knowing it goes on, and one that wrongly believes to be there has failed. Whoever wants none of this
    takes `localizer="truth"`.

    Rewards: 100 for arriving in the goal's cell, -2 for declaring to be there when it is not (a false arrival), -2 for
    an action that was blocked, -0.1 for every other one. Blocked is an action whose outcome is not "reached", or after
    which the robot believes to be in the cell in which it believed to be. A false arrival costs no more than a bump,
    since the agent did not choose it; what it loses is the goal's reward.

    An episode begins at one of the scene's starts, drawn at random; `gymnasium.make` truncates it after 200 actions.

    `info` is that of `twonav/Sim2D-v0`: "cell" (row, col) is where the robot believes to be, "cell_true" where it is,
    "pose" where it truly is, "shortest_way" from there, "false_arrival" whether the episode ended with one; and
    "pose_estimate" (x_m, y_m, theta_rad), the localizer's.

    Pictures of `render` show the maze with the robot where it truly is; what it sees is the observation.
    """

    def __init__(
        self,
        scene: str | Path = "apartment",
        goal: Place | None = 0,
        base: str = "omni",
        localizer: str = "filtered",
        observe: str = "image",
        map_from: str | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment of one scene.

        Args:
            scene: Name or path of a scene.
            goal: Name, number from 0 or (row, col); None draws one of the scene's goals for every episode.
            base: "omni" moves in any direction, "differential" only along its heading.
            localizer: Where the robot has its pose from: "filtered" the camera fused with odometry, "raw" each picture
                alone, "truth" the simulator.
            observe: What the agent is given: "image" or "cell".
            map_from: "survey" or "geometry"; None takes the map that the robot made where there is one.
            render_mode: "ansi" for text, "rgb_array" for a picture of the maze, None for neither.

        Raises:
            TwonavError: No such scene, goal, base, localizer, observation, map or render mode, no start leads to the
                goal, or the scene has no localizer yet.
        """
        for kind, name, right in (("localizer", localizer, LOCALIZERS), ("observation", observe, OBSERVED)):
            if name not in right:
                raise unknown_name(kind, str(name), right)
        super().__init__(scene, goal, base, map_from, render_mode)
        self._localizer, self._observe = localizer, observe
        if localizer != "truth":
            # Known to be there before anything is built.
            localizer_folder(self.floor)
        if observe == "image":
            self.observation_space = self._image_space()

    def _image_space(self) -> spaces.Space[Any]:
        image = spaces.Box(0, 255, (IMAGE_PX, IMAGE_PX, 3), np.uint8)
        if not self._episodes.draws_goals:
            return image
        return spaces.Dict({"image": image, "goal": spaces.Discrete(len(self.maze.goals))})

    def _opened(self) -> Sim3dStage:
        from twonav_cli.stages.sim3d_stage import Sim3dOptions, Sim3dStage

        localize = None
        if self._localizer != "truth":
            localize = load_localize(self.floor, filtered=self._localizer == "filtered", seed=SEED)
        return Sim3dStage(self.floor, localize, SEED, Sim3dOptions(base=self._base))

    def _observation(self, seen: Observation, goal: Goal) -> Any:
        """Return the picture [84, 84, 3], with the goal's number where goals are drawn; or the cell's number."""
        if self._observe == "cell":
            return super()._observation(seen, goal)
        if not self._episodes.draws_goals:
            return seen.image
        return {"image": seen.image, "goal": goal.number}

    def _info(
        self, seen: Observation, outcome: str | None = None, blocked: bool = False, false_arrival: bool = False
    ) -> dict[str, Any]:
        known = super()._info(seen, outcome, blocked, false_arrival)
        return {**known, "pose_estimate": numbers_of(seen.pose_estimate)}
