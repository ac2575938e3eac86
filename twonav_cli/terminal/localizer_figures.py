"""The figures of a localizer: measured with a progress bar, printed as a person reads them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from rich.table import Table

from twonav_cli.experiments.localizer_report import ReportConfig, localizer_report
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.console import out, progress

ERRORS = {
    "pos_mean_m": "position, mean, m",
    "pos_std_m": "standard deviation",
    "pos_median_m": "median",
    "pos_p95_m": "95 % below",
    "pos_p99_m": "99 % below",
    "ang_mean_deg": "heading, mean, deg",
    "ang_std_deg": "standard deviation",
    "ang_median_deg": "median",
    "ang_p95_deg": "95 % below",
    "ang_p99_deg": "99 % below",
    "within_5cm_5deg": "within 5 cm and 5 deg",
    "within_25cm_2deg": "within 25 cm and 2 deg",
}
"""Key of a figure to what it is called."""

COLUMNS = {
    "off_grid": "random poses",
    "off_grid_nearest": "most alike frame",
    "held_cells": "held-out cells",
    "held_cells_nearest": "most alike frame",
    "paper_split": "paper's split",
    "paper_split_by_labels": "by the robot's labels",
    "paper_split_nearest": "most alike frame",
}
"""Key of a set of frames to its heading."""


def figures_of(floor: Floor, folder: Path, config: ReportConfig, seed: int) -> dict[str, Any]:
    """Return the figures of a localizer (`localizer_report`), with a progress bar while they are measured."""
    with progress() as bar:
        tasks: dict[str, Any] = {}

        def show(name: str, done: int, total: int) -> None:
            if name not in tasks:
                tasks[name] = bar.add_task(name, total=total, result="")
            bar.update(tasks[name], completed=done)

        return localizer_report(floor, folder, config, seed, show)


def print_figures(report: dict[str, Any]) -> None:
    """Print what was measured: errors as a table, then beliefs, tracks and kidnaps in sentences."""
    table = Table(box=None, pad_edge=False)
    kinds = [kind for kind in COLUMNS if kind in report]
    table.add_column("errors")
    for kind in kinds:
        table.add_column(COLUMNS[kind], justify="right")
    table.add_row("frames", *(str(report[kind]["n"]) for kind in kinds))
    for key, name in ERRORS.items():
        table.add_row(name, *(_number(report[kind].get(key)) for kind in kinds))
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
        tracks = report["tracks"]
        found += [
            f"along {tracks['frames']} frames of driving: each picture alone {_pair(tracks['single'])}, "
            f"filtered {_pair(tracks['filtered'])}; lost at {tracks['lost_frames_single']} and "
            f"{tracks['lost_frames_filtered']} frames, left a right place {tracks['false_resets_single']} and "
            f"{tracks['false_resets_filtered']} times",
        ]
    if "kidnaps" in report:
        filtered = report["kidnaps"]["kidnaps_filtered"]
        found += [
            f"kidnapped {filtered['kidnaps']} times: {filtered['found_soon']:.1%} found again within 10 frames, "
            f"{filtered['found']:.1%} at all, after {_number(filtered['looks_mean'])} looks on average; "
            f"{filtered['false_finds']} times found and lost again",
        ]
    return found


def _pair(errors: dict[str, float]) -> str:
    return f"{errors['pos_mean_m']:.3f} m, {errors['ang_mean_deg']:.2f} deg (mean)"


def _number(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
