"""The maze as text and as a picture."""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import unknown_name
from twonav_cli.grid import Cell

METADATA: dict[str, Any] = {"render_modes": ["ansi", "rgb_array"], "render_fps": 4}
"""What every environment here tells Gymnasium of its pictures."""

PICTURE_PX = 480
"""Longest edge of the picture, at most."""

SMALLEST_CELL_PX = 4

FREE, BLOCKED, GRID = (247, 247, 247), (64, 64, 64), (225, 225, 225)
GOAL, AGENT = (0, 114, 178), (213, 94, 0)
"""Blue and vermilion of Okabe and Ito: told apart by colour-blind readers."""


def check_render_mode(render_mode: str | None) -> None:
    """Refuse a render mode that there is not.

    Raises:
        TwonavError: Names the right ones.
    """
    if render_mode is not None and render_mode not in METADATA["render_modes"]:
        raise unknown_name("render mode", str(render_mode), METADATA["render_modes"])


def rendered(render_mode: str | None, blocked: NDArray[np.bool_], agent: Cell, goal: Cell) -> Any:
    """Return the maze [R, C] as text or as RGB [rows, cols, 3], as the render mode says; None without one."""
    if render_mode is None:
        gymnasium.logger.warn('render() shows nothing without a render mode: make(..., render_mode="ansi")')
        return None
    draw = text_of if render_mode == "ansi" else picture_of
    return draw(blocked, agent, goal)


def text_of(blocked: NDArray[np.bool_], agent: Cell, goal: Cell) -> str:
    """Return one line per row of the maze [R, C]: "#" blocked, "." free, "G" the goal, "@" the agent."""
    signs = np.where(blocked, "#", ".")
    signs[goal], signs[agent] = "G", "@"
    return "\n".join("".join(row) for row in signs) + "\n"


def picture_of(blocked: NDArray[np.bool_], agent: Cell, goal: Cell) -> NDArray[np.uint8]:
    """Return the maze [R, C] as RGB [rows, cols, 3]: a square for the goal, a disc for the agent."""
    edge_px = max(SMALLEST_CELL_PX, PICTURE_PX // max(blocked.shape))
    cells = np.where(blocked[..., None], BLOCKED, FREE).astype(np.uint8)
    picture = cells.repeat(edge_px, axis=0).repeat(edge_px, axis=1)
    free = ~blocked.repeat(edge_px, axis=0).repeat(edge_px, axis=1)
    lines = np.zeros_like(free)
    lines[::edge_px] = lines[:, ::edge_px] = True
    picture[free & lines] = GRID
    from_centre = np.abs(np.arange(edge_px) + 0.5 - edge_px / 2) / edge_px
    square = np.maximum(from_centre[:, None], from_centre) <= 0.375
    disc = np.hypot(from_centre[:, None], from_centre) <= 0.3
    for cell, mask, colour in ((goal, square, GOAL), (agent, disc, AGENT)):
        corner = cell.row * edge_px, cell.col * edge_px
        picture[corner[0] : corner[0] + edge_px, corner[1] : corner[1] + edge_px][mask] = colour
    return picture
