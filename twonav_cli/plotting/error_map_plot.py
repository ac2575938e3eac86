"""Fig. 7 as a picture: the mean position error of every cell over the floor plan, all networks on one scale.

R, C rows and columns of the map.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.image import AxesImage
from numpy.typing import NDArray

from twonav_cli.experiments.localizer_tables.error_map import ErrorMap, ErrorMapReport, heat_of
from twonav_cli.grid import GridFrame
from twonav_cli.plotting.style import WIDTH_IN, new_figure

COLOURS = "viridis"
"""Told apart by colour-blind readers, and dark to bright in grey too."""

MARGIN_M = 0.5
COLUMNS = 2
TITLE_IN, SURROUNDINGS_IN = 0.45, 1.0
TICKS_M = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)

WALL_COLOUR = "#3E404A"


def draw_error_maps(report: ErrorMapReport, occupied: NDArray[np.bool_], frame: GridFrame) -> Figure:
    """Return a panel for each network.

    Args:
        report: Fig. 7 with at least one map.
        occupied: [R, C] pixels of the floor plan's walls and furniture.
        frame: Where the map lies.
    """
    heats = [heat_of(one.cells) for one in report.maps]
    values = np.concatenate([heat[np.isfinite(heat)] for heat, _ in heats])
    low, high = max(float(values.min()), 1e-3), float(values.max())
    high = max(high, 1.01 * low)
    scale = LogNorm(low, high)
    area = _area([where for _, where in heats])
    columns = min(len(heats), COLUMNS)
    rows = math.ceil(len(heats) / columns)
    shape = (area[3] - area[2]) / (area[1] - area[0])
    figure = new_figure(SURROUNDINGS_IN + rows * (TITLE_IN + WIDTH_IN / columns * shape))
    panels = figure.subplots(rows, columns, squeeze=False).flat
    for axes in panels:
        axes.set_axis_off()
    for axes, one, (heat, where) in zip(figure.axes, report.maps, heats, strict=False):
        picture = _draw_map(axes, heat, where, scale)
        _draw_walls(axes, occupied, frame)
        axes.set_xlim(*area[:2])
        axes.set_ylim(*area[2:])
        axes.set_title(_title(one), loc="left", fontsize=9)
    bar = figure.colorbar(picture, ax=figure.axes, location="bottom", shrink=0.7, aspect=40, pad=0.02)
    bar.set_ticks([tick for tick in TICKS_M if low <= tick <= high])
    bar.ax.xaxis.set_major_formatter("{x:g}")
    bar.ax.minorticks_off()
    bar.set_label("mean position error of a cell's test frames (m)")
    figure.suptitle(f"{report.title} ({report.scene})", x=0.01, ha="left", fontsize=10)
    return figure


def _title(one: ErrorMap) -> str:
    found = one.summary
    paper = "" if one.paper is None else f"; paper {one.paper['min_m']:g} to {one.paper['max_m']:g} m"
    return f"{one.network}: {found['min_m']:.2g} to {found['max_m']:.2g} m{paper}"


def _area(frames: list[GridFrame]) -> tuple[float, float, float, float]:
    """Return what every panel shows: x from, x to, y from, y to."""
    return (
        min(frame.x_min_m for frame in frames) - MARGIN_M,
        max(frame.x_max_m for frame in frames) + MARGIN_M,
        min(frame.y_min_m for frame in frames) - MARGIN_M,
        max(frame.y_max_m for frame in frames) + MARGIN_M,
    )


def _extent(frame: GridFrame) -> tuple[float, float, float, float]:
    return frame.x_min_m, frame.x_max_m, frame.y_min_m, frame.y_max_m


def _draw_map(axes: Axes, heat: NDArray[np.float64], frame: GridFrame, scale: LogNorm) -> AxesImage:
    shown = np.ma.masked_invalid(heat)
    return axes.imshow(shown, extent=_extent(frame), norm=scale, cmap=COLOURS, interpolation="nearest")


def _draw_walls(axes: Axes, occupied: NDArray[np.bool_], frame: GridFrame) -> None:
    walls = np.ma.masked_equal(occupied.astype(np.uint8), 0)
    axes.imshow(walls, extent=_extent(frame), cmap=ListedColormap([WALL_COLOUR]), interpolation="nearest")
