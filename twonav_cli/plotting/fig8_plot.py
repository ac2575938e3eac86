"""Fig. 8 (a) and (b) as a picture: actions of a trial over the trials, single goal and multi-goal."""

from __future__ import annotations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import ScalarFormatter

from twonav_cli.experiments.tables.report import Figures, Report
from twonav_cli.plotting.style import FLOOR_COLOUR, Look, look_of, new_figure, tidy

PANELS = (("single", "(a) single goal"), ("multi", "(b) multi-goal"))

TICKS = (10, 20, 50, 100, 200, 500)


def draw_fig8(report: Report) -> Figure:
    """Return both panels on one scale."""
    figure = new_figure(5.2)
    panels = figure.subplots(2, 1, sharex=True, sharey=True)
    for axes, (method, title) in zip(panels, PANELS, strict=True):
        tidy(axes)
        _draw_curve(axes, report.ours[method]["curve"], look_of(method))
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
