"""Tables 7 and 8 as a picture: a figure for every goal in the order of training, the paper's beside ours."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from twonav_cli.experiments.tables.report import Figures, Report
from twonav_cli.plotting.style import FLOOR_COLOUR, Look, look_of, new_figure, tidy

METHODS = ("single", "multi", "multi-random")
"""The paper's columns; the explorers would lie on top of each other at the floor."""

NUDGE = 0.12
"""Distance between the columns of one goal, so that their deviations do not cover each other."""

LABELS = {
    "trials": "trials from each start",
    "actions": "mean actions of a trial",
}
"""Unit to the vertical axis's label."""


def draw_goal_table(report: Report) -> Figure:
    """Return two panels, the paper's figures and ours, on one scale."""
    figure = new_figure(3.6)
    left, right = figure.subplots(1, 2, sharey=True)
    for axes, rows, title in ((left, report.paper, "paper"), (right, report.ours, "ours")):
        tidy(axes)
        for place, method in enumerate(name for name in METHODS if name in rows):
            _draw_line(axes, rows[method], look_of(method), method, NUDGE * (place - 1))
        axes.set_title(title, loc="left", fontsize=10)
        axes.set_xlabel("goal, in order of training")
        axes.set_xticks(range(1, 1 + len(rows["multi"]["goals"])))
    floor = report.floor["iqm"]
    # The least number of trials is the criterion's, the paper's too; the shortest ways are those of our maze.
    for axes in (left, right) if report.unit == "trials" else (right,):
        axes.axhline(floor, color=FLOOR_COLOUR, linewidth=1.2, linestyle="--", label=f"floor, {floor:.1f}")
    left.set_ylabel(LABELS[report.unit])
    left.set_ylim(bottom=0)
    for axes in (left, right):
        axes.legend(frameon=False, fontsize=8)
    figure.suptitle(report.title, x=0.01, ha="left", fontsize=10)
    return figure


def _draw_line(axes: Axes, column: Figures, look: Look, method: str, nudge: float) -> None:
    """Draw a column's means with their standard deviations; goals without a figure are left out."""
    known = [(number, goal) for number, goal in enumerate(column["goals"], 1) if goal["mean"] is not None]
    axes.errorbar(
        [number + nudge for number, _ in known],
        [goal["mean"] for _, goal in known],
        yerr=[goal["std"] or 0.0 for _, goal in known],
        color=look.colour,
        marker=look.marker,
        markersize=5,
        linewidth=1.2,
        elinewidth=1.0,
        capsize=2,
        label=f"{method}, mean and deviation",
    )
