"""Training a localizer from the command line: collect what frames are missing, fit the network, and measure it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import Card, add_metrics, read_card
from twonav_cli.dataset.plan import GRID_SET, RANDOM_SET
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, RunEnded, RunStarted, to_all
from twonav_cli.experiments.localizer_report import ReportConfig
from twonav_cli.experiments.localizer_tables.budget import QUICK_IMAGES
from twonav_cli.experiments.localizer_tables.trained import finished
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.devices import chosen_device
from twonav_cli.localizer.networks import OURS
from twonav_cli.localizer.training import train
from twonav_cli.localizer.training_config import TrainingConfig, training_settings
from twonav_cli.localizer.training_state import STATE_FILE
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.fitting_bar import fitting_bar
from twonav_cli.terminal.localizer_figures import figures_of
from twonav_cli.terminal.recordings import default_recording, recording
from twonav_cli.terminal.train import ALREADY_LEARNED, TrainRequest
from twonav_cli.terminal.train_frames import collected
from twonav_cli.worker_pool import StoppedError

QUICK_REPORT = ReportConfig(200, 100, 100)

MEASURED = "settings"
"""Among the metrics of a card: it was measured to the end."""

StopAsked = Callable[[], bool]


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
    card = _found(request, floor, folder, config)
    if card is not None and MEASURED in card["metrics"]:
        return ALREADY_LEARNED, dict(card["metrics"])
    lesson = lesson_of(config.network, floor, request.seed, request.quick, should_stop)
    if lesson is None:
        return "stopped", {}
    if card is None and not _trained(request, floor, folder, config, lesson, should_stop):
        return "stopped", {}
    size = QUICK_REPORT if request.quick else ReportConfig()
    try:
        report = figures_of(floor, folder, size, request.seed, should_stop)
    except StoppedError:
        return "stopped", {}
    add_metrics(folder, report)
    return ("quick" if request.quick else "learned"), dict(read_card(folder)["metrics"])


def _found(request: TrainRequest, floor: Floor, folder: Path, config: TrainingConfig) -> Card | None:
    """Return the card of a network that was trained to its end, perhaps not measured; None where one is to be trained.

    Raises:
        TwonavError: The folder holds an unfinished training that nobody asked to go on with, or, where somebody did, a
            network of other settings; or the recording cannot be written.
    """
    if request.recording and request.record is not None:
        from twonav_cli.recording.rrd_file import checked_path

        checked_path(request.record)
    unfinished = (folder / STATE_FILE).exists()
    if request.resume:
        return None if unfinished else finished(folder, config, request.seed, floor)
    if unfinished:
        raise TwonavError(
            f"an unfinished training is in {folder}: go on with it (--resume), name another folder with --out, "
            f"or delete {folder / STATE_FILE}"
        )
    return None


def _trained(
    request: TrainRequest, floor: Floor, folder: Path, config: TrainingConfig, lesson: Lesson, should_stop: StopAsked
) -> bool:
    """Fit the network, shown on a bar and recorded; return False when interrupted."""
    path = (request.record or default_recording("train", floor.scene.name, "localizer")) if request.recording else None
    settings = {"network": config.network, "frames": str(len(lesson.frames[1]))}
    begun = RunStarted(Clock(), "train", "localizer", floor.scene.name, request.seed, settings)
    with progress() as bar, recording(path, "localizer", begun) as recorder:
        sink = to_all(recorder, fitting_bar(bar, config.network, config))
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
