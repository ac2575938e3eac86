"""The picture of every table and figure, by name."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twonav_cli.experiments.localizer_tables.error_map import ErrorMapReport
from twonav_cli.experiments.localizer_tables.report import LocalizerReport
from twonav_cli.experiments.tables.report import Report
from twonav_cli.experiments.transfer.tables import TransferReport
from twonav_cli.experiments.wrong_places import LookedAround
from twonav_cli.grid import GridFrame
from twonav_cli.plotting.error_map_plot import draw_error_maps
from twonav_cli.plotting.fig8_plot import draw_fig8
from twonav_cli.plotting.goal_table_plot import draw_goal_table
from twonav_cli.plotting.localizer_table_plot import draw_localizer_table
from twonav_cli.plotting.sensitivity_plot import draw_sensitivity
from twonav_cli.plotting.step_table_plot import draw_step_table
from twonav_cli.plotting.style import png_bytes
from twonav_cli.plotting.transfer_plot import draw_transfer
from twonav_cli.plotting.wrong_places_plot import draw_wrong_places

PICTURES: dict[str, Callable[[Report], Figure]] = {
    "table5": draw_step_table,
    "table6": draw_step_table,
    "table7": draw_goal_table,
    "table8": draw_goal_table,
    "fig8": draw_fig8,
    "sensitivity": draw_sensitivity,
}
"""A key of TABLES to what draws it."""


def picture_of(report: Report | LocalizerReport) -> bytes:
    """Return the picture of a table as a PNG file."""
    if isinstance(report, LocalizerReport):
        return png_bytes(draw_localizer_table(report))
    return png_bytes(PICTURES[report.table](report))


def picture_of_transfer(report: TransferReport) -> bytes:
    """Return the picture of Table 9 or 10 as a PNG file."""
    return png_bytes(draw_transfer(report))


def picture_of_wrong_places(
    title: str, found: LookedAround, occupied: NDArray[np.bool_], frame: GridFrame, outline_m: NDArray[np.float64]
) -> bytes:
    """Return the picture of Fig. 9 over a floor plan [R, C] as a PNG file; the outline [K, 2] is the robot's."""
    return png_bytes(draw_wrong_places(title, found, occupied, frame, outline_m))


def picture_of_maps(report: ErrorMapReport, occupied: NDArray[np.bool_], frame: GridFrame) -> bytes:
    """Return the picture of Fig. 7 over a floor plan [R, C] as a PNG file."""
    return png_bytes(draw_error_maps(report, occupied, frame))
