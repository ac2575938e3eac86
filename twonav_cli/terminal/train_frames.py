"""`twonav train --stage frames`: takes the pictures that localizers learn from, those that are missing."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.dataset.plan import GRID_SET, SETS, PlanConfig
from twonav_cli.mapping.floor import Floor
from twonav_cli.mapping.known_maps import SURVEY
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.console import progress
from twonav_cli.worker_pool import processors

if TYPE_CHECKING:
    from twonav_cli.dataset.store import FrameStore
    from twonav_cli.terminal.train import TrainRequest

QUICK_PLAN = PlanConfig(degree_step=30, random_frames=2_000, held_out_frames=500)


def frames_folder(floor: Floor, name: str, seed: int, quick: bool = False) -> Path:
    """Return where a data set of a floor lies; another map has other places where the robot fits."""
    kind = ("survey-" if floor.map_source == SURVEY else "") + ("quick-" if quick else "")
    return runs_dir() / floor.scene.name / f"frames-{name}-{kind}seed{seed}"


def collected(floor: Floor, name: str, seed: int, quick: bool, should_stop: Callable[[], bool]) -> FrameStore | None:
    """Return one of a scene's data sets, taking and labelling the missing frames; None when interrupted.

    On a map that the robot made, the robot says where each frame was taken; else the simulator does.

    Args:
        floor: Scene and map.
        name: A name of SETS.
        seed: Seed of the poses.
        quick: Whether the small set is meant; it lies beside the full one.
        should_stop: Asked after every few hundred frames at least.

    Raises:
        TwonavError: No renderer, or a folder that holds other frames.
    """
    from twonav_cli.dataset.collect import collect
    from twonav_cli.dataset.photographer import MakePhotographer, provenance_of
    from twonav_cli.dataset.plan import plan_frames
    from twonav_cli.dataset.store import open_store

    folder = frames_folder(floor, name, seed, quick)
    config = QUICK_PLAN if quick else PlanConfig()
    starts = list(floor.scene.starts.values())
    plan = plan_frames(name, ~floor.map.free, floor.map.frame, starts, config, seed)
    with progress() as bar:
        task = bar.add_task(f"frames, {name}", total=len(plan.poses), result="")
        collect(
            MakePhotographer(floor, seed), plan, folder, provenance_of(floor, seed),
            lambda done, _: bar.update(task, completed=done), should_stop, 1 if quick else processors(),
        )  # fmt: skip
    return None if should_stop() else open_store(folder, floor.scene.digest)


def train_frames(
    request: TrainRequest, floor: Floor, should_stop: Callable[[], bool]
) -> tuple[Path, str, dict[str, Any]]:
    """Collect both data sets of a scene.

    Returns:
        The folder of the last, the outcome ("collected" or "stopped"), and how many frames there are.

    Raises:
        TwonavError: No renderer, or a folder that holds other frames.
    """
    counts: dict[str, Any] = {}
    folder = frames_folder(floor, GRID_SET, request.seed, request.quick)
    for name in SETS:
        folder = frames_folder(floor, name, request.seed, request.quick)
        store = collected(floor, name, request.seed, request.quick, should_stop)
        if store is None:
            return folder, "stopped", counts
        counts |= {f"{name}_frames": len(store), f"{name}_without_label": int((~store.labelled()).sum())}
        counts[f"{name}_folder"] = str(folder)
    return folder, "collected", counts
