"""Training the localizer from the command line: collect what frames are missing, then fit the network."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import read_card
from twonav_cli.dataset.collect import MAPPER, Provenance, collect
from twonav_cli.dataset.plan import PlanConfig, plan_frames
from twonav_cli.dataset.store import FrameStore, open_store
from twonav_cli.events import Clock, Event, FittingStep, FittingValidated, RunEnded, RunStarted, to_all
from twonav_cli.geometry import Pose
from twonav_cli.localizer.training import TrainingConfig, train
from twonav_cli.mapping.floor import Floor
from twonav_cli.mapping.known_maps import SURVEY
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.recordings import default_recording, recording
from twonav_cli.terminal.train import TrainRequest

QUICK_PLAN = PlanConfig(degree_step=30, random_frames=2_000, held_out_frames=500)
QUICK_TRAINING = TrainingConfig(images=6_000, validations=2)

LOG_EVERY_BATCHES = 200
"""How often progress is printed where no bar can be drawn."""


def train_localizer(
    request: TrainRequest, floor: Floor, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Collect frames, fit the network and save it with its card.

    Returns:
        The outcome ("learned", "quick" or "stopped") and the metrics of the card.

    Raises:
        TwonavError: No renderer, a damaged frame store, or a training state that does not fit.
    """
    store = collected(floor, request.seed, QUICK_PLAN if request.quick else PlanConfig(), request.quick, should_stop)
    if store is None:
        return "stopped", {}
    config = QUICK_TRAINING if request.quick else TrainingConfig()
    config = replace(config, images=request.images or config.images)
    path = (request.record or default_recording("train", floor.scene.name, "localizer")) if request.recording else None
    begun = RunStarted(Clock(), "train", "localizer", floor.scene.name, request.seed, {"frames": str(len(store))})
    with progress() as bar, recording(path, "localizer", begun) as recorder:
        task = bar.add_task("localizer", total=config.steps, result="")

        def show(event: Event) -> None:
            if isinstance(event, FittingStep):
                numbers = f"loss {event.loss:.3f}, {event.images_per_s:.0f} pictures/s"
                bar.update(task, completed=event.clock.step, result=numbers)
                if not bar.console.is_terminal and event.clock.step % LOG_EVERY_BATCHES == 0:
                    bar.console.print(f"batch {event.clock.step} of {config.steps}: {numbers}")
            elif isinstance(event, FittingValidated):
                found = event.metrics
                bar.console.print(
                    f"batch {event.clock.step}: held-out poses, median {found['pos_median_m']:.3f} m "
                    f"{found['ang_median_deg']:.2f} deg, mean {found['pos_mean_m']:.3f} m "
                    f"{found['ang_mean_deg']:.2f} deg"
                )

        sink = to_all(recorder, show)
        saved = train(store, folder, config, request.seed, should_stop, sink, request.resume, request.command())
        recorder(RunEnded(Clock(), "stopped" if saved is None else "learned"))
    if saved is None:
        return "stopped", {}
    return ("quick" if request.quick else "learned"), dict(read_card(folder)["metrics"])


def collected(
    floor: Floor, seed: int, plan_config: PlanConfig, quick: bool, should_stop: Callable[[], bool]
) -> FrameStore | None:
    """Return the scene's frames, taking and labelling the missing ones; None when interrupted.

    On a map that the robot made, the robot says where each frame was taken; else the simulator does.

    Args:
        floor: Scene and map.
        seed: Seed of the poses.
        plan_config: How many frames of each kind.
        quick: Whether the small set is meant; it lies beside the full one.
        should_stop: Asked every few hundred frames.

    Raises:
        TwonavError: No renderer, or a folder that holds other frames.
    """
    from twonav_cli.dataset.labels import MapLabels
    from twonav_cli.scene.camera import Camera
    from twonav_cli.scene.laser import RangeFinder
    from twonav_cli.scene.world import World

    scene, by_mapper = floor.scene, floor.map_source == SURVEY
    # Another map has other places where the robot fits.
    kind = ("survey-" if by_mapper else "") + ("quick-" if quick else "")
    folder = runs_dir() / scene.name / f"frames-{kind}seed{seed}"
    plan = plan_frames(~floor.map.free, floor.map.frame, list(scene.starts.values()), plan_config, seed)
    world = World(scene)
    camera = Camera(world)
    label, provenance = None, Provenance(scene.name, scene.digest, seed)
    if by_mapper:
        label = MapLabels(floor, RangeFinder(world), seed)
        provenance = replace(provenance, labels=MAPPER, map_digest=floor.map.digest)

    def render(pose: Pose) -> Any:
        world.place(pose)
        return camera.image()

    with progress() as bar:
        task = bar.add_task("frames", total=len(plan.poses), result="")
        collect(render, plan, folder, provenance, lambda done, _: bar.update(task, completed=done), should_stop, label)
    camera.close()
    return None if should_stop() else open_store(folder, scene.digest)
