"""What never changes in a recording: the floor plan, the goals, and how everything looks."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze
from twonav_cli.recording import palette
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.palette import packed

Always = Callable[..., None]
"""`RrdFile.always`: entity, then what to write there once and for all."""

FREE_RGB = (232, 232, 228)
WALL_RGB = (62, 64, 74)
Y_UP = rr.Transform3D(scale=[1.0, -1.0, 1.0])
"""Turns a map frame (y up) into the frame of a 2D view (y down)."""


def image_transform(frame: GridFrame) -> rr.Transform3D:
    """Return where the pixels of a grid's picture lie in its (y up) map frame."""
    return rr.Transform3D(
        translation=[frame.x_min_m, frame.y_max_m, 0.0], scale=[frame.resolution_m, -frame.resolution_m, 1.0]
    )


def wall_edges(blocked: NDArray[np.bool_], frame: GridFrame) -> NDArray[np.float32]:
    """Return the borders between free and blocked cells as segments [n, 2, 2] in metres."""
    padded = np.pad(blocked, 1, constant_values=True)
    across = np.argwhere(padded[1:, 1:-1] != padded[:-1, 1:-1])  # a border above row r, column c
    along = np.argwhere(padded[1:-1, 1:] != padded[1:-1, :-1])  # a border left of row r, column c
    segments = [((c, r), (c + 1, r)) for r, c in across] + [((c, r), (c, r + 1)) for r, c in along]
    corner = np.array((frame.x_min_m, frame.y_max_m))
    scale = np.array((frame.resolution_m, -frame.resolution_m))
    return np.asarray(np.array(segments).reshape(-1, 2, 2) * scale + corner, dtype=np.float32)


def write_floor(always: Always, maze: Maze, frame: GridFrame, occupied: Any, map_frame: GridFrame | None) -> None:
    """Write the map (or the maze where there is no map), and the outline of the maze."""
    always("drive", rr.AnnotationContext([(0, "free", FREE_RGB), (1, "occupied", WALL_RGB)]))
    always("drive/map", Y_UP)
    pixels, pixel_frame = (maze.blocked, frame) if occupied is None or map_frame is None else (occupied, map_frame)
    floor = rr.SegmentationImage(pixels.astype(np.uint8), draw_order=-10.0)
    always("drive/map/floor", image_transform(pixel_frame), floor)
    edges = rr.LineStrips2D(wall_edges(maze.blocked, frame), colors=[(120, 150, 190, 120)], radii=0.012, draw_order=1)
    always("drive/map/cells", edges)


def write_goals(always: Always, goals: GoalList) -> None:
    """Write the named goals; once more when one was added."""
    places = goals.positions()
    dots = rr.Points2D(places, colors=palette.goal_colours(len(goals)), radii=0.12, draw_order=20)
    # A label has the colour of its point: white ones are read on every goal.
    names = rr.Points2D(
        places, labels=goals.names, show_labels=True, colors=[(255, 255, 255)], radii=0.03, draw_order=21
    )
    always("drive/map/goals", dots)
    always("drive/map/goals/names", names)
    always("state/goal", rr.StateConfiguration(values=goals.names, colors=palette.goal_colours(len(goals))))


def write_looks(always: Always, names: list[str]) -> None:
    """Write colours, widths and drawing order of everything that moves.

    Args:
        always: Writes.
        names: Goals that the run begins with.
    """
    for entity, looks in _LOOKS.items():
        always(entity, looks)
    always("camera", rr.Pinhole(focal_length=42.0, resolution=[84, 84]))
    levels = [(i, f"cost {i / (palette.COST_LEVELS - 1):.2f}", c) for i, c in enumerate(palette.cost_level_colours())]
    always("drive/map/dwa/cost", rr.AnnotationContext(levels))
    lines = rr.SeriesLines(names=names, colors=palette.goal_colours(len(names)), widths=[1.6] * len(names))
    always("learning/td_error", lines)
    always("metrics/td_error", lines)
    outcomes, causes = palette.OUTCOME_COLOURS, palette.CAUSE_COLOURS
    always("state/outcome", rr.StateConfiguration(values=list(outcomes), colors=packed(list(outcomes.values()))))
    always("state/why", rr.StateConfiguration(values=list(causes), colors=packed(list(causes.values()))))


def _line(name: str, colour: int) -> rr.SeriesLines:
    return rr.SeriesLines(names=name, colors=packed([colour]), widths=1.6)


def _dots(name: str, colour: int) -> rr.SeriesPoints:
    return rr.SeriesPoints(names=name, colors=packed([colour]), markers="circle", marker_sizes=3.0)


def _arrow(colour: int, order: float) -> rr.Arrows2D:
    return rr.Arrows2D.from_fields(colors=packed([colour]), radii=0.035, draw_order=order)


