"""The figures of a localizer: measured with a progress bar, printed as a person reads them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rich.table import Table

from twonav_cli.experiments.localizer_report import ReportConfig, localizer_report
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.console import out, progress
from twonav_cli.worker_pool import StoppedError

ERRORS = {
    "pos_mean_m": ("mean m", 3),
    "pos_median_m": ("median", 3),
    "pos_p95_m": ("95 %", 3),
    "pos_p99_m": ("99 %", 3),
    "ang_mean_deg": ("mean deg", 2),
    "ang_median_deg": ("median", 2),
    "ang_p95_deg": ("95 %", 2),
}
"""Key of a figure to its heading and digits; `--json` has the others."""

ROWS = {
    "off_grid": "random poses",
    "off_grid_nearest": "  most alike frame",
    "held_cells": "held-out cells",
    "held_cells_nearest": "  most alike frame",
    "paper_split": "paper's split",
    "paper_split_by_labels": "  by robot's labels",
    "paper_split_nearest": "  most alike frame",
}
"""Key of a set of frames to what it is called."""


def figures_of(
    floor: Floor, folder: Path, config: ReportConfig, seed: int, should_stop: Callable[[], bool]
) -> dict[str, Any]:
    """Return the figures of a localizer (`localizer_report`), with a progress bar while they are measured.

    Raises:
        StoppedError: `should_stop`, asked every few frames, said so.
    """
    with progress() as bar:
        tasks: dict[str, Any] = {}

        def show(name: str, done: int, total: int) -> None:
            if should_stop():
                raise StoppedError
            if name not in tasks:
                tasks[name] = bar.add_task(name, total=total, result="")
            bar.update(tasks[name], completed=done)

        return localizer_report(floor, folder, config, seed, show)


def print_figures(report: dict[str, Any]) -> None:
    """Print what was measured: errors as a table, then beliefs, tracks and kidnaps in sentences."""
    table = Table(box=None, pad_edge=False)
    table.add_column("errors at")
    for heading, _ in ERRORS.values():
        table.add_column(heading, justify="right")
    for name, called in ROWS.items():
        if name in report:
            numbers = (_number(report[name].get(key), digits) for key, (_, digits) in ERRORS.items())
            table.add_row(called, *numbers)
    out().print(table)
    for sentence in sentences(report):
        out().print(sentence)


def sentences(report: dict[str, Any]) -> list[str]:
    """Return what a report says about beliefs, time, tracks and kidnaps."""
    found = []
    if "belief" in report:
        belief = report["belief"]
        found += [
            f"beliefs: {belief['places_90']:.1%} of the places lie in the 90 % region, {belief['places_50']:.1%} in "
            f"the 50 % region; headings {belief['headings_90']:.1%} and {belief['headings_50']:.1%}",
            f"confidence tells errors above 0.5 m ({belief['far']:.1%} of the pictures) with an area under the ROC "
            f"curve of {_number(belief['auroc'])}",
            f"one picture takes {report['milliseconds']:.2f} ms",
        ]
    if "tracks" in report:
        alone, filtered = report["tracks"]["single"], report["tracks"]["filtered"]
        found.append(
            f"along {report['tracks']['frames']} frames of driving: each picture alone {_pair(alone)}; "
            f"filtered {_pair(filtered)}"
        )
    if "kidnaps" in report and report["kidnaps"]["filtered"]["kidnaps"]:
        filtered = report["kidnaps"]["filtered"]
        found.append(
            f"kidnapped {filtered['kidnaps']} times: {filtered['found_soon']:.1%} found again within 10 frames, "
            f"{filtered['found']:.1%} at all, after {_number(filtered['looks_mean'], 1)} looks on average; "
            f"{filtered['false_finds']} times found and lost again"
        )
    return found


def _pair(errors: dict[str, float]) -> str:
    return (
        f"{errors['pos_mean_m']:.3f} m, {errors['ang_mean_deg']:.2f} deg (mean), lost at {errors['lost_frames']} "
        f"frames, left a right place {errors['false_resets']} times"
    )


def _number(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
