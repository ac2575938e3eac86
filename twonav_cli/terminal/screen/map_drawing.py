"""A map as it is, pixel by pixel or as small as it must be, with the blocked cells of its maze over it.

What is free, occupied and unknown differs in brightness, and without colour in the character.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from twonav_cli.maze import Maze
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.picture import Picture, picture_of_glyphs, picture_of_pixels

if TYPE_CHECKING:
    from rich.text import Text

BLOCKED_TINT = 0.55
"""How much of the colour of blocked cells covers the map."""

BLOCKED: palette.Rgb = (120, 74, 30)
UNKNOWN_COLOUR: palette.Rgb = (74, 84, 102)
FREE_COLOUR: palette.Rgb = (14, 18, 26)
GLYPHS = {OCCUPIED: "#", FREE: ".", UNKNOWN: " "}
GLYPHS_BLOCKED = {OCCUPIED: "#", FREE: "x", UNKNOWN: "-"}
"""The same within a cell of the maze that is blocked."""


def draw_map(map_: OccupancyMap, maze: Maze, maze_frame: GridFrame, cols: int, coloured: bool = True) -> Picture:
    """Return a map as the largest picture that is at most `cols` characters wide and no finer than its pixels.

    Args:
        map_: What is drawn; of several pixels in one place the occupied one is seen first, then the unknown one.
        maze: Its blocked cells are marked.
        maze_frame: Where they lie.
        cols: Width of the terminal.
        coloured: False for ASCII.
    """
    per_place = math.ceil(map_.frame.cols / max(cols, 1))
    blocked = blocked_pixels(map_.frame, maze, maze_frame)
    if not coloured:
        kinds, covered = shrunk(map_.pixels, blocked, 2 * per_place, per_place)
        glyphs = np.full(kinds.shape, " ", dtype="<U1")
        for table, of in ((GLYPHS, ~covered), (GLYPHS_BLOCKED, covered)):
            for kind, glyph in table.items():
                glyphs[(kinds == kind) & of] = glyph
        return picture_of_glyphs(glyphs)
    kinds, covered = shrunk(map_.pixels, blocked, per_place, per_place)
    if len(kinds) % 2:  # half a character is left: nothing is known there
        kinds = np.vstack([kinds, np.full((1, kinds.shape[1]), UNKNOWN, dtype=np.uint8)])
        covered = np.vstack([covered, np.zeros((1, covered.shape[1]), dtype=np.bool_)])
    colours = np.empty((*kinds.shape, 3))
    for kind, colour in ((OCCUPIED, palette.WALL), (FREE, FREE_COLOUR), (UNKNOWN, UNKNOWN_COLOUR)):
        colours[kinds == kind] = colour
    tinted = covered & (kinds != OCCUPIED)
    colours[tinted] = (1 - BLOCKED_TINT) * colours[tinted] + BLOCKED_TINT * np.array(BLOCKED)
    return picture_of_pixels(colours.astype(np.uint8))


def blocked_pixels(frame: GridFrame, maze: Maze, maze_frame: GridFrame) -> NDArray[np.bool_]:
    """Return the map's pixels [rows, cols] that lie in a blocked cell, or beyond the maze's last full cell."""
    edge = round(maze_frame.resolution_m / frame.resolution_m)
    covered = np.ones(frame.shape, dtype=np.bool_)
    cells = np.kron(maze.blocked, np.ones((edge, edge), dtype=np.bool_))[: frame.rows, : frame.cols]
    covered[: cells.shape[0], : cells.shape[1]] = cells
    return covered


def shrunk(
    pixels: NDArray[np.uint8], covered: NDArray[np.bool_], rows: int, cols: int
) -> tuple[NDArray[np.uint8], NDArray[np.bool_]]:
    """Return kind and cover of every place of `rows` x `cols` pixels: occupied before unknown before free.

    A place is covered where most of it is.
    """
    pad = ((0, -pixels.shape[0] % rows), (0, -pixels.shape[1] % cols))
    shape = ((pixels.shape[0] + pad[0][1]) // rows, rows, (pixels.shape[1] + pad[1][1]) // cols, cols)
    kinds = np.pad(pixels, pad, mode="edge").reshape(shape)
    occupied = (kinds == OCCUPIED).any(axis=(1, 3))
    unknown = (kinds == UNKNOWN).mean(axis=(1, 3)) >= 0.5
    found = np.where(occupied, OCCUPIED, np.where(unknown, UNKNOWN, FREE)).astype(np.uint8)
    return found, np.asarray(np.pad(covered, pad, mode="edge").reshape(shape).mean(axis=(1, 3)) >= 0.5)


def map_text(map_: OccupancyMap, maze: Maze, maze_frame: GridFrame, cols: int, coloured: bool) -> Text:
    """Return the drawing and below it what its places mean, and how large map and maze are."""
    text = draw_map(map_, maze, maze_frame, cols, coloured).text()
    text.append("\n\n")
    frame = map_.frame
    text.append_text(_wrapped(_legend(coloured), cols))
    text.append(
        f"map: {frame.cols} x {frame.rows} pixels of {frame.resolution_m:g} m, "
        f"{frame.cols * frame.resolution_m:.1f} x {frame.rows * frame.resolution_m:.1f} m\n"
        f"maze: {maze.cols} x {maze.rows} cells of {maze_frame.resolution_m:g} m, {int((~maze.blocked).sum())} free"
    )
    return text


def _legend(coloured: bool) -> list[Text]:
    """Return what the places of a drawing mean, one text each."""
    from rich.text import Text

    if not coloured:
        said = ("# occupied", ". free", "blank unknown", "x free, - unknown in a blocked cell of the maze")
        return [Text(meaning) for meaning in said]
    marks = (
        ("occupied", palette.WALL),
        ("free", FREE_COLOUR),
        ("unknown", UNKNOWN_COLOUR),
        ("blocked (in the maze)", BLOCKED),
    )
    return [Text.assemble(("  ", f"on {palette.hexadecimal(colour)}"), f" {word}") for word, colour in marks]


def _wrapped(parts: list[Text], cols: int) -> Text:
    """Return texts beside each other, as many per line as fit in `cols` characters, each line ended."""
    from rich.text import Text

    gap, lines = "   ", [parts[0].copy()]
    for part in parts[1:]:
        if len(lines[-1]) + len(gap) + len(part) <= cols:
            lines[-1].append(gap).append_text(part)
        else:
            lines.append(part.copy())
    return Text("\n").join([*lines, Text("")])
