"""Training a localizer from the command line: collect what frames are missing, fit the network, and measure it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import CARD_FILE, add_metrics, read_card
from twonav_cli.dataset.plan import GRID_SET, RANDOM_SET
from twonav_cli.events import Clock, Event, FittingStep, FittingValidated, RunEnded, RunStarted, Sink, to_all
from twonav_cli.experiments.localizer_report import ReportConfig
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.devices import chosen_device
from twonav_cli.localizer.networks import OURS
from twonav_cli.localizer.training import train
from twonav_cli.localizer.training_config import TrainingConfig, training_settings
from twonav_cli.localizer.training_state import STATE_FILE
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.localizer_figures import figures_of
from twonav_cli.terminal.recordings import default_recording, recording
from twonav_cli.terminal.train import ALREADY_LEARNED, TrainRequest
from twonav_cli.terminal.train_frames import collected

QUICK_IMAGES = 6_000
QUICK_REPORT = ReportConfig(200, 100, 2)

MEASURED = "settings"
"""Among the metrics of a card: it was measured to the end."""

StopAsked = Callable[[], bool]

LOG_EVERY_BATCHES = 200
"""How often progress is printed where no bar can be drawn."""


@dataclass(frozen=True)
class Lesson:
    """What a network learns from, and what it is measured at.

    Attributes:
        frames: To learn from: the paper's half of the grid for its networks, random poses for ours.
        validation: To try it at in between, and to calibrate by.
        trials: To measure it at in the end; it has seen none of them.
    """

    frames: Selection
    validation: Selection
    trials: dict[str, Selection]


def train_localizer(
    request: TrainRequest, floor: Floor, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Collect frames, fit the network and save it with its card.

    Returns:
        The outcome ("learned", "quick" or "stopped") and the metrics of the card.

    Raises:
        TwonavError: No renderer, a damaged frame store, no such network or device, or a training state that does not
            fit.
    """
    config = localizer_settings(request)
    lesson = lesson_of(config.network, floor, request.seed, request.quick, should_stop)
    if lesson is None:
        return "stopped", {}
    there = request.resume and _is_trained(folder, config, request.seed)
    if there and MEASURED in read_card(folder)["metrics"]:
        return ALREADY_LEARNED, dict(read_card(folder)["metrics"])
    if not there and not _trained(request, floor, folder, config, lesson, should_stop):
        return "stopped", {}
    report = figures_of(floor, folder, QUICK_REPORT if request.quick else ReportConfig(), request.seed)
    add_metrics(folder, report)
    return ("quick" if request.quick else "learned"), dict(read_card(folder)["metrics"])


def _is_trained(folder: Path, config: TrainingConfig, seed: int) -> bool:
    """Return whether a training of these settings has come to its end in a folder, so that only measuring is left."""
    if (folder / STATE_FILE).exists() or not (folder / CARD_FILE).exists():
        return False
    card = read_card(folder)
    found = {**card.get("settings", {}), "seed": card.get("seed")}
    wanted = {"network": config.network, "images": config.images, "batch": config.batch, "seed": seed}
    return all(found.get(name) == value for name, value in wanted.items())


def _trained(
    request: TrainRequest, floor: Floor, folder: Path, config: TrainingConfig, lesson: Lesson, should_stop: StopAsked
) -> bool:
    """Fit the network, shown on a bar and recorded; return False when interrupted."""
    path = (request.record or default_recording("train", floor.scene.name, "localizer")) if request.recording else None
    settings = {"network": config.network, "frames": str(len(lesson.frames[1]))}
    begun = RunStarted(Clock(), "train", "localizer", floor.scene.name, request.seed, settings)
    with progress() as bar, recording(path, "localizer", begun) as recorder:
        sink = to_all(recorder, _shown_on(bar, config))
        saved = train(
            lesson.frames, folder, config, request.seed, lesson.trials, lesson.validation, should_stop, sink,
            request.resume, request.command(),
        )  # fmt: skip
        recorder(RunEnded(Clock(), "stopped" if saved is None else "learned"))
    return saved is not None


def localizer_settings(request: TrainRequest) -> TrainingConfig:
    """Return how the network of a request is trained.

    Raises:
        TwonavError: There is no network of that name, or no such device.
    """
    changes: dict[str, Any] = {"device": request.device or "auto"}
    chosen_device(changes["device"])  # else it would be missed only after minutes of taking frames
    if request.quick:
        changes |= {"validations": 2, "images": QUICK_IMAGES}
    if request.images is not None:
        changes["images"] = request.images
    return training_settings(request.network or OURS, **changes)


def lesson_of(network: str, floor: Floor, seed: int, quick: bool, should_stop: Callable[[], bool]) -> Lesson | None:
    """Return what a network learns from, taking the frames that are missing; None when interrupted.

    Raises:
        TwonavError: No renderer, or a folder that holds other frames.
    """
    random = collected(floor, RANDOM_SET, seed, quick, should_stop)
    if random is None:
        return None
    trials: dict[str, Selection] = {
        "off_grid": (random, random.off_grid()),
        "held_cells": (random, random.held_cells()),
    }
    if network == OURS:
        return Lesson((random, random.training()), (random, random.validation()), trials)
    grid = collected(floor, GRID_SET, seed, quick, should_stop)
    if grid is None:
        return None
    trials |= {"paper_split": (grid, grid.paper_test())}
    return Lesson((grid, grid.training()), (grid, grid.validation()), trials)


def _shown_on(bar: Any, config: TrainingConfig) -> Sink:
    """Return a sink that shows a training's progress on a bar, or in lines where none can be drawn."""
    task = bar.add_task(config.network, total=config.steps, result="")

    def show(event: Event) -> None:
        if isinstance(event, FittingStep):
            numbers = f"loss {event.loss:.3f}, {event.images_per_s:.0f} pictures/s"
            bar.update(task, completed=event.clock.step, result=numbers)
            if not bar.console.is_terminal and event.clock.step % LOG_EVERY_BATCHES == 0:
                bar.console.print(f"batch {event.clock.step} of {config.steps}: {numbers}")
        elif isinstance(event, FittingValidated):
            found = event.metrics
            bar.console.print(
                f"batch {event.clock.step}: validation frames, median {found['pos_median_m']:.3f} m "
                f"{found['ang_median_deg']:.2f} deg, mean {found['pos_mean_m']:.3f} m "
                f"{found['ang_mean_deg']:.2f} deg"
            )

    return show
