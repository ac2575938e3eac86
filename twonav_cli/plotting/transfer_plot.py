"""Tables 9 and 10 as pictures: actions to every goal in 2D and 3D, and what learning from nothing costs."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter

from twonav_cli.experiments.transfer.tables import Figures, TransferReport
from twonav_cli.plotting.style import FLOOR_COLOUR, PAPER_COLOUR, Look, new_figure, tidy

STAGE_LOOKS = {"2d": Look("#0072B2", "s"), "3d": Look("#D55E00", "o")}
"""Stage to its look."""

NUDGE = 0.12
"""Distance between the marks of one row, so that neither hides the other."""

PAPER: dict[str, Any] = {"color": PAPER_COLOUR, "marker": "x", "linestyle": "", "markersize": 6}


def draw_transfer(report: TransferReport) -> Figure:
    """Return the picture of Table 9 or Table 10."""
    figure = new_figure(3.8)
    if report.table == "table9":
        _draw_goals(figure.subplots(), report)
    else:
        left, right = figure.subplots(1, 2)
        _draw_places(left, report, "trials", "trials until learned, in order of training")
        _draw_places(right, report, "actions", "actions afterwards")
    figure.suptitle(report.title, x=0.01, ha="left", fontsize=10)
    return figure


def _draw_goals(axes: Axes, report: TransferReport) -> None:
    """Draw each goal's actions in 2D and 3D beside the shortest way, and the paper's averages as lines."""
    tidy(axes)
    names = [row["goal"] for row in report.goals]
    for place, (stage, look) in enumerate(STAGE_LOOKS.items()):
        rows = [row.get(stage, {}) for row in report.goals]
        known = [(number, row) for number, row in enumerate(rows) if row.get("actions_mean") is not None]
        _draw_marks(axes, known, "actions_mean", "actions_std", look, f"ours, {stage.upper()}", NUDGE * (2 * place - 1))
        average = report.paper[stage]["mean"]
        axes.axhline(
            average, color=look.colour, linewidth=1.0, linestyle=":", label=f"paper, {stage.upper()}, all goals"
        )
    for number, row in enumerate(report.goals):
        shortest = next((row[stage]["shortest_mean"] for stage in STAGE_LOOKS if stage in row), None)
        if shortest is not None:
            label = "shortest ways" if number == 0 else None
            axes.plot([number - 0.3, number + 0.3], [shortest] * 2, color=FLOOR_COLOUR, linewidth=2.0, label=label)
    axes.set_xticks(range(len(names)), names, rotation=30, ha="right")
    axes.set_ylabel("actions, mean over starts")
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False, fontsize=8, ncols=2)


def _draw_places(axes: Axes, report: TransferReport, what: str, label: str) -> None:
    """Draw a column of Table 10, the paper's and ours, on a logarithmic scale."""
    tidy(axes)
    rows = [row[what] for row in report.goals]
    known = [(number + 1, row) for number, row in enumerate(rows) if row["mean"] is not None]
    _draw_marks(axes, known, "mean", "std", STAGE_LOOKS["3d"], "ours", 0.0)
    printed = report.paper[what]["goals"]
    axes.plot(range(1, len(printed) + 1), [goal["mean"] for goal in printed], label="paper", **PAPER)
    axes.set_yscale("log")
    axes.yaxis.set_major_formatter(LogFormatter())
    axes.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(1.5, 0.5)))
    axes.set_xticks(range(1, max(len(rows), len(printed)) + 1))
    axes.set_xlabel("goal, in order of training")
    axes.set_ylabel(label)
    axes.legend(frameon=False, fontsize=8)


def _draw_marks(
    axes: Axes, known: list[tuple[int, Figures]], mean: str, std: str, look: Look, label: str, nudge: float
) -> None:
    axes.errorbar(
        [number + nudge for number, _ in known],
        [row[mean] for _, row in known],
        yerr=[row[std] or 0.0 for _, row in known],
        color=look.colour,
        marker=look.marker,
        markersize=5,
        linestyle="",
        elinewidth=1.0,
        capsize=2,
        label=label,
    )
