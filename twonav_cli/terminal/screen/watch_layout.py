"""How the terminal is shared while one watches an agent learn: maze, TD errors and numbers, two lines below."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from twonav_cli.terminal.screen.layout import FRAME

LINES_BELOW = 2
ZOOMS = (4, 3, 2, 1, 0)
"""Zooms of the maze, the best first; `watch_drawing` says what they mean."""

BAR_COLS = 30
"""Columns that the TD errors need, frame included."""

NUMBER_COLS = 40
NUMBER_ROWS = 7
"""What the numbers need, frame included."""


class Box(NamedTuple):
    """Where a panel lies, in characters; without rows it is hidden."""

    left: int
    top: int
    cols: int
    rows: int


@dataclass(frozen=True)
class WatchLayout:
    """Where everything is."""

    zoom: int
    maze: Box
    errors: Box
    numbers: Box


def watch_layout(cols: int, rows: int, maze_rows: int, maze_cols: int, goals: int) -> WatchLayout:
    """Share `cols` x `rows` characters: the maze as large as it can be with everything else beside or below it.

    Args:
        cols: Width of the terminal.
        rows: Height of the terminal.
        maze_rows: Rows of the maze, the wall around it included.
        maze_cols: Columns of the maze, the same.
        goals: Number of goals, one line each.
    """
    high = max(rows - LINES_BELOW, 1)
    for zoom in ZOOMS:
        wide, tall = size_of(zoom, maze_rows, maze_cols)
        for shared in (_errors_beside, _all_beside, _all_below):
            found = shared(cols, high, wide + FRAME, tall + FRAME, goals + FRAME)
            if found is not None:
                return WatchLayout(zoom, *found)
    return WatchLayout(0, *_cramped(cols, high))


def size_of(zoom: int, maze_rows: int, maze_cols: int) -> tuple[int, int]:
    """Return the columns and rows of characters that a maze takes."""
    return (2 * zoom * maze_cols, zoom * maze_rows) if zoom else (maze_cols, (maze_rows + 1) // 2)


def _errors_beside(cols: int, high: int, wide: int, tall: int, lines: int) -> tuple[Box, Box, Box] | None:
    """Return maze and TD errors side by side, the numbers below both."""
    top = max(tall, lines)
    if wide + BAR_COLS > cols or top + NUMBER_ROWS > high:
        return None
    top = max(top, high - 2 * NUMBER_ROWS)
    return Box(0, 0, wide, top), Box(wide, 0, cols - wide, top), Box(0, top, cols, high - top)


def _all_beside(cols: int, high: int, wide: int, tall: int, lines: int) -> tuple[Box, Box, Box] | None:
    """Return the maze at the left, TD errors and numbers at the right."""
    if wide + NUMBER_COLS > cols or tall > high or lines + NUMBER_ROWS + FRAME > high:
        return None
    right = cols - wide
    return Box(0, 0, wide, high), Box(wide, 0, right, lines), Box(wide, lines, right, high - lines)


def _all_below(cols: int, high: int, wide: int, tall: int, lines: int) -> tuple[Box, Box, Box] | None:
    """Return the maze on top, TD errors and numbers side by side below it."""
    if wide > cols or tall + max(lines, NUMBER_ROWS) > high or cols < BAR_COLS + NUMBER_COLS:
        return None
    left, low = BAR_COLS + (cols - BAR_COLS - NUMBER_COLS) // 2, high - tall
    return Box(0, 0, cols, tall), Box(0, tall, left, low), Box(left, tall, cols - left, low)


def _cramped(cols: int, high: int) -> tuple[Box, Box, Box]:
    """Return what can be had where not everything fits: part of the maze, and the numbers if there is room."""
    below = NUMBER_ROWS if high >= 2 * NUMBER_ROWS else 0
    beside = BAR_COLS if cols >= 2 * BAR_COLS else 0
    top = high - below
    return Box(0, 0, cols - beside, top), Box(cols - beside, 0, beside, top if beside else 0), Box(0, top, cols, below)
