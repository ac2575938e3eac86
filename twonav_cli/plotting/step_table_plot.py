"""Tables 5 and 6 as a picture: actions of every method, from the floor of the criterion upward."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from twonav_cli.experiments.tables.report import Figures, Report
from twonav_cli.plotting.style import FLOOR_COLOUR, PAPER_COLOUR, THOUSANDS, look_of, new_figure, tidy

ROW_HEIGHT_IN, SURROUNDINGS_IN = 0.45, 1.3

PAPER_MARK: dict[str, Any] = {
    "color": PAPER_COLOUR, "marker": "x", "markersize": 7, "markeredgewidth": 2, "linestyle": "",
}  # fmt: skip

ABOVE = 0.28
"""Share of a row by which the paper's mark stands above ours, so that neither hides the other."""


def draw_step_table(report: Report) -> Figure:
    """Return a row per method: interquartile mean with its interval, the mean of every maze, and the paper's figure."""
    figure = new_figure(SURROUNDINGS_IN + ROW_HEIGHT_IN * len(report.ours))
    axes = figure.add_subplot()
    tidy(axes)
    for row, (method, figures) in enumerate(report.ours.items()):
        _draw_row(axes, row, method, figures, report.paper.get(method))
    floor = report.floor["iqm"]
    axes.axvline(floor, color=FLOOR_COLOUR, linewidth=1.2)
    axes.set_yticks(range(len(report.ours)), list(report.ours))
    axes.set_ylim(len(report.ours) - 0.5, -0.5)
    axes.set_xlim(left=0)
    axes.xaxis.set_major_formatter(THOUSANDS)
    axes.set_xlabel("actions until every goal is learned, confirmation trials included")
    axes.set_title(report.title, loc="left", fontsize=10)
    figure.legend(handles=_legend(floor), loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    return figure


def _legend(floor: float) -> list[Line2D]:
    """Return one entry of each kind, in no method's colour."""
    grey = FLOOR_COLOUR
    return [
        Line2D([], [], color=grey, marker="o", linewidth=5, alpha=0.7, label="ours, IQM and 95 % interval"),
        Line2D([], [], color=grey, marker="|", markersize=9, linestyle="", label="ours, mean of a maze"),
        Line2D([], [], **PAPER_MARK, label="paper, average"),
        Line2D([], [], color=grey, linewidth=1.2, label=f"floor of the criterion, {floor / 1000:.1f}k"),
    ]


def _draw_row(axes: Axes, row: int, method: str, figures: Figures, paper: Figures | None) -> None:
    look = look_of(method)
    mazes = [value for value in figures["per_maze"] if value is not None]
    axes.plot(mazes, [row] * len(mazes), "|", color=look.colour, alpha=0.5, markersize=9)
    if figures["iqm"] is not None:
        low, high = (figures["iqm"] if end is None else end for end in figures["ci95"])
        axes.plot([low, high], [row, row], color=look.colour, linewidth=5, alpha=0.45, solid_capstyle="butt")
        axes.plot(figures["iqm"], row, look.marker, color=look.colour, markersize=7)
    if paper is not None:
        axes.plot(paper["mean"], row - ABOVE, **PAPER_MARK)
