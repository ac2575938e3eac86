"""Fig. 8 as a picture: actions of a trial over the trials, in the maze, and in 2D and 3D where agents are there."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from twonav_cli.experiments.tables.report import Figures, Report
from twonav_cli.plotting.style import FLOOR_COLOUR, Look, look_of, new_figure, tidy

PANELS = (("single", "(a) maze, single goal"), ("multi", "(b) maze, multi-goal"))
STAGE_PANELS = (
    ("2d", "(c) 2D, after the maze"), ("3d", "(d) 3D, after 2D"), ("from-nothing", "(e) 3D, from nothing"),
)  # fmt: skip

PANEL_IN, SURROUNDINGS_IN = 2.1, 1.0

TICKS = (10, 20, 50, 100, 200, 500)


def draw_fig8(report: Report) -> Figure:
    """Return the panels that there are, on one vertical scale; those of the maze share the other as well."""
    stages: Figures = report.settings.get("stages") or {}
    curves = [(report.ours[method]["curve"], look_of(method), title) for method, title in PANELS]
    curves += [(stages[name]["curve"], look_of("multi"), title) for name, title in STAGE_PANELS if name in stages]
    figure = new_figure(SURROUNDINGS_IN + PANEL_IN * len(curves))
    panels = figure.subplots(len(curves), 1, sharey=True)
    panels[0].sharex(panels[1])
    for axes, (curve, look, title) in zip(panels, curves, strict=True):
        tidy(axes)
        _draw_curve(axes, curve, look)
        axes.set_title(title, loc="left", fontsize=10)
        axes.set_ylabel("actions of a trial")
        axes.set_yscale("log")
        axes.set_yticks(TICKS)
        axes.minorticks_off()
        axes.yaxis.set_major_formatter(ScalarFormatter())
    panels[-1].set_xlabel("trials")
    figure.suptitle(
        f"Fig. 8: actions of a trial against the number of trials ({report.settings['scene']})",
        x=0.01,
        ha="left",
        fontsize=10,
    )
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4, frameon=False, fontsize=8)
    return figure


def _draw_curve(axes: Axes, curve: Figures, look: Look) -> None:
    trials = curve["trials"]
    axes.fill_between(trials, curve["q25"], curve["q75"], color=look.colour, alpha=0.3, linewidth=0, label="quartiles")
    axes.plot(trials, curve["mean"], color=look.colour, linewidth=1.1, label="mean over the repeats")
    ends = [*curve["goal_starts"][1:], trials[-1] if trials else 0]
    for rank, (begin, end) in enumerate(zip(curve["goal_starts"], ends, strict=False)):
        axes.axvline(begin, color=FLOOR_COLOUR, linewidth=0.7, linestyle=":", label="" if rank else "next goal")
        shortest = curve["shortest"][rank]
        axes.plot([begin, end], [shortest] * 2, color="black", linewidth=1.0, label="" if rank else "shortest ways")
        axes.annotate(
            str(rank + 1), (begin, 1.0), (2, -9), xycoords=("data", "axes fraction"), textcoords="offset points",
            fontsize=8, color="#444444",
        )  # fmt: skip
