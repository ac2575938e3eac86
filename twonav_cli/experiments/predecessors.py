"""What a command starts from: a checkpoint (the one named, the shipped one, or one of the user's own runs) and a stage.

Everything heavy is imported when it is loaded.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.checkpoint import CARD_FILE, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.paths import checkpoints_dir, runs_dir

if TYPE_CHECKING:
    from twonav_cli.learner.agent import Agent
    from twonav_cli.mapping.floor import Floor
    from twonav_cli.stages.maze_stage import MazeStage
    from twonav_cli.stages.sim3d_stage import Sim3dOptions, Sim3dStage

Localize = Callable[[NDArray[np.uint8]], Pose]

STAGE_BEFORE = {"3d": "maze"}
"""The stage whose agent a stage goes on from (2d comes between them once it exists)."""


def checkpoint_folder(
    scene: str,
    name: str,
    chosen: Path | None = None,
    own_first: bool = False,
    scene_digest: str | None = None,
    map_digest: str | None = None,
    map_source: str | None = None,
) -> Path:
    """Return the folder of a scene's checkpoint.

    Args:
        scene: Name of the scene.
        name: "maze", "3d" or "localizer".
        chosen: Folder of a scene's checkpoints that the user named; then only this one counts.
        own_first: Whether a run of the user's own goes before the shipped one (training does, playing does not).
        scene_digest: The scene it should be for: one that is for another scene of that name comes last.
        map_digest: The map it should be for: one of the same scene on another map comes after one on this.
        map_source: Where that map comes from, for the command in the message; "survey" is what training takes itself.

    Raises:
        TwonavError: There is none; the message says which command makes it.
    """
    shipped, own = checkpoints_dir() / scene / name, runs_dir() / scene / name
    candidates = [chosen / name] if chosen is not None else [own, shipped] if own_first else [shipped, own]
    found = [folder for folder in candidates if (folder / CARD_FILE).is_file()]
    if found:
        # Of several that fit equally well `max` returns the first.
        return max(found, key=lambda folder: _fit_of(folder, scene_digest, map_digest))
    where = f"in {chosen}" if chosen is not None else f"for scene {scene!r}"
    command = f"twonav train --stage {name} --scene {scene}"
    command += " --map-from geometry" if map_source == "geometry" else ""
    raise TwonavError(f"there is no {name} checkpoint {where}: make it with `{command}`")


def _fit_of(folder: Path, scene_digest: str | None, map_digest: str | None) -> int:
    """Return 2 for a checkpoint of the scene and the map, 1 for one of the scene, else 0.

    One that cannot be read is left for the loader to refuse. A localizer that says no map fits every map.
    """
    if scene_digest is None:
        return 2
    try:
        card = read_card(folder)
    except TwonavError:
        return 0
    if card.get("scene_digest") != scene_digest:
        return 0
    return 2 if map_digest is None or card.get("map_digest") in (None, map_digest) else 1


def load_agent(floor: Floor, stage: str, chosen: Path | None = None, own_first: bool = False) -> Agent:
    """Load the agent that knows most about a stage: its own, else that of the stage before.

    The learning settings are those of `stage`, whichever agent it is. What the agent of either stage experienced stays
    known for `Agent.add_goal`.

    Raises:
        TwonavError: No checkpoint, or one that is damaged or belongs to another scene or map.
    """
    from twonav_cli.config import learning_preset
    from twonav_cli.learner.agent import Agent

    def folder_of(name: str) -> Path:
        scene, digest = floor.scene, floor.map.digest
        return checkpoint_folder(scene.name, name, chosen, own_first, scene.digest, digest, floor.map_source)

    digests, before = (floor.scene.digest, floor.map.digest), STAGE_BEFORE.get(stage)
    try:
        folder = folder_of(stage)
    except TwonavError:
        if before is None:
            raise
        return Agent.load(folder_of(before), *digests, learning_preset(stage))
    agent = Agent.load(folder, *digests, learning_preset(stage))
    agent.earlier_here, agent.earlier_elsewhere = agent.earlier_elsewhere, agent.earlier_here
    if before is not None:
        # Without it the agent only knows less for a new goal, so nothing that is wrong with it stops the stage.
        with contextlib.suppress(TwonavError):
            agent.earlier_elsewhere = Agent.load(folder_of(before), *digests).replay
    return agent


def load_localize(floor: Floor, chosen: Path | None = None, own_first: bool = False) -> Localize:
    """Load the scene's localizer as a function from an image [84, 84, 3] to a pose.

    Raises:
        TwonavError: No checkpoint, or one that is damaged or belongs to another scene.
    """
    from twonav_cli.localizer.estimator import Estimator

    scene, digest = floor.scene, floor.map.digest
    folder = checkpoint_folder(scene.name, "localizer", chosen, own_first, scene.digest, digest, floor.map_source)
    estimator = Estimator.load(folder, floor.scene.digest)
    return lambda image: estimator.estimate(image).pose


def make_stage(
    floor: Floor, name: str, localize: Localize | None, seed: int, options: Sim3dOptions | None = None
) -> MazeStage | Sim3dStage:
    """Return a stage by name; `localize` None takes the simulator's truth.

    Raises:
        TwonavError: No renderer, or the scene cannot be simulated.
    """
    if name == "maze":
        from twonav_cli.stages.maze_stage import MazeStage

        return MazeStage(floor.maze)
    from twonav_cli.stages.sim3d_stage import Sim3dStage

    return Sim3dStage(floor, localize, seed, options)
