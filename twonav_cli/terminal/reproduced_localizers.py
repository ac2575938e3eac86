"""Tables 3 and 4 and Fig. 7 as a person reads them: the paper's errors beside ours, the budget and the errata below."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rich.table import Table

from twonav_cli.experiments.localizer_tables.error_map import ErrorMap, ErrorMapReport
from twonav_cli.experiments.localizer_tables.report import (
    BELIEF,
    HELD_CELLS,
    NEAREST,
    OFF_GRID,
    PAPER_SPLIT,
    Figures,
    LocalizerReport,
    LocalizerRow,
)
from twonav_cli.experiments.localizer_tables.request import OWN_ROW
from twonav_cli.terminal.console import new_table, out

NONE = "-"
MARKS = "abcdefgh"
NOT_TRAINED = "not trained"

WHAT_ROWS_ARE = {
    OWN_ROW: "our network, trained on the paper's frames as often as inception-9",
    BELIEF: "our network, trained on pictures at random poses, measured at the same frames",
    NEAREST: "the pose of the most alike training frame, without any learning",
}

TRIAL_TITLES = {
    PAPER_SPLIT: "test frames on the grid",
    OFF_GRID: "off it",
    HELD_CELLS: "in held-out cells",
}

POSITION, ANGLE = ("pos", "m", 3), ("ang", "deg", 2)
"""What of `error_metrics` a table is about: name, unit, digits."""

Kind = tuple[str, str, int]

SPREAD = (
    (PAPER_SPLIT, "median", "split\nmedian"), (PAPER_SPLIT, "p95", "\n95 %"), (PAPER_SPLIT, "p99", "\n99 %"),
    (OFF_GRID, "mean", "off grid\nmean"), (OFF_GRID, "median", "\nmedian"), (OFF_GRID, "p95", "\n95 %"),
    (OFF_GRID, "p99", "\n99 %"), (HELD_CELLS, "mean", "held out\nmean"),
)  # fmt: skip
"""Columns of the tables of the errors' spread: trial, figure, heading."""


def print_errors(report: LocalizerReport) -> None:
    """Print Table 3 or 4 with everything that belongs to it."""
    console = out()
    console.print(f"\n[bold]{report.title}[/bold]")
    for scene in dict.fromkeys(row.scene for row in report.rows):
        rows = [row for row in report.rows if row.scene == scene]
        console.print(f"\n{scene}, the paper's split: mean and deviation, metres and degrees", markup=False)
        console.print(_beside_table(report, rows))
        for kind, name in ((POSITION, "position, metres"), (ANGLE, "heading, degrees")):
            console.print(f"\n{scene}, {name}", markup=False)
            console.print(_spread_table(rows, kind))
        if any(row.training for row in rows):
            console.print(f"\n{scene}, what the trainings took", markup=False)
            console.print(_budget_table((row.network, row.training) for row in rows))
    console.print()
    _print_foot(report.errata, [*_rows_said(report), *_settings(report.settings)], report.settings["command"])


def print_maps(report: ErrorMapReport) -> None:
    """Print the figures of Fig. 7's maps with everything that belongs to them."""
    console = out()
    console.print(f"\n[bold]{report.title}[/bold] ({report.scene}, metres)")
    console.print(_map_table(report))
    if any(one.training for one in report.maps):
        console.print("\nwhat the trainings took", markup=False)
        console.print(_budget_table((one.network, one.training) for one in report.maps))
    console.print()
    found = {one.network for one in report.maps}
    said = [f"{name}: {text}." for name, text in WHAT_ROWS_ARE.items() if name in found]
    said.append(f"Frames: {report.settings['frames']}.")
    _print_foot(report.errata, [*said, *_settings(report.settings)], report.settings["command"])


def _print_foot(errata: Sequence[dict[str, str]], lines: Iterable[str], command: str) -> None:
    console = out()
    for mark, erratum in zip(MARKS, errata, strict=False):
        console.print(f"({mark}) {erratum['row']}: {erratum['text']}", markup=False)
    for line in lines:
        console.print(line, markup=False)
    # One line whatever the width is, so that it can be copied.
    console.print(command, markup=False, soft_wrap=True)


def _number(value: float | None, digits: int) -> str:
    """Return a number; one of 10 or more with a digit less."""
    if value is None:
        return NONE
    return f"{value:.{digits if abs(value) < 10 else max(digits - 1, 0)}f}"


def _figure(row: LocalizerRow, trial: str, what: str, kind: Kind) -> str:
    """Return a figure of ours, such as the median, at a trial."""
    name, unit, digits = kind
    return _number((row.ours or {}).get(trial, {}).get(f"{name}_{what}_{unit}"), digits)


