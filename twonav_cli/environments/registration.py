"""Makes the environments known to Gymnasium.

Gymnasium 1.0 has dropped entry points: an environment is known once its module is imported. So either of these:

    import twonav_cli.environments
    gymnasium.make("twonav/Maze-v0")

    gymnasium.make("twonav_cli.environments:twonav/Maze-v0")
"""

from __future__ import annotations

import gymnasium

from twonav_cli.config import LEARNING_PRESETS

MAZE_ID = "twonav/Maze-v0"
SIM2D_ID = "twonav/Sim2D-v0"
APARTMENT_ID = "twonav/Apartment-v0"

EPISODE_STEPS_AT_MOST = 500
"""Actions after which an episode is truncated, as a trial fails in the maze (ours)."""

ENVIRONMENTS = {
    MAZE_ID: ("maze_env:MazeEnv", EPISODE_STEPS_AT_MOST),
    SIM2D_ID: ("sim2d_env:Sim2dEnv", LEARNING_PRESETS["2d"].trial_limit_steps),
    APARTMENT_ID: ("apartment_env:ApartmentEnv", LEARNING_PRESETS["3d"].trial_limit_steps),
}
"""Id to the class, and the actions after which an episode is truncated: those after which a trial fails there."""


def register() -> None:
    """Register the environments; doing so twice changes nothing."""
    for name, (place, steps_at_most) in ENVIRONMENTS.items():
        if name not in gymnasium.registry:
            gymnasium.register(name, entry_point=f"twonav_cli.environments.{place}", max_episode_steps=steps_at_most)
