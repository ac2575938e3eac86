"""The maze drawn in characters while an agent learns in it: colours of a table, arrows, goals, trail and agent.

R rows, C columns of the maze, A actions, G goals; a place is a character of the terminal. At zoom 0 a cell is half a
place high and one wide; at zoom z it is z places high and 2 z wide.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import Cell
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.floor_plan import goal_key
from twonav_cli.terminal.screen.game import NO_ARROW, greedy_actions
from twonav_cli.terminal.screen.halfblocks import LUMINANCE
from twonav_cli.terminal.screen.picture import HALF_BLOCK, Picture, picture_of_glyphs, picture_of_pixels
from twonav_cli.terminal.screen.plan_drawing import ACTION_ARROWS, ACTION_ARROWS_ASCII
from twonav_cli.terminal.screen.watch_keys import TD_ERRORS, VALUES

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

WALL: palette.Rgb = (24, 29, 37)
UNKNOWN: palette.Rgb = (84, 91, 102)
AGENT: palette.Rgb = palette.ESTIMATE
"""Also of its trail: no colour of the scale is near it."""

AGENT_PIXEL: palette.Rgb = (255, 255, 255)
"""Where the agent is a single pixel it would be lost in its own trail."""

CURRENT_GOAL: palette.Rgb = (255, 255, 255)
"""White, for the yellow of the other screen is the scale's upper end."""

DIM = 0.8
"""Factor on the colours of the scale, so that what stands on them is seen."""

OLDEST, LATEST = 0.1, 0.8
"""Share of the trail's colour in its first and last cell."""

LEVELS = np.array(list(".:-=+"))
"""The scale where there is no colour, without the characters that mean something else."""

SMALLEST = 1e-4
"""TD errors below this are shown as this: the scale is logarithmic."""


@dataclass(frozen=True, eq=False)
class Heat:
    """A number for every cell, as colour.

    Attributes:
        shares: [R, C] from 0 to 1; NaN where the agent knows nothing yet.
        low: What 0 stands for.
        high: What 1 stands for.
        arrows: [R, C] greedy action, NO_ARROW where there is none to show.
    """

    shares: FloatArray
    low: float
    high: float
    arrows: NDArray[np.int8]


@dataclass(frozen=True, eq=False)
class Sight:
    """What is drawn.

    Attributes:
        blocked: [R, C].
        heat: Colours and arrows.
        goals: Name to cell, in table order.
        goal: The current one.
        start: Where the trial began.
        cell: Where the agent is.
        trail: Cells that it came through, the latest last.
    """

    blocked: BoolArray
    heat: Heat
    goals: dict[str, Cell] = field(default_factory=dict)
    goal: str = ""
    start: Cell | None = None
    cell: Cell | None = None
    trail: tuple[Cell, ...] = ()


def heat_of(
    kind: str, q: FloatArray, td: FloatArray, visits: NDArray[np.int64], initial_q: float, initial_td: float
) -> Heat:
    """Return one goal's table as colours.

    Args:
        kind: One of `watch_keys.HEATS`.
        q: [R, C, A] values of the goal.
        td: [R, C, A] squared TD errors of the goal.
        visits: [R, C, A] actions taken.
        initial_q: Value of an action that was never tried.
        initial_td: Its TD error.
    """
    known = ((q != initial_q) | (td != initial_td)).any(axis=2)
    arrows = np.full(known.shape, NO_ARROW, dtype=np.int8)
    if kind == VALUES:
        arrows[known] = greedy_actions(q[None])[0][known]
        return _scaled(q.max(axis=2), known, arrows)
    if kind == TD_ERRORS:
        return _scaled(np.maximum(td.max(axis=2), SMALLEST), known, arrows, logarithmic=True)
    taken = visits.sum(axis=2).astype(np.float64)
    return _scaled(np.maximum(taken, 1.0), taken > 0, arrows, logarithmic=True)


def _scaled(numbers: FloatArray, known: BoolArray, arrows: NDArray[np.int8], logarithmic: bool = False) -> Heat:
    """Return numbers [R, C] as shares of the range that they have where they are known."""
    if not known.any():
        return Heat(np.full(numbers.shape, np.nan), np.nan, np.nan, arrows)
    low, high = float(numbers[known].min()), float(numbers[known].max())
    scaled = np.log(numbers / low) if logarithmic else numbers - low
    span = np.log(high / low) if logarithmic else high - low
    shares = scaled / span if span > 0 else np.ones(numbers.shape)
    return Heat(np.where(known, shares, np.nan), low, high, arrows)


