"""What a command starts from: a checkpoint (the one named, the shipped one, or one of the user's own runs) and a stage.

Everything heavy is imported when it is loaded.
"""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from twonav_cli.checkpoint import CARD_FILE, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.paths import checkpoints_dir, runs_dir
from twonav_cli.rng import stream

if TYPE_CHECKING:
    from twonav_cli.belief import Belief
    from twonav_cli.learner.agent import Agent
    from twonav_cli.localizer.belief_filter import BeliefFilter, FreeFloor
    from twonav_cli.mapping.floor import Floor
    from twonav_cli.stages.localize import Image, Localize
    from twonav_cli.stages.maze_stage import MazeStage
    from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage
    from twonav_cli.stages.sim3d_stage import Sim3dOptions, Sim3dStage

OURS = "belief"
"""Our own network, as `localizer.networks` names it."""

STAGE_BEFORE = {"2d": "maze", "3d": "2d"}
"""The stage whose agent a stage goes on from (§3.2)."""


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
        name: "maze", "2d", "3d" or "localizer".
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
    stage, _, network = name.partition("-")
    command = f"twonav train --stage {stage} --scene {scene}" + (f" --network {network}" if network else "")
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


def localizer_name(network: str | None) -> str:
    """Return the checkpoint's name of a localizer: ours is "localizer", the paper's say which network they are."""
    return "localizer" if network in (None, OURS) else f"localizer-{network}"


def load_agent(floor: Floor, stage: str, chosen: Path | None = None, own_first: bool = False) -> Agent:
    """Load the agent that knows most about a stage: its own, else that of the nearest stage before which there is one.

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

    digests = floor.scene.digest, floor.map.digest
    found, missing = stage, None
    while True:
        try:
            folder = folder_of(found)
            break
        except TwonavError as error:
            # The message is about the first stage of all: there training begins.
            missing = error
            if found not in STAGE_BEFORE:
                raise missing from None
            found = STAGE_BEFORE[found]
    agent = Agent.load(folder, *digests, learning_preset(stage))
    if found != stage:
        return agent
    agent.earlier_here, agent.earlier_elsewhere = agent.earlier_elsewhere, agent.earlier_here
    before = STAGE_BEFORE.get(stage)
    while before is not None and len(agent.earlier_elsewhere) == 0:
        # Without it the agent only knows less for a new goal, so nothing that is wrong with it stops the stage.
        with contextlib.suppress(TwonavError):
            agent.earlier_elsewhere = Agent.load(folder_of(before), *digests).replay
        before = STAGE_BEFORE.get(before)
    return agent


def load_localize(
    floor: Floor, chosen: Path | None = None, own_first: bool = False, *, filtered: bool = False, seed: int = 0
) -> Localize:
    """Load the scene's localizer as what the 3D stage asks at every look.

    Args:
        floor: Whose.
        chosen: Folder of the scene's checkpoints that the user named.
        own_first: Whether a run of the user's own goes before the shipped one.
        filtered: Fuse its looks with odometry (Eq. 4-5); else each picture says by itself where it was taken.
        seed: Seed of the run, for the filter's own stream.

    Raises:
        TwonavError: No checkpoint, or one that is damaged or belongs to another scene; a filter without beliefs.
    """
    from twonav_cli.localizer.estimator import Estimator
    from twonav_cli.stages.localize import FromEveryLook, FromPicture, Located

    scene, digest = floor.scene, floor.map.digest
    folder = checkpoint_folder(scene.name, "localizer", chosen, own_first, scene.digest, digest, floor.map_source)
    estimator = Estimator.load(folder, floor.scene.digest)
    if filtered and not estimator.gives_beliefs:
        raise TwonavError(
            f"the localizer in {folder} gives poses only, and the filter needs to know how sure it is: "
            "take --localizer raw"
        )

    def believe(image: Image) -> Belief:
        return estimator.estimate(image)

    def ask(image: Image) -> Located:
        if not estimator.gives_beliefs:
            return Located(Pose(*(float(value) for value in estimator.estimate_many(image[None])[0])))
        belief = believe(image)
        return Located(belief.pose, belief)

    return FromEveryLook(believe, _filter_for(floor, seed)) if filtered else FromPicture(ask)


def _filter_for(floor: Floor, seed: int) -> BeliefFilter:
    """Return a filter that knows the odometry's noise and the floor on which the robot can be."""
    from twonav_cli.config import OdometryNoise
    from twonav_cli.localizer.belief_filter import BeliefFilter, FilterConfig

    return BeliefFilter(FilterConfig(), OdometryNoise(), stream(seed, "belief"), free_floor(floor))


def free_floor(floor: Floor) -> FreeFloor:
    """Return where a filter may believe the robot to be: known floor on which it fits and which it can reach."""
    from twonav_cli.dataset.poses import reachable_floor
    from twonav_cli.localizer.belief_filter import FreeFloor

    frame = floor.map.frame
    return FreeFloor(reachable_floor(~floor.map.free, frame, list(floor.scene.starts.values())), frame)


def make_stage(
    floor: Floor, name: str, localize: Localize | None, seed: int, options: Sim2dOptions | Sim3dOptions | None = None
) -> MazeStage | Sim2dStage | Sim3dStage:
    """Return a stage by name; `localize` None takes the simulator's truth, `options` are those of the stage.

    Raises:
        TwonavError: No renderer, or the scene cannot be simulated.
    """
    if name == "maze":
        from twonav_cli.stages.maze_stage import MazeStage

        return MazeStage(floor.maze)
    if name == "2d":
        from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage

        return Sim2dStage(floor, seed, options if isinstance(options, Sim2dOptions) else None)
    from twonav_cli.stages.sim3d_stage import Sim3dOptions, Sim3dStage

    return Sim3dStage(floor, localize, seed, options if isinstance(options, Sim3dOptions) else None)
