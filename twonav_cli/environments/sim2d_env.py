"""The 2D simulator of a scene's floor as a Gymnasium environment (§4.3.1)."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from twonav_cli.environments.places import Place
from twonav_cli.environments.stage_env import SEED, StageEnv

if TYPE_CHECKING:
    from twonav_cli.stages.sim2d_stage import Sim2dStage


class Sim2dEnv(StageEnv):
    """Find the way to a goal with a robot that has an outline and a controller, on a scene's map.

    Actions, observations and the options of `reset` are those of `twonav/Maze-v0`: Discrete(4), 0 up, 1 down, 2 left,
    3 right; the number of the robot's cell, and with `goal=None` the goal's number beside it. The robot knows where it
    is: its cell is the free cell nearest to its pose. An action drives to the neighbouring cell, or tries to.

    Rewards: 100 for arriving in the goal's cell, -2 for an action that was blocked, -0.1 for every other one (§4.3).
    Blocked is an action whose outcome is not "reached", or after which the robot is in the cell in which it was.

    An episode begins at one of the scene's starts, drawn at random, and ends in the goal's cell. `gymnasium.make`
    truncates it after 500 actions. About once in a thousand actions the robot stops over a blocked cell beside its own.
    Where its own is the goal's, that is no arrival, as for `twonav evaluate --stage 2d`: the episode ends, the reward
    is -2, and "false_arrival" is True.

    `info`: "cell" (row, col), "goal" its name, "goal_cell" (row, col), "blocked", "shortest_way" the number of actions
    from here to the goal in the maze, as in `twonav/Maze-v0`; "outcome" of the action, "reached", "blocked" or
    "timed-out", None before the first; "pose" (x_m, y_m, theta_rad) on the map; "time_s" simulated and "collisions",
    the control periods that ended at something, both in this episode; "cell_true" (row, col) over which the robot
    stands, free or not; "false_arrival".
    """

    def __init__(
        self,
        scene: str | Path = "apartment",
        goal: Place | None = 0,
        base: str = "omni",
        map_from: str | None = None,
        render_mode: str | None = None,
    ) -> None:
        """Make the environment of one scene.

        Args:
            scene: Name or path of a scene.
            goal: Name, number from 0 or (row, col); None draws one of the scene's goals for every episode.
            base: "omni" moves in any direction, "differential" only along its heading.
            map_from: "survey" or "geometry"; None takes the map that the robot made where there is one.
            render_mode: "ansi" for text, "rgb_array" for a picture of the maze, None for neither.

        Raises:
            TwonavError: No such scene, goal, base, map or render mode, or no start leads to the goal.
        """
        super().__init__(scene, goal, base, map_from, render_mode)

    def _opened(self) -> Sim2dStage:
        from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage

        return Sim2dStage(self.floor, SEED, Sim2dOptions(base=self._base))
