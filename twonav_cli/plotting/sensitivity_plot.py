"""The sensitivity sweep as a picture: a panel for each setting, the paper's figures as dashed lines."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from twonav_cli.experiments.tables.report import Figures, Report
from twonav_cli.plotting.style import FLOOR_COLOUR, THOUSANDS, Look, look_of, new_figure, tidy

LABELS = {
    "discount": "discount",
    "initial_q": "first Q value",
    "temperature": "starting temperature",
    "trial_limit_steps": "trial limit (actions)",
}
"""Setting to the horizontal axis's label."""

GAVE_UP_HEIGHTS = (0.1, 0.03)
"""Where it says that runs of each method gave up: below the floor, where no figure lies."""


def draw_sensitivity(report: Report) -> Figure:
    """Return four panels on one scale."""
    figure = new_figure(6.0)
    panels = figure.subplots(2, 2, sharey=True)
    for axes, (setting, label) in zip(panels.flat, LABELS.items(), strict=True):
        tidy(axes)
        for (method, figures), height in zip(report.ours.items(), GAVE_UP_HEIGHTS, strict=True):
            _draw_sweep(axes, figures["sweeps"][setting], look_of(method), method, height)
            paper = report.paper[method]["mean"]
            axes.axhline(
                paper, color=look_of(method).colour, linestyle="--", linewidth=1.1,
                label=f"paper, {method} ({paper / 1000:g}k)",
            )  # fmt: skip
        axes.axhline(report.floor["iqm"], color=FLOOR_COLOUR, linewidth=1.2, label="floor of the criterion")
        values = [point["value"] for point in report.ours["multi"]["sweeps"][setting]]
        axes.set_xticks(range(len(values)), [f"{value:g}" for value in values])
        axes.set_xlim(-0.4, len(values) - 0.6)
        axes.set_xlabel(f"{label} (preset: {report.settings[setting]:g})")
        axes.yaxis.set_major_formatter(THOUSANDS)
    panels[0, 0].set_ylim(bottom=0)  # once everything is drawn: it also fixes the upper end
    for axes in panels[:, 0]:
        axes.set_ylabel("actions, IQM and 95 %")
    figure.suptitle(report.title, x=0.01, ha="left", fontsize=10)
    entries = dict(zip(*reversed(panels[0, 0].get_legend_handles_labels()), strict=True))
    figure.legend(entries.values(), entries.keys(), loc="outside lower center", ncols=5, frameon=False, fontsize=8)
    return figure


def _draw_sweep(axes: Axes, points: list[Figures], look: Look, method: str, height: float) -> None:
    """Draw the points of a sweep, with the share of runs that gave up where there were any."""
    known = [(place, point) for place, point in enumerate(points) if point["iqm"] is not None]
    ends = [(point["ci95"][0] or point["iqm"], point["ci95"][1] or point["iqm"]) for _, point in known]
    axes.errorbar(
        [place for place, _ in known],
        [point["iqm"] for _, point in known],
        yerr=[
            [point["iqm"] - low for (_, point), (low, _) in zip(known, ends, strict=True)],
            [high - point["iqm"] for (_, point), (_, high) in zip(known, ends, strict=True)],
        ],
        color=look.colour, marker=look.marker, markersize=5, linewidth=1.3, capsize=2, label=f"ours, {method}",
    )  # fmt: skip
    for place, point in enumerate(points):
        if point["gave_up"]:
            axes.annotate(
                f"{100 * point['gave_up_share']:.0f} % gave up", (place, height), xycoords=("data", "axes fraction"),
                ha="center", fontsize=7, color=look.colour,
            )  # fmt: skip
