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
from twonav_cli.recording.palette import packed

Always = Callable[..., None]
"""`RrdFile.always`: entity, then what to write there once and for all."""

FREE_RGB = (232, 232, 228)
WALL_RGB = (62, 64, 74)
Q_RANGE = (-10.0, 135.0)
"""Colour range of Q: a goal is worth 100; brighter colours are left free so that white arrows stay legible."""
ARROW_CELLS = 0.62
"""Length of a greedy arrow in cells."""

Y_UP = rr.Transform3D(scale=[1.0, -1.0, 1.0])
"""Turns a map frame (y up) into the frame of a 2D view (y down)."""


def image_transform(frame: GridFrame) -> rr.Transform3D:
    """Return where the pixels of a grid's picture lie in its (y up) map frame."""
    return rr.Transform3D(
        translation=[frame.x_min_m, frame.y_max_m, 0.0], scale=[frame.resolution_m, -frame.resolution_m, 1.0]
    )


def goal_entity(index: int) -> str:
    """Return where the Q-values of a goal are kept."""
    return f"q/goal_{index:02d}/map"


def goal_points(maze: Maze, frame: GridFrame) -> NDArray[np.float64]:
    """Return the position of every goal [G, 2]."""
    return np.array([frame.centre_of(cell) for cell in maze.goals.values()]).reshape(-1, 2)


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
    """Write the map (or the maze where there is no map), the outline of the maze and the named goals."""
    always("drive", rr.AnnotationContext([(0, "free", FREE_RGB), (1, "occupied", WALL_RGB)]))
    always("drive/map", Y_UP)
    pixels, pixel_frame = (maze.blocked, frame) if occupied is None or map_frame is None else (occupied, map_frame)
    floor = rr.SegmentationImage(pixels.astype(np.uint8), draw_order=-10.0)
    always("drive/map/floor", image_transform(pixel_frame), floor)
    edges = rr.LineStrips2D(wall_edges(maze.blocked, frame), colors=[(120, 150, 190, 120)], radii=0.012, draw_order=1)
    always("drive/map/cells", edges)
    always(
        "drive/map/goals",
        rr.Points2D(goal_points(maze, frame), colors=palette.goal_colours(len(maze.goals)), radii=0.12, draw_order=20),
    )
    # A label has the colour of its point: white ones are read on every goal.
    names = rr.Points2D(
        goal_points(maze, frame),
        labels=maze.goal_names,
        show_labels=True,
        colors=[(255, 255, 255)],
        radii=0.03,
        draw_order=21,
    )
    always("drive/map/goals/names", names)


def write_q_scenery(always: Always, maze: Maze, frame: GridFrame) -> None:
    """Write frame, goal and looks of every Q picture (`q/goal_00` ... and `q/chosen`)."""
    points = goal_points(maze, frame)
    value = rr.DepthImage.from_fields(
        format=rr.components.ImageFormat(width=maze.cols, height=maze.rows, channel_datatype="F16"),
        colormap="inferno",
        depth_range=Q_RANGE,
        draw_order=-5.0,
    )
    policy = rr.Arrows2D.from_fields(colors=[255, 255, 255, 190], radii=0.025, draw_order=5.0)
    for index, entity in enumerate([*(goal_entity(i) for i in range(len(maze.goals))), "q/chosen/map"]):
        always(entity, Y_UP)
        always(f"{entity}/value", image_transform(frame), value)
        always(f"{entity}/policy", policy)
        if index < len(maze.goals):
            colour = palette.goal_colours(len(maze.goals))[index : index + 1]
            always(f"{entity}/goal", rr.Points2D(points[index : index + 1], radii=0.3, colors=colour, draw_order=9))
    always("q/chosen/map/goal", rr.Points2D.from_fields(radii=0.3, colors=[255, 255, 255], draw_order=9.0))


def write_looks(always: Always, maze: Maze) -> None:
    """Write colours, widths and drawing order of everything that moves."""
    for entity, looks in _LOOKS.items():
        always(entity, looks)
    always("camera", rr.Pinhole(focal_length=42.0, resolution=[84, 84]))
    levels = [(i, f"cost {i / (palette.COST_LEVELS - 1):.2f}", c) for i, c in enumerate(palette.cost_level_colours())]
    always("drive/map/dwa/cost", rr.AnnotationContext(levels))
    goals = palette.goal_colours(len(maze.goals))
    names = maze.goal_names
    lines = rr.SeriesLines(names=names, colors=goals, widths=[1.6] * len(names))
    always("learning/td_error", lines)
    always("metrics/td_error", lines)
    always("state/goal", rr.StateConfiguration(values=names, colors=goals))
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
    "drive/map/failures/all": rr.Points2D.from_fields(radii=0.09, draw_order=21.0),
    "drive/map/failures/latest": rr.Points2D.from_fields(radii=0.12, draw_order=22.0, show_labels=True),
    "drive/map/kidnaps": _strip(palette.ERROR_COLOUR, 0.03, 12.0),
    "metrics/position_error/believed": _line("believed", palette.BELIEVED_COLOUR),
    "metrics/position_error/localizer": _dots("localizer, after the action", palette.ESTIMATE_COLOUR),
    "metrics/heading_error/believed": _line("believed", palette.BELIEVED_COLOUR),
    "metrics/heading_error/localizer": _dots("localizer, after the action", palette.ESTIMATE_COLOUR),
    "metrics/q_values": _ACTIONS,
    "learning/steps": rr.SeriesLines(
        names=["taken", "shortest"], colors=packed([palette.GOAL_COLOURS[0], palette.SHORTEST_COLOUR]), widths=[1.6] * 2
    ),
    "learning/reached": _line("share that reached the goal", palette.OUTCOME_COLOURS["reached"]),
}
