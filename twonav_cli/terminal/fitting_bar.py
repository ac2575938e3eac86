"""A localizer's training on a progress bar: pictures shown, and how the validation frames come out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from twonav_cli.events import Event, FittingStep, FittingValidated, Sink

if TYPE_CHECKING:
    from rich.progress import Progress

    from twonav_cli.localizer.training_config import TrainingConfig

LOG_EVERY_BATCHES = 200
"""How often progress is printed where no bar can be drawn."""


def fitting_bar(bar: Progress, title: str, config: TrainingConfig) -> Sink:
    """Return a sink that shows a training on a task of its own, in pictures; in lines where no bar can be drawn.

    Args:
        bar: What the task is added to (`console.progress`).
        title: What is trained.
        config: How, which says how many pictures there are.
    """
    total = config.steps * config.batch
    task = bar.add_task(title, total=total, result="")

    def say(text: str) -> None:
        bar.console.print(f"{title}: {text}", markup=False)

    def show(event: Event) -> None:
        if isinstance(event, FittingStep):
            shown, over = event.clock.step * config.batch, event.clock.step == config.steps
            numbers = f"{event.images_per_s:.0f} pictures/s, loss {event.loss:.3f}"
            bar.update(task, completed=shown, result="measuring" if over else numbers)
            if not bar.console.is_terminal and (over or event.clock.step % LOG_EVERY_BATCHES == 0):
                left_min = (total - shown) / max(event.images_per_s, 1e-9) / 60.0
                say(
                    f"{shown:,} of {total:,} pictures, {numbers}, {'measuring' if over else f'{left_min:.0f} min left'}"
                )
        elif isinstance(event, FittingValidated):
            found = event.metrics
            say(
                f"validation frames, median {found['pos_median_m']:.3f} m {found['ang_median_deg']:.2f} deg, "
                f"mean {found['pos_mean_m']:.3f} m {found['ang_mean_deg']:.2f} deg"
            )

    return show
