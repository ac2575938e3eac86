"""The picture of every table and figure, by name."""

from __future__ import annotations

from collections.abc import Callable

from matplotlib.figure import Figure

from twonav_cli.experiments.tables.report import Report
from twonav_cli.plotting.fig8_plot import draw_fig8
from twonav_cli.plotting.goal_table_plot import draw_goal_table
from twonav_cli.plotting.sensitivity_plot import draw_sensitivity
from twonav_cli.plotting.step_table_plot import draw_step_table
from twonav_cli.plotting.style import png_bytes

PICTURES: dict[str, Callable[[Report], Figure]] = {
    "table5": draw_step_table,
    "table6": draw_step_table,
    "table7": draw_goal_table,
    "table8": draw_goal_table,
    "fig8": draw_fig8,
    "sensitivity": draw_sensitivity,
}
"""A key of TABLES to what draws it."""


def picture_of(report: Report) -> bytes:
    """Return the picture of a report as a PNG file."""
    return png_bytes(PICTURES[report.table](report))