def _printed(row: LocalizerRow, what: str, kind: Kind) -> str:
    """Return a figure of the paper's."""
    name, unit, digits = kind
    return _number((row.paper or {}).get(f"{name}_{what}_{unit}"), digits)


def _beside_table(report: LocalizerReport, rows: Sequence[LocalizerRow]) -> Table:
    """Return the table in the paper's shape: position and angle, each the paper's and ours."""
    headings = ["paper\nm", "\n±", "ours\nm", "\n±", "paper\ndeg", "\n±", "ours\ndeg", "\n±", ""]
    table = new_table("network", *headings)
    for row in rows:
        cells = []
        for kind in (POSITION, ANGLE):
            cells += [_printed(row, what, kind) for what in ("mean", "std")]
            cells += [_figure(row, PAPER_SPLIT, what, kind) for what in ("mean", "std")]
        table.add_row(row.network, *cells, NOT_TRAINED if row.ours is None else _marks(report, row.scene, row.network))
    return table


def _marks(report: LocalizerReport | ErrorMapReport, scene: str, network: str) -> str:
    marks = zip(MARKS, report.errata, strict=False)
    return " ".join(mark for mark, erratum in marks if erratum["row"] == f"{scene} {network}")


def _spread_table(rows: Sequence[LocalizerRow], kind: Kind) -> Table:
    """Return how the errors spread on the paper's split, and how they are away from it."""
    table = new_table("network", *(heading for _, _, heading in SPREAD))
    for row in rows:
        table.add_row(row.network, *(_figure(row, trial, what, kind) for trial, what, _ in SPREAD))
    return table


def _budget_table(trainings: Iterable[tuple[str, Figures | None]]) -> Table:
    """Return what each training took."""
    table = new_table("network", "pictures\nfor poses", "\nfor layers", "epochs", "seconds", "on")
    for network, took in trainings:
        if took is not None:
            device = ", ".join(str(took[name]) for name in ("device", "precision") if took[name])
            numbers = [took["images"], took["pretraining_images"]]
            counts = [NONE if value is None else f"{value:,}" for value in numbers]
            table.add_row(network, *counts, _number(took["epochs"], 1), _number(took["seconds"], 0), device or NONE)
    return table


def _map_table(report: ErrorMapReport) -> Table:
    """Return the ends of every map's scale, the paper's and ours."""
    headings = ["paper\nmin", "\nmax", "ours\nmin", "\nmedian", "\nmean", "\nmax", "\nat x, y", "cells", ""]
    table = new_table("network", *headings)
    for one in report.maps:
        table.add_row(one.network, *_map_cells(one), _marks(report, report.scene, one.network))
    for name, paper in report.missing.items():
        table.add_row(name, *_paper_ends(paper), *[NONE] * 6, NOT_TRAINED)
    return table


def _map_cells(one: ErrorMap) -> list[str]:
    found, worst = one.summary, one.summary["worst"]
    ours = [_number(found[f"{name}_m"], 3) for name in ("min", "median", "mean", "max")]
    return [*_paper_ends(one.paper), *ours, f"{worst[0]:.1f}, {worst[1]:.1f}", str(found["cells"])]


def _paper_ends(paper: Figures | None) -> list[str]:
    return [_number((paper or {}).get(name), 2) for name in ("min_m", "max_m")]


def _rows_said(report: LocalizerReport) -> list[str]:
    """Return what the rows and columns are."""
    found = {row.network for row in report.rows}
    said = [f"{name}: {text}." for name, text in WHAT_ROWS_ARE.items() if name in found]
    return [
        *said,
        "split: the paper's test frames, which stand where training frames stand; off the grid: random poses; "
        "held-out cells: places that no training has seen.",
    ]


def _settings(settings: Figures) -> list[str]:
    """Return the budget, the seed, maps and frames, what could not be measured, and the versions."""
    lines = [
        f"Epochs are a budget, not the paper's {settings['paper_epochs']:,}; one training of each network; "
        f"seed {settings['seed']}.",
        *(["A quick run, which shows no more than that everything works."] if settings["quick"] else []),
    ]
    for scene, facts in settings["scenes"].items():
        lines.append(f"{scene}: {_frames(facts)}.")
        lines += [f"{scene}, not measured: {note}" for note in facts["notes"]]
    versions = ", ".join(f"{name} {number}" for name, number in settings["versions"].items())
    return [*lines, f"Versions: {versions}."]


def _frames(facts: dict[str, Any]) -> str:
    counts = facts["frames"]
    if counts is None:
        return f"on the map of the {facts['map']}"
    tests = ", ".join(f"{counts[name]:,} {title}" for name, title in TRIAL_TITLES.items())
    labels = counts["labels"]
    return f"on the map of the {facts['map']}, {counts['training']:,} training frames labelled by the {labels}; {tests}"
