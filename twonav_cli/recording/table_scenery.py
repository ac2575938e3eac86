"""What never changes about the pictures of the tables: where they lie, the goal in each, and what colours mean."""

from __future__ import annotations

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze
from twonav_cli.recording import palette
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.scenery import Y_UP, Always, image_transform
from twonav_cli.recording.td_pictures import FIRST_UNTRIED, LEVELS_PER_POWER, LOWEST, WALL, level_classes

Q_RANGE = (-10.0, 135.0)
"""Colour range of Q: a goal is worth 100; brighter colours are left free so that white arrows stay legible."""

CHOSEN = "q/chosen/map"
"""Entity of the chosen goal's values."""

Q_LEGEND, TD_LEGEND = "legend/q", "legend/td"
LEGEND_WIDTH = 3
"""Pixels of a legend's bar."""
LEGEND_ROWS = 10
"""Colours of the longer legend."""


def goal_entity(index: int) -> str:
    """Return where the Q-values of a goal are kept."""
    return f"q/goal_{index:02d}/map"


def td_entity(index: int) -> str:
    """Return where the TD errors of a goal are kept."""
    return f"td/goal_{index:02d}/map"


def write_table_scenery(always: Always, maze: Maze, frame: GridFrame) -> None:
    """Write the looks of the chosen goal's picture, and the legends."""
    always("td", rr.AnnotationContext(level_classes()))
    always("legend", rr.AnnotationContext(level_classes()))
    _write_values(always, CHOSEN, maze, frame)
    always(f"{CHOSEN}/goal", rr.Points2D.from_fields(radii=0.3, colors=[255, 255, 255], draw_order=9.0))
    _write_legends(always)


def write_goal_tables(always: Always, index: int, goals: GoalList, maze: Maze, frame: GridFrame) -> None:
    """Write the looks of one goal's pictures, and the goal in them where its place is known."""
    _write_values(always, goal_entity(index), maze, frame)
    errors = rr.SegmentationImage.from_fields(
        format=rr.components.ImageFormat(width=maze.cols, height=maze.rows, channel_datatype="U8"), draw_order=-5.0
    )
    always(td_entity(index), Y_UP)
    always(f"{td_entity(index)}/error", image_transform(frame), errors)
    place = goals.position_of(goals.name_of(index))
    if place is not None:
        colour = palette.goal_colours(index + 1)[index:]
        for entity in (goal_entity(index), td_entity(index)):
            always(f"{entity}/goal", rr.Points2D([place], radii=0.3, colors=colour, draw_order=9))


def write_arrows(always: Always, entity: str, origins: NDArray[np.float32]) -> None:
    """Write where the arrows of a goal's values begin [F, 2]; only with the first arrows, for a viewer wants both."""
    arrows = rr.Arrows2D.from_fields(origins=origins, colors=[255, 255, 255, 190], radii=0.025, draw_order=5.0)
    always(f"{entity}/policy", arrows)


def _write_values(always: Always, entity: str, maze: Maze, frame: GridFrame) -> None:
    always(entity, Y_UP)
    always(f"{entity}/value", image_transform(frame), _values(maze.cols, maze.rows))


def _values(width: int, height: int) -> rr.DepthImage:
    return rr.DepthImage.from_fields(
        format=rr.components.ImageFormat(width=width, height=height, channel_datatype="F16"),
        colormap="inferno",
        depth_range=Q_RANGE,
        draw_order=-5.0,
    )


def _write_legends(always: Always) -> None:
    """Write a bar of colours with labels beside it, bright on top, one for the values and one for the TD errors."""
    values = np.array([100.0, 80.0, 60.0, 40.0, 20.0, 0.0, np.nan], dtype=np.float16)
    labels = ["100: the goal's reward", "80", "60", "40", "20", "0", "wall"]
    pixels = np.repeat(values[:, None], LEGEND_WIDTH, axis=1)
    always(f"{Q_LEGEND}/bar", _values(LEGEND_WIDTH, len(values)), rr.DepthImage.from_fields(buffer=pixels.tobytes()))
    _write_labels(always, Q_LEGEND, labels)
    powers = range(4, int(LOWEST) - 1, -1)
    levels = [1 + round((power - LOWEST) * LEVELS_PER_POWER) for power in powers]
    levels = [FIRST_UNTRIED + 3, FIRST_UNTRIED, *levels, WALL]
    texts = ["no action tried", "one action untried", *(f"{10.0**power:,g}" for power in powers), "wall"]
    texts[-2] += " or less"
    picture = np.repeat(np.array(levels, dtype=np.uint8)[:, None], LEGEND_WIDTH, axis=1)
    always(f"{TD_LEGEND}/bar", rr.SegmentationImage(picture))
    _write_labels(always, TD_LEGEND, texts)


def _write_labels(always: Always, entity: str, labels: list[str]) -> None:
    places = [(LEGEND_WIDTH + 2.0, row + 0.2) for row in range(len(labels))]
    points = rr.Points2D(places, labels=labels, show_labels=True, radii=0.01, colors=[(255, 255, 255)], draw_order=5)
    always(f"{entity}/labels", points)
