"""The plan of a scene as it is printed: the drawing, and a legend of its goals and rooms."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from twonav_cli.geometry import Pose
from twonav_cli.terminal import palette
from twonav_cli.terminal.plan import Plan, goal_key
from twonav_cli.terminal.plan_drawing import Marks, draw_plan, heading_glyph

if TYPE_CHECKING:
    from rich.text import Text

LEGEND_GAP = 3


def scene_text(plan: Plan, goals: Mapping[str, Pose], cols: int, rows: int = 24, coloured: bool = True) -> Text:
    """Return the plan of a scene within `cols` x `rows` characters and below it the legend.

    Args:
        plan: What is drawn; its rooms are named in the drawing.
        goals: Name to pose, map frame, in table order.
        cols: Width of the terminal.
        rows: Height of the drawing at most.
        coloured: False for ASCII.
    """
    text = draw_plan(plan, Marks(), rows, cols, coloured).text()
    text.append("\n\n")
    text.append_text(legend_text(goals, cols, coloured))
    return text


def legend_text(goals: Mapping[str, Pose], cols: int, coloured: bool = True) -> Text:
    """Return the goals with key, name, coordinates (metres) and heading (degrees), in columns that fit."""
    from rich.text import Text

    entries = [_entry(goal_key(index), name, pose, coloured) for index, (name, pose) in enumerate(goals.items())]
    text = Text(no_wrap=True, end="")
    if not entries:
        return text
    width = max(sum(len(part) for part, _ in entry) for entry in entries) + LEGEND_GAP
    columns = max(1, min((cols + LEGEND_GAP) // width, 3))
    lines = math.ceil(len(entries) / columns)
    for line in range(lines):
        for entry in entries[line::lines]:
            piece = Text()
            for part, style in entry:
                piece.append(part, style)
            piece.pad_right(width - len(piece))
            text.append_text(piece)
        text.rstrip()
        if line + 1 < lines:
            text.append("\n")
    return text


def _entry(key: str, name: str, pose: Pose, coloured: bool) -> list[tuple[str, str]]:
    """Return the pieces of one goal's line with their styles."""
    degrees = math.degrees(pose.theta_rad) % 360
    arrow = f" {heading_glyph(pose.theta_rad)}" if coloured else ""
    strong = f"bold {palette.hexadecimal(palette.CURRENT_GOAL)}" if coloured else ""
    quiet = palette.hexadecimal(palette.QUIET) if coloured else ""
    return [
        (f"{key or 'o'} ", strong),
        (f"{name:<12}", ""),
        (f" x {pose.x_m:6.2f} m  y {pose.y_m:6.2f} m  {degrees:3.0f}°{arrow}", quiet),
    ]