def draw_sight(sight: Sight, zoom: int, rows: int, cols: int, coloured: bool = True) -> Picture:
    """Return a sight at a zoom; where `rows` x `cols` characters are too few, what lies around the agent."""
    if not coloured:
        picture = _glyphs(sight, zoom)
    elif zoom == 0:
        picture = _half_places(sight)
    else:
        picture = _whole_places(sight, zoom)
    place = _place_of(sight.cell or Cell(0, 0), zoom)
    return _around(picture, place, rows, cols)


def scale_colour(share: float) -> palette.Rgb:
    """Return the colour of a share of the scale, from 0 to 1, as it is drawn."""
    red, green, blue = (DIM * palette.viridis(np.array(share))).astype(int).tolist()
    return red, green, blue


def _colours(sight: Sight) -> NDArray[np.float64]:
    """Return the colour of every cell [R, C, 3], before anything stands on it."""
    known = ~np.isnan(sight.heat.shares)
    colours = np.where(known[..., None], DIM * palette.viridis(np.nan_to_num(sight.heat.shares)), UNKNOWN)
    return np.where(sight.blocked[..., None], WALL, colours)


def _trail_shares(sight: Sight) -> list[tuple[Cell, float]]:
    """Return every cell of the trail but the agent's own with the share of the trail's colour, the latest last."""
    shares = np.linspace(OLDEST, LATEST, len(sight.trail)).tolist()
    return [(cell, share) for cell, share in zip(sight.trail, shares, strict=True) if cell != sight.cell]


def _half_places(sight: Sight) -> Picture:
    """Draw two cells above each other in a place."""
    pixels = _colours(sight)
    for cell, share in _trail_shares(sight):
        pixels[cell] = (1 - share) * pixels[cell] + share * np.array(AGENT)
    if sight.cell is not None:
        pixels[sight.cell] = AGENT_PIXEL
    if len(pixels) % 2:
        pixels = np.concatenate([pixels, np.broadcast_to(np.array(WALL), (1, *pixels.shape[1:]))])
    shown = pixels.astype(np.uint8)
    picture = picture_of_pixels(shown)
    _put_marks(picture, sight, 0)
    if sight.cell is not None:  # over a mark: the agent is where one looks
        row, col = _place_of(sight.cell, 0)
        picture.put(row, col, HALF_BLOCK, tuple(shown[2 * row, col]), tuple(shown[2 * row + 1, col]))
    return picture


def _whole_places(sight: Sight, zoom: int) -> Picture:
    """Draw a cell as zoom x 2 zoom places: its colour, its arrow, and a dot where the agent came through."""
    papers = _colours(sight)
    paper = papers.astype(np.uint8).repeat(zoom, axis=0).repeat(2 * zoom, axis=1)
    glyphs = np.full(paper.shape[:2], " ", dtype="<U1")
    picture = Picture(glyphs, paper.copy(), paper, np.zeros(glyphs.shape, dtype=np.bool_))
    for row, col in np.argwhere(sight.heat.arrows != NO_ARROW).tolist():
        ink = palette.DARK if papers[row, col] @ LUMINANCE > 110 else palette.GOAL
        picture.put(*_place_of(Cell(row, col), zoom), str(ACTION_ARROWS[sight.heat.arrows[row, col]]), ink)
    for cell, share in _trail_shares(sight):
        ink = tuple(((1 - share) * papers[cell] + share * np.array(AGENT)).astype(int).tolist())
        row, col = _place_of(cell, zoom)
        picture.put(row, col + 1, "•", ink, bold=True)
    _put_marks(picture, sight, zoom)
    if sight.cell is not None:
        _put_tile(picture, sight.cell, zoom, "●", palette.DARK, AGENT)
    return picture


