"""Makes the environments known to Gymnasium.

Gymnasium 1.0 has dropped entry points: an environment is known once its module is imported. So either of these:

    import twonav_cli.environments
    gymnasium.make("twonav/Maze-v0")

    gymnasium.make("twonav_cli.environments:twonav/Maze-v0")
"""

from __future__ import annotations

import gymnasium

MAZE_ID = "twonav/Maze-v0"

EPISODE_STEPS_AT_MOST = 500
"""Actions after which an episode is truncated, as a trial fails in the maze (ours)."""


def register() -> None:
    """Register the environments; doing so twice changes nothing."""
    if MAZE_ID not in gymnasium.registry:
        gymnasium.register(
            MAZE_ID,
            entry_point="twonav_cli.environments.maze_env:MazeEnv",
            max_episode_steps=EPISODE_STEPS_AT_MOST,
        )
