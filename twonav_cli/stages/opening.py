"""A stage by name, and the scene's localizer as the 3D stage asks it.

Everything heavy is imported when it is loaded.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from twonav_cli.checkpoint import read_card
from twonav_cli.checkpoint_folders import checkpoint_folder, localizer_name
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.rng import stream

if TYPE_CHECKING:
    from twonav_cli.belief import Belief
    from twonav_cli.localizer.belief_filter import BeliefFilter, FreeFloor
    from twonav_cli.mapping.floor import Floor
    from twonav_cli.stages.localize import Image, Localize
    from twonav_cli.stages.maze_stage import MazeStage
    from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage
    from twonav_cli.stages.sim3d_stage import Sim3dOptions, Sim3dStage


def localizer_folder(
    floor: Floor, chosen: Path | None = None, own_first: bool = False, network: str | None = None
) -> Path:
    """Return the folder of the scene's localizer, which `load_localize` loads, without loading anything.

    Args:
        floor: Whose.
        chosen: Folder of the scene's checkpoints that the user named.
        own_first: Whether a run of the user's own goes before the shipped one.
        network: One of the paper's, or None for ours.

    Raises:
        TwonavError: There is none; the message says which command makes it.
    """
    scene, digest = floor.scene, floor.map.digest
    name = localizer_name(network)
    return checkpoint_folder(scene.name, name, chosen, own_first, scene.digest, digest, floor.map_source)


def localizer_sha256(floor: Floor, own_first: bool = False) -> str:
    """Return the checksum of the localizer that `load_localize` loads.

    Raises:
        TwonavError: There is none, or its card is damaged.
    """
    return str(read_card(localizer_folder(floor, own_first=own_first))["sha256"])


def load_localize(
    floor: Floor,
    chosen: Path | None = None,
    own_first: bool = False,
    *,
    filtered: bool = False,
    seed: int = 0,
    network: str | None = None,
) -> Localize:
    """Load the scene's localizer as what the 3D stage asks at every look.

    Args:
        floor: Whose.
        chosen: Folder of the scene's checkpoints that the user named.
        own_first: Whether a run of the user's own goes before the shipped one.
        filtered: Fuse its looks with odometry (Eq. 4-5); else each picture says by itself where it was taken.
        seed: Seed of the run, for the filter's own stream.
        network: One of the paper's, or None for ours.

    Raises:
        TwonavError: No checkpoint, or one that is damaged or belongs to another scene; a filter without beliefs.
    """
    from twonav_cli.localizer.estimator import Estimator
    from twonav_cli.stages.localize import FromEveryLook, FromPicture, Located

    folder = localizer_folder(floor, chosen, own_first, network)
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
