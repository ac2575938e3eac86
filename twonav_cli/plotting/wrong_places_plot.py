"""Fig. 9 as a picture: where estimates are wrong, and what the robot saw there.

R, C rows and columns of the map.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from numpy.typing import NDArray

from twonav_cli.experiments.wrong_places import WRONG_M, LookedAround, WrongPlace
from twonav_cli.geometry import FloatArray, Pose, points_in_map
from twonav_cli.grid import GridFrame
from twonav_cli.plotting.style import WIDTH_IN, new_figure

TRUE_COLOUR, ESTIMATE_COLOUR, WALL_COLOUR = "#0072B2", "#D55E00", "#3E404A"
MARGIN_M, ARROW_M = 0.5, 0.45
PICTURES_IN, TITLE_IN = 1.75, 0.8


def draw_wrong_places(
    title: str, found: LookedAround, occupied: NDArray[np.bool_], frame: GridFrame, outline_m: FloatArray
) -> Figure:
    """Return the floor plan with every wrong estimate, and below it the pictures of the places that are shown.

    Args:
        title: One line.
        found: What was found.
        occupied: [R, C] pixels of walls and furniture.
        frame: Where the map lies.
        outline_m: Corners [K, 2] of the robot.
    """
    area = _area(occupied, frame)
    shape = (area[3] - area[2]) / (area[1] - area[0])
    figure = new_figure(TITLE_IN + WIDTH_IN * shape + (PICTURES_IN if found.shown else 0.0))
    columns = max(len(found.shown), 1)
    grid = figure.add_gridspec(
        2 if found.shown else 1, columns, height_ratios=None if not found.shown else [WIDTH_IN * shape, PICTURES_IN]
    )
    plan = figure.add_subplot(grid[0, :])
    _draw_plan(plan, found, occupied, frame, outline_m)
    plan.set_xlim(*area[:2])
    plan.set_ylim(*area[2:])
    for number, place in enumerate(found.shown):
        _draw_picture(figure.add_subplot(grid[1, number]), number + 1, place)
    figure.suptitle(title, x=0.01, ha="left", fontsize=10)
    return figure


def _area(occupied: NDArray[np.bool_], frame: GridFrame) -> tuple[float, float, float, float]:
    """Return what the plan shows: x from, x to, y from, y to."""
    rows, cols = np.flatnonzero(occupied.any(axis=1)), np.flatnonzero(occupied.any(axis=0))
    edge = frame.resolution_m
    return (
        frame.x_min_m + cols[0] * edge - MARGIN_M,
        frame.x_min_m + (cols[-1] + 1) * edge + MARGIN_M,
        frame.y_max_m - (rows[-1] + 1) * edge - MARGIN_M,
        frame.y_max_m - rows[0] * edge + MARGIN_M,
    )


def _draw_plan(
    axes: Axes, found: LookedAround, occupied: NDArray[np.bool_], frame: GridFrame, outline_m: FloatArray
) -> None:
    extent = (frame.x_min_m, frame.x_max_m, frame.y_min_m, frame.y_max_m)
    walls = np.ma.masked_where(~occupied, occupied)
    axes.imshow(walls, extent=extent, cmap=ListedColormap([WALL_COLOUR]), interpolation="nearest")
    for true, estimate in found.wrong:
        axes.plot([true[0], estimate[0]], [true[1], estimate[1]], color="#999999", linewidth=0.5, alpha=0.6)
        axes.plot(true[0], true[1], ".", color=TRUE_COLOUR, markersize=3)
        axes.plot(estimate[0], estimate[1], ".", color=ESTIMATE_COLOUR, markersize=3)
    for number, place in enumerate(found.shown, start=1):
        closed = np.vstack([outline_m, outline_m[:1]])
        axes.plot(*points_in_map(place.true, closed).T, color=TRUE_COLOUR, linewidth=1.4)
        _draw_arrow(axes, place.true, TRUE_COLOUR)
        _draw_arrow(axes, place.estimate, ESTIMATE_COLOUR)
        axes.plot(
            [place.true.x_m, place.estimate.x_m], [place.true.y_m, place.estimate.y_m], color="black", linewidth=0.8
        )
        axes.annotate(str(number), place.true[:2], (6, 6), textcoords="offset points", fontsize=9, weight="bold")
    axes.set_aspect("equal")
    axes.set_axis_off()
    share = 100 * len(found.wrong) / max(found.looks, 1)
    axes.set_title(
        f"{len(found.wrong)} of {found.looks:,} looks are more than {WRONG_M:g} m off ({share:.1f} %); "
        "blue: where the robot is, orange: where its picture says",
        loc="left", fontsize=8,
    )  # fmt: skip


def _draw_arrow(axes: Axes, pose: Pose, colour: str) -> None:
    head = (pose.x_m + ARROW_M * math.cos(pose.theta_rad), pose.y_m + ARROW_M * math.sin(pose.theta_rad))
    axes.annotate("", head, pose[:2], arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.6})


def _draw_picture(axes: Axes, number: int, place: WrongPlace) -> None:
    axes.imshow(place.image, interpolation="nearest")
    axes.set_axis_off()
    sure = "" if place.belief is None else f", {place.belief.confidence:.0%} sure"
    axes.set_title(f"{number}: {place.error_m:.1f} m off{sure}", fontsize=7)