def _glyphs(sight: Sight, zoom: int) -> Picture:
    """Draw without colour: # walls, the scale's levels, arrows where there is room, * trail, S start, @ agent."""
    shares = np.nan_to_num(sight.heat.shares, nan=-1.0)
    levels = LEVELS[np.clip((shares * len(LEVELS)).astype(np.int64), 0, len(LEVELS) - 1)]
    cells = np.where(sight.blocked, "#", np.where(shares < 0, " ", levels))
    if zoom == 0:
        cells = np.pad(cells, ((0, len(cells) % 2), (0, 0)), constant_values="#")
        picture = picture_of_glyphs(np.where(cells[::2] == "#", cells[1::2], cells[::2]).astype("<U1"))
    else:
        picture = picture_of_glyphs(cells.repeat(zoom, axis=0).repeat(2 * zoom, axis=1).astype("<U1"))
        for row, col in np.argwhere(sight.heat.arrows != NO_ARROW).tolist():
            glyph = str(ACTION_ARROWS_ASCII[sight.heat.arrows[row, col]])
            picture.put(*_place_of(Cell(row, col), zoom), glyph)
    for cell, _ in _trail_shares(sight):
        row, col = _place_of(cell, zoom)
        picture.put(row, col + (zoom > 0), "*")
    _put_marks(picture, sight, zoom)
    if sight.cell is not None:
        picture.put(*_place_of(sight.cell, zoom), "@")
    return picture


def _put_marks(picture: Picture, sight: Sight, zoom: int) -> None:
    """Write S where the trial began and every goal's key where it is; the current goal stands out."""
    marks = [(sight.start, "S")] if sight.start is not None else []
    keys = {name: goal_key(at) or "o" for at, name in enumerate(sight.goals)}
    marks += [(cell, keys[name]) for name, cell in sight.goals.items() if name != sight.goal]
    for cell, glyph in marks:
        row, col = _place_of(cell, zoom)
        beside = zoom > 1 and picture.coloured
        picture.put(row, col - beside, f" {glyph} " if beside else glyph, palette.GOAL, palette.DARK, bold=True)
    if sight.goal in sight.goals:
        _put_tile(picture, sight.goals[sight.goal], zoom, keys[sight.goal], palette.DARK, CURRENT_GOAL)


def _put_tile(picture: Picture, cell: Cell, zoom: int, glyph: str, ink: palette.Rgb, paper: palette.Rgb) -> None:
    """Fill a cell's places with a paper and write one character into it."""
    if zoom and picture.coloured:
        row, col = cell.row * zoom, cell.col * 2 * zoom
        places = np.s_[row : row + zoom, col : col + 2 * zoom]
        picture.glyphs[places], picture.paper[places] = " ", paper
    picture.put(*_place_of(cell, zoom), glyph, ink, paper, bold=True)


def _place_of(cell: Cell, zoom: int) -> tuple[int, int]:
    """Return the place (row, col) of a cell's character."""
    if zoom == 0:
        return cell.row // 2, cell.col
    return cell.row * zoom + (zoom - 1) // 2, cell.col * 2 * zoom + zoom - 1


def _around(picture: Picture, place: tuple[int, int], rows: int, cols: int) -> Picture:
    """Return `rows` x `cols` characters of a picture about a place, the whole where it fits."""
    top, left = (
        max(min(at - room // 2, size - room), 0)
        for at, room, size in ((place[0], rows, picture.rows), (place[1], cols, picture.cols))
    )
    window = np.s_[top : top + rows, left : left + cols]
    return Picture(
        picture.glyphs[window], picture.ink[window], picture.paper[window], picture.bold[window], picture.coloured
    )


def framed(sight: Sight) -> Sight:
    """Return the same sight cut to its free cells and one row or column of walls around them."""
    free = ~np.pad(sight.blocked, 1, constant_values=True)
    rows, cols = np.flatnonzero(free.any(axis=1)), np.flatnonzero(free.any(axis=0))
    top, left = int(rows[0]) - 2, int(cols[0]) - 2  # of the frame's corner, in cells of the maze
    window = np.s_[top + 1 : int(rows[-1]) + 2, left + 1 : int(cols[-1]) + 2]

    def cut(array: NDArray[np.generic], beyond: float) -> NDArray[np.generic]:
        return np.pad(array, 1, constant_values=beyond)[window]

    def moved(cell: Cell) -> Cell:
        return Cell(cell.row - top, cell.col - left)

    heat = sight.heat
    return Sight(
        blocked=~free[window],
        heat=Heat(cut(heat.shares, np.nan), heat.low, heat.high, cut(heat.arrows, NO_ARROW)),  # type: ignore[arg-type]  # as they went in
        goals={name: moved(cell) for name, cell in sight.goals.items()},
        goal=sight.goal,
        start=moved(sight.start) if sight.start is not None else None,
        cell=moved(sight.cell) if sight.cell is not None else None,
        trail=tuple(moved(cell) for cell in sight.trail),
    )
