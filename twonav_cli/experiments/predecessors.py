"""What a command starts from: a checkpoint (the one named, the shipped one, or one of the user's own runs) and a stage.

Everything heavy is imported when it is loaded. Where checkpoints lie and how a stage is opened the environments need
too, so that stands in layers before theirs; commands find all of it here.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from twonav_cli.checkpoint_folders import checkpoint_folder, localizer_name
from twonav_cli.errors import TwonavError
from twonav_cli.stages.opening import free_floor, load_localize, make_stage

if TYPE_CHECKING:
    from twonav_cli.learner.agent import Agent
    from twonav_cli.mapping.floor import Floor

__all__ = [
    "STAGE_BEFORE",
    "checkpoint_folder",
    "free_floor",
    "load_agent",
    "load_localize",
    "localizer_name",
    "make_stage",
]

STAGE_BEFORE = {"2d": "maze", "3d": "2d"}
"""The stage whose agent a stage goes on from (§3.2)."""


def load_agent(floor: Floor, stage: str, chosen: Path | None = None, own_first: bool = False) -> Agent:
    """Load the agent that knows most about a stage: its own, else that of the nearest stage before which there is one.

    The learning settings are those of `stage`, whichever agent it is. What was experienced there and in the stages
    before stays known for `Agent.add_goal`; on what a later stage tried, it counts alone.

    Raises:
        TwonavError: No checkpoint, or one that is damaged or belongs to another scene or map.
    """
    from twonav_cli.config import learning_preset
    from twonav_cli.learner.agent import Agent

    def folder_of(name: str) -> Path:
        scene, digest = floor.scene, floor.map.digest
        return checkpoint_folder(scene.name, name, chosen, own_first, scene.digest, digest, floor.map_source)

    digests = floor.scene.digest, floor.map.digest
    found, folder = stage, None
    while folder is None:
        try:
            folder = folder_of(found)
        except TwonavError:
            if found not in STAGE_BEFORE:
                raise  # about the first stage of all: there training begins
            found = STAGE_BEFORE[found]
    agent = Agent.load(folder, *digests, learning_preset(stage))
    if found == stage:
        agent.earlier_here, agent.earlier_elsewhere = agent.earlier_elsewhere, agent.earlier_here
    before = STAGE_BEFORE.get(found)
    while before is not None:
        # Without it the agent only knows less for a new goal, so nothing that is wrong with it stops the stage.
        with contextlib.suppress(TwonavError):
            further = Agent.load(folder_of(before), *digests).replay
            agent.earlier_elsewhere = agent.earlier_elsewhere.filled_from(further)
        before = STAGE_BEFORE.get(before)
    return agent
