"""Tables 3 and 4 as a picture: the errors of every network, the paper's and ours, on the split and away from it."""

from __future__ import annotations

from typing import Any, NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import LogLocator

from twonav_cli.experiments.localizer_tables.report import (
    HELD_CELLS,
    OFF_GRID,
    PAPER_SPLIT,
    Figures,
    LocalizerReport,
    LocalizerRow,
)
from twonav_cli.plotting.step_table_plot import PAPER_MARK
from twonav_cli.plotting.style import new_figure, tidy

ROW_HEIGHT_IN, SURROUNDINGS_IN = 0.36, 1.7

ABOVE = 0.25
"""Share of a row by which the paper's mark stands above ours, so that neither hides the other."""


class Mark(NamedTuple):
    """How the mean at a trial is drawn."""

    trial: str
    label: str
    style: dict[str, Any]


MARKS = (
    Mark(PAPER_SPLIT, "ours, the paper's split", {"color": "#0072B2", "marker": "s"}),
    Mark(OFF_GRID, "ours, off the grid", {"color": "#D55E00", "marker": "o", "markerfacecolor": "white"}),
    Mark(HELD_CELLS, "ours, held-out cells", {"color": "#009E73", "marker": "D", "markerfacecolor": "white"}),
)

SPREAD: dict[str, Any] = {"color": "#0072B2", "alpha": 0.35, "linewidth": 5, "solid_capstyle": "butt"}


def draw_localizer_table(report: LocalizerReport) -> Figure:
    """Return a panel for position and one for heading, on logarithmic scales, a row for each network of each scene."""
    figure = new_figure(SURROUNDINGS_IN + ROW_HEIGHT_IN * len(report.rows))
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, key, label in ((left, "pos_{}_m", "position error (m)"), (right, "ang_{}_deg", "heading error (°)")):
        tidy(axes)
        for place, row in enumerate(report.rows):
            _draw_row(axes, place, row, key)
        axes.set_xscale("log")
        axes.xaxis.set_major_locator(LogLocator(subs=(1, 2, 5)))
        axes.xaxis.set_major_formatter("{x:g}")
        axes.minorticks_off()
        axes.set_xlabel(label)
    left.set_yticks(range(len(report.rows)), [_name(row) for row in report.rows])
    left.set_ylim(len(report.rows) - 0.5, -0.5)
    for axes in (left, right):
        for place, (row, after) in enumerate(zip(report.rows, report.rows[1:], strict=False)):
            if row.scene != after.scene:
                axes.axhline(place + 0.5, color="#888888", linewidth=0.8)
    figure.suptitle(report.title, x=0.01, ha="left", fontsize=10)
    figure.legend(handles=_legend(), loc="outside lower center", ncols=3, frameon=False, fontsize=8)
    return figure


def _name(row: LocalizerRow) -> str:
    return f"{row.scene}, {row.network}" + ("\n(not trained)" if row.ours is None else "")


def _draw_row(axes: Axes, place: int, row: LocalizerRow, key: str) -> None:
    """Draw the paper's mean, our means, and how far the split's errors reach; `key` names a figure such as the mean."""
    if row.paper is not None:
        axes.plot(row.paper[key.format("mean")], place - ABOVE, **PAPER_MARK)
    ours: Figures = row.ours or {}
    if PAPER_SPLIT in ours:
        ends = [ours[PAPER_SPLIT][key.format(what)] for what in ("median", "p95")]
        axes.plot(ends, [place, place], **SPREAD)
    for mark in MARKS:
        if mark.trial in ours:
            axes.plot(ours[mark.trial][key.format("mean")], place, linestyle="", markersize=5.5, **mark.style)


def _legend() -> list[Line2D]:
    means = [Line2D([], [], linestyle="", markersize=5.5, label=f"{mark.label}, mean", **mark.style) for mark in MARKS]
    spread = Line2D([], [], label="ours, the split: median to 95 %", **SPREAD)
    return [Line2D([], [], label="paper, mean", **PAPER_MARK), *means, spread]