def _strip(colour: int, radius_m: float, order: float) -> rr.LineStrips2D:
    return rr.LineStrips2D.from_fields(colors=packed([colour]), radii=radius_m, draw_order=order)


_ACTIONS = rr.SeriesLines(
    names=["up", "down", "left", "right"],
    colors=packed([0x77AADDFF, 0xEE8866FF, 0x44BB99FF, 0xEEDD88FF]),
    widths=[1.6] * 4,
)

_LOOKS: dict[str, Any] = {
    "drive/map/robot/true": _arrow(palette.TRUE_COLOUR, 34.0),
    "drive/map/robot/believed": _arrow(palette.BELIEVED_COLOUR, 33.0),
    "drive/map/robot/estimate": _arrow(palette.ESTIMATE_COLOUR, 32.0),
    "drive/map/robot/picture": _arrow(palette.PICTURE_COLOUR, 31.5),
    "drive/map/robot/error": _strip(palette.ERROR_COLOUR, 0.03, 31.0),
    "drive/map/robot/footprint": _strip(palette.TRUE_COLOUR, 0.02, 30.0),
    "drive/map/robot/trail": _strip(palette.TRAIL_COLOUR, 0.02, 10.0),
    "drive/map/robot/cell": rr.Points2D.from_fields(colors=packed([palette.TRUE_COLOUR]), radii=0.15, draw_order=34.0),
    "drive/map/scan": rr.Points2D.from_fields(colors=packed([palette.LASER_COLOUR]), radii=0.02, draw_order=15.0),
    "drive/map/goal": rr.Ellipses2D.from_fields(
        line_radii=0.03, colors=packed([palette.CHOSEN_COLOUR]), draw_order=19.0
    ),
    "drive/map/dwa/candidates": rr.LineStrips2D.from_fields(radii=0.008, draw_order=25.0),
    "drive/map/dwa/best": _strip(palette.CHOSEN_COLOUR, 0.016, 26.0),
    "drive/map/dwa/cost": rr.SegmentationImage.from_fields(opacity=0.55, draw_order=2.0),
    "drive/map/belief/heat": rr.SegmentationImage.from_fields(opacity=0.8, draw_order=0.5),
    "drive/map/belief/places": rr.Points2D.from_fields(
        colors=packed([palette.PICTURE_COLOUR]), radii=0.11, draw_order=23.0
    ),
    "drive/map/belief/places/weights": rr.Points2D.from_fields(
        colors=packed([0xFFFFFFFF]), radii=0.03, draw_order=23.5, show_labels=True
    ),
    "drive/map/belief/particles": rr.Points2D.from_fields(
        colors=packed([palette.BELIEVED_COLOUR]), radii=0.02, draw_order=24.0
    ),
    "drive/map/failures/all": rr.Points2D.from_fields(radii=0.09, draw_order=21.0),
    "drive/map/failures/latest": rr.Points2D.from_fields(radii=0.12, draw_order=22.0, show_labels=True),
    "drive/map/kidnaps": _strip(palette.ERROR_COLOUR, 0.03, 12.0),
    "metrics/position_error/believed": _line("believed", palette.BELIEVED_COLOUR),
    "metrics/position_error/estimate": _dots("estimate, after a look", palette.ESTIMATE_COLOUR),
    "metrics/position_error/picture": _dots("that picture alone", palette.PICTURE_CURVE_COLOUR),
    "metrics/heading_error/believed": _line("believed", palette.BELIEVED_COLOUR),
    "metrics/heading_error/estimate": _dots("estimate, after a look", palette.ESTIMATE_COLOUR),
    "metrics/heading_error/picture": _dots("that picture alone", palette.PICTURE_CURVE_COLOUR),
    "metrics/confidence/estimate": _line("of the estimate", palette.ESTIMATE_COLOUR),
    "metrics/confidence/picture": _line("of the picture alone", palette.PICTURE_CURVE_COLOUR),
    "metrics/spread/filter": _line("of the filter", palette.ESTIMATE_COLOUR),
    "metrics/spread/picture": _line("of the picture's likeliest place", palette.PICTURE_CURVE_COLOUR),
    "metrics/q_values": _ACTIONS,
    "learning/steps": rr.SeriesLines(
        names=["taken", "shortest"], colors=packed([palette.GOAL_COLOURS[0], palette.SHORTEST_COLOUR]), widths=[1.6] * 2
    ),
    "learning/round": rr.SeriesLines(
        names=["taken", "shortest"], colors=packed([palette.GOAL_COLOURS[0], palette.SHORTEST_COLOUR]), widths=[2.0] * 2
    ),
    "learning/chosen": rr.SeriesPoints(names="chosen", markers="diamond", marker_sizes=6.0),
    "learning/reached": _line("share that reached the goal", palette.OUTCOME_COLOURS["reached"]),
}
