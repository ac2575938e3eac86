"""A training's progress, where a bar can be drawn and where none can."""

from __future__ import annotations

import io

import pytest
from rich.console import Console
from rich.progress import Progress, TextColumn

from twonav_cli.events import Clock, FittingStep, FittingValidated
from twonav_cli.localizer.training_config import TrainingConfig
from twonav_cli.terminal.fitting_bar import LOG_EVERY_BATCHES, fitting_bar

CONFIG = TrainingConfig(images=8 * 500, batch=8)
FOUND = {"pos_median_m": 0.1, "ang_median_deg": 2.0, "pos_mean_m": 0.25, "ang_mean_deg": 3.5}


def step(number: int) -> FittingStep:
    return FittingStep(Clock(0, number), 1.23456, 0.001, 80.0)


def bar_on(terminal: bool) -> tuple[Progress, io.StringIO]:
    text = io.StringIO()
    console = Console(file=text, force_terminal=terminal, width=200, highlight=False)
    return Progress(TextColumn("{task.fields[result]}"), console=console, disable=not terminal), text


def test_a_bar_counts_pictures_and_says_that_measuring_comes_last() -> None:
    bar, text = bar_on(terminal=True)
    show = fitting_bar(bar, "kitchen cnn-7", CONFIG)
    (task,) = bar.tasks
    assert (task.description, task.total) == ("kitchen cnn-7", 4000)
    show(step(LOG_EVERY_BATCHES))
    assert task.completed == 8 * LOG_EVERY_BATCHES
    assert task.fields["result"] == "80 pictures/s, loss 1.235"
    show(step(500))
    assert (task.completed, task.fields["result"]) == (4000, "measuring")
    assert "pictures" not in text.getvalue()


def test_without_a_bar_there_is_a_line_every_few_batches_and_at_the_end() -> None:
    bar, text = bar_on(terminal=False)
    show = fitting_bar(bar, "kitchen cnn-7", CONFIG)
    for number in (20, LOG_EVERY_BATCHES, 220, 500):
        show(step(number))
    assert text.getvalue().splitlines() == [
        "kitchen cnn-7: 1,600 of 4,000 pictures, 80 pictures/s, loss 1.235, 0 min left",
        "kitchen cnn-7: 4,000 of 4,000 pictures, 80 pictures/s, loss 1.235, measuring",
    ]


@pytest.mark.parametrize("terminal", [True, False])
def test_validation_frames_have_a_line_of_their_own(terminal: bool) -> None:
    bar, text = bar_on(terminal)
    fitting_bar(bar, "kitchen cnn-7", CONFIG)(FittingValidated(Clock(0, 100), FOUND))
    said = "kitchen cnn-7: validation frames, median 0.100 m 2.00 deg, mean 0.250 m 3.50 deg"
    assert text.getvalue().splitlines() == [said]
