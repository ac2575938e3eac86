"""The floor plan drawn in characters, with what moves on it; coloured half-blocks, or ASCII without any colour.

G goals, R rows, C columns of the maze; a place is a character of the terminal.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.geometry import Pose, points_in_map
from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze
from twonav_cli.terminal.console import in_colour
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.floor_plan import Plan, Sheet, fitted, goal_key, plan_of_map, shares
from twonav_cli.terminal.screen.heat_drawing import boxed, heat_of, heated, put_heat_glyphs
from twonav_cli.terminal.screen.picture import Picture, picture_of_glyphs, picture_of_pixels

if TYPE_CHECKING:
    from rich.text import Text

    from twonav_cli.scene.catalog import Room

HEADINGS = "→↗↑↖←↙↓↘"
"""One glyph per eighth of a turn, from +x counter-clockwise."""

ACTION_ARROWS = np.array(list("↑↓←→"))
ACTION_ARROWS_ASCII = np.array(list("^v<>"))
SCENE_ROWS = 30
"""Height of a printed plan at most."""

WALL_SHARE = 0.3
"""Share of a character that must be occupied before ASCII draws it as a wall."""

THIN_WALL_SHARE = 0.95
"""Share of a line of map pixels through a character that makes it a wall, however thin."""

ARROW_SHARE = 0.12
"""Share of a character that may be occupied where an arrow still stands."""

HEATED_WALL = 0.5
"""Share of a pixel that may be occupied where the heat still shows."""

HEATED = 0.34
"""Heat from which a character has no arrow: one bin of the belief holds 1 % or more."""

OTHER_PLACE = "?"
ESTIMATE_ASCII = "&"

BEAMS_RAD = np.linspace(-math.pi / 2, math.pi / 2, 180)


@dataclass(frozen=True)
class Marks:
    """What moves on a plan.

    Attributes:
        goal: Name of the current goal.
        pose_true: Where the robot is.
        pose_estimate: Where it believes to be.
        trail: Positions (x_m, y_m) it came along.
        scan_m: [180] ranges from right to left, drawn where the beam hit something.
        arrows: [R, C] best action towards the goal, -1 for none.
        values: [R, C] their values, for the colour.
        names: Whether every goal carries its name, not the current one only.
        belief: What the last picture says, for the heat.
        others: Positions (x_m, y_m) of the other places where the robot could be.
    """

    goal: str = ""
    pose_true: Pose | None = None
    pose_estimate: Pose | None = None
    trail: tuple[tuple[float, float], ...] = ()
    scan_m: NDArray[np.float64] | None = None
    arrows: NDArray[np.int8] | None = None
    values: NDArray[np.float64] | None = None
    names: bool = False
    belief: Belief | None = None
    others: tuple[tuple[float, float], ...] = ()


def draw_plan(plan: Plan, marks: Marks, rows: int, cols: int, coloured: bool = True) -> Picture:
    """Return the plan as the largest picture of its own shape within `rows` x `cols` characters."""
    sheet = fitted(plan, rows, cols)
    if not coloured:
        picture = picture_of_glyphs(_floor_glyphs(plan, sheet).copy())
        if marks.belief is not None:
            put_heat_glyphs(picture.glyphs, boxed(marks.belief, sheet, sheet.rows, sheet.cols))
        _put_arrows(picture, plan, sheet, marks, ACTION_ARROWS_ASCII)
        for x_m, y_m in marks.trail:
            _put_at(picture, sheet, x_m, y_m, "*")
    else:
        floor = _heated_floor(plan, sheet, marks)
        pixels = floor.copy()
        _put_trail(pixels, sheet, marks)
        picture = picture_of_pixels(pixels)
        _put_arrows(picture, plan, sheet, marks, ACTION_ARROWS, _paper(floor))
    for name, (x_m, y_m) in plan.rooms.items():
        _put_centred(picture, sheet, x_m, y_m, name)
    _put_goals(picture, plan, sheet, marks)
    for x_m, y_m in marks.others:
        _put_at(picture, sheet, x_m, y_m, OTHER_PLACE, palette.DARK, palette.OTHER)
    _put_robot(picture, sheet, marks)
    return picture


@lru_cache(maxsize=16)
def _floor_pixels(plan: Plan, sheet: Sheet) -> NDArray[np.uint8]:
    """Return walls, floor and outside [2 rows, cols, 3]; a pixel that is partly wall is a mixture."""
    occupied, inside = shares(plan, 2 * sheet.rows, sheet.cols)
    known = np.where(occupied < 1, inside / np.maximum(1 - occupied, 1e-9), 0.0)[..., None]
    ground = known * palette.FLOOR + (1 - known) * palette.OUTSIDE
    wall = np.minimum(occupied * 1.5, 1.0)[..., None] ** 0.7
    return np.asarray(ground * (1 - wall) + wall * palette.WALL, dtype=np.uint8)


def _heated_floor(plan: Plan, sheet: Sheet, marks: Marks) -> NDArray[np.uint8]:
    """Return the floor's pixels [2 rows, cols, 3] with the belief as a heat."""
    pixels = _floor_pixels(plan, sheet)
    if marks.belief is None:
        return pixels
    heat = heat_of(boxed(marks.belief, sheet, 2 * sheet.rows, sheet.cols))
    return heated(pixels, heat, shares(plan, 2 * sheet.rows, sheet.cols)[0] < HEATED_WALL)


@lru_cache(maxsize=16)
def _floor_glyphs(plan: Plan, sheet: Sheet) -> NDArray[np.str_]:
    """Return walls as #, floor as ., outside as blank [rows, cols]; a thin wall right across a place counts."""
    occupied, inside = shares(plan, sheet.rows, sheet.cols)
    across, _ = shares(plan, plan.frame.rows, sheet.cols)
    down, _ = shares(plan, sheet.rows, plan.frame.cols)
    tops = np.arange(sheet.rows) * plan.frame.rows // sheet.rows
    lefts = np.arange(sheet.cols) * plan.frame.cols // sheet.cols
    thin = np.maximum(np.maximum.reduceat(across, tops, axis=0), np.maximum.reduceat(down, lefts, axis=1))
    wall = (occupied >= WALL_SHARE) | (thin >= THIN_WALL_SHARE)
    return np.where(wall, "#", np.where(inside > 0.3, ".", " ")).astype("<U1")


def _put_trail(pixels: NDArray[np.uint8], sheet: Sheet, marks: Marks) -> None:
    """Colour the pixels of the trail, and of what the laser hit."""
    for x_m, y_m in marks.trail:
        if (pixel := sheet.pixel_at(x_m, y_m)) is not None:
            pixels[pixel] = palette.TRAIL
    if marks.scan_m is None or marks.pose_true is None or len(marks.scan_m) != len(BEAMS_RAD):
        return
    hit = marks.scan_m < marks.scan_m.max() - 1e-3
    beams = np.stack([np.cos(BEAMS_RAD), np.sin(BEAMS_RAD)], axis=-1)[hit] * marks.scan_m[hit, None]
    for x_m, y_m in points_in_map(marks.pose_true, beams):
        if (pixel := sheet.pixel_at(float(x_m), float(y_m))) is not None:
            pixels[pixel] = palette.SCAN


def _put_arrows(
    picture: Picture,
    plan: Plan,
    sheet: Sheet,
    marks: Marks,
    glyphs: NDArray[np.str_],
    paper: NDArray[np.uint8] | None = None,
) -> None:
    """Write the arrow of the maze cell under every free character off the trail; wide cells have one arrow each."""
    frame = plan.maze_frame
    if marks.arrows is None or frame is None:
        return
    xs, ys = sheet.centres()
    cols = np.floor((xs - frame.x_min_m) / frame.resolution_m).astype(np.int64)
    rows = np.floor((frame.y_max_m - ys) / frame.resolution_m).astype(np.int64)
    in_frame = np.outer((rows >= 0) & (rows < frame.rows), (cols >= 0) & (cols < frame.cols))
    first = np.ones((sheet.rows, sheet.cols), dtype=np.bool_)
    if sheet.cols >= 2 * frame.cols:
        centre_xs, centre_ys = frame.centres()
        first = np.outer(_nearest(centre_ys, ys), _nearest(centre_xs, xs))
    for x_m, y_m in marks.trail:
        if (place := sheet.place_at(x_m, y_m)) is not None:
            first[place] = False
    cells = np.ix_(np.clip(rows, 0, frame.rows - 1), np.clip(cols, 0, frame.cols - 1))
    action = marks.arrows[cells]
    occupied, inside = shares(plan, sheet.rows, sheet.cols)
    shown = first & in_frame & (action >= 0) & (occupied <= ARROW_SHARE) & (inside > 0.5)
    shown &= picture.glyphs != "#"
    if marks.belief is not None:
        shown &= heat_of(boxed(marks.belief, sheet, sheet.rows, sheet.cols)) < HEATED
    picture.glyphs[shown] = glyphs[action[shown]]
    if not picture.coloured:
        return
    values = marks.values[cells] if marks.values is not None else np.ones(action.shape)
    picture.ink[shown] = palette.viridis(_ranked(values[shown]))
    if paper is not None:
        picture.paper[shown] = paper[shown]


def _nearest(centres_m: NDArray[np.float64], places_m: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which places [P] of an axis are the nearest one to a cell's centre [N]."""
    chosen = np.zeros(len(places_m), dtype=np.bool_)
    chosen[np.abs(centres_m[:, None] - places_m).argmin(axis=1)] = True
    return chosen


def _paper(pixels: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the mean colour of both pixels [2 rows, cols, 3] of every character [rows, cols, 3]."""
    wide = pixels.astype(np.uint16)
    return ((wide[::2] + wide[1::2]) // 2).astype(np.uint8)


def _ranked(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return values [N] as shares of their range, 1 for the largest."""
    if not len(values) or np.isnan(values).all():
        return np.ones(len(values))
    low, high = np.nanmin(values), np.nanmax(values)
    return np.nan_to_num((values - low) / (high - low) if high > low else np.ones(len(values)))


def _put_goals(picture: Picture, plan: Plan, sheet: Sheet, marks: Marks) -> None:
    """Write every goal's key where it is; the current one stands out and carries its name."""
    order = sorted(plan.goals, key=lambda name: name == marks.goal)
    for name in order:
        place = sheet.place_at(*plan.goals[name])
        if place is None:
            continue
        row, col = place
        current = name == marks.goal
        text = goal_key(list(plan.goals).index(name)) or "o"
        if current or marks.names:
            text = f"{text} {name}"
        col = max(min(col, sheet.cols - len(text)), 0)
        if current:
            picture.put(row, col, text, palette.DARK, palette.CURRENT_GOAL, bold=True)
        else:
            picture.put(row, col, text, palette.GOAL, _floor_paper_of(picture), bold=True)


def _floor_paper_of(picture: Picture) -> palette.Rgb | None:
    return palette.FLOOR if picture.coloured else None


def _put_robot(picture: Picture, sheet: Sheet, marks: Marks) -> None:
    """Write the estimate and over it the true pose; in one place the true one's paper carries the other's ink."""
    true = sheet.place_at(*marks.pose_true[:2]) if marks.pose_true else None
    estimate = sheet.place_at(*marks.pose_estimate[:2]) if marks.pose_estimate else None
    if estimate is not None and marks.pose_estimate is not None:
        glyph = heading_glyph(marks.pose_estimate.theta_rad) if picture.coloured else ESTIMATE_ASCII
        picture.put(*estimate, glyph, palette.DARK, palette.ESTIMATE, bold=True)
    if true is not None and marks.pose_true is not None:
        glyph = heading_glyph(marks.pose_true.theta_rad) if picture.coloured else "@"
        ink = palette.TOGETHER if true == estimate else palette.DARK
        picture.put(*true, glyph, ink, palette.TRUE, bold=True)


def heading_glyph(theta_rad: float) -> str:
    """Return the arrow of the nearest eighth of a turn."""
    return HEADINGS[round(theta_rad / (math.pi / 4)) % 8]


def _put_at(
    picture: Picture,
    sheet: Sheet,
    x_m: float,
    y_m: float,
    glyph: str,
    ink: palette.Rgb | None = None,
    paper: palette.Rgb | None = None,
) -> None:
    place = sheet.place_at(x_m, y_m)
    if place is not None:
        picture.put(*place, glyph, ink, paper, bold=ink is not None)


def _put_centred(picture: Picture, sheet: Sheet, x_m: float, y_m: float, text: str) -> None:
    """Write a room's name about a point."""
    place = sheet.place_at(x_m, y_m)
    if place is not None:
        col = max(min(place[1] - len(text) // 2, sheet.cols - len(text)), 0)
        picture.put(place[0], col, text, palette.ROOM, _floor_paper_of(picture))


def draw_scene(
    maze: Maze,
    maze_frame: GridFrame,
    occupied: NDArray[np.bool_],
    map_frame: GridFrame,
    cols: int,
    rooms: Mapping[str, Room] | None = None,
    coloured: bool | None = None,
) -> Text:
    """Return the plan of a scene as it is printed: the drawing, and below it the goals with their coordinates.

    Args:
        maze: Its goals are marked.
        maze_frame: Where the maze lies.
        occupied: [map rows, map cols] the map.
        map_frame: Where the map lies.
        cols: Width of the terminal.
        rooms: Rooms to name, map frame.
        coloured: False for ASCII; None asks the terminal.
    """
    coloured = in_colour() if coloured is None else coloured
    goals = {name: maze_frame.centre_of(cell) for name, cell in maze.goals.items()}
    centres = {n: ((r.x_min_m + r.x_max_m) / 2, (r.y_min_m + r.y_max_m) / 2) for n, r in (rooms or {}).items()}
    plan = plan_of_map(occupied, map_frame, goals, centres, maze_frame)
    text = draw_plan(plan, Marks(), SCENE_ROWS, cols, coloured).text()
    text.append("\n\n")
    return text.append_text(legend(goals, cols, coloured))


def legend(goals: Mapping[str, tuple[float, float]], cols: int, coloured: bool = True) -> Text:
    """Return every goal's mark, name and coordinates (metres) in as many columns as fit."""
    from rich.text import Text

    strong = f"bold {palette.hexadecimal(palette.CURRENT_GOAL)}" if coloured else ""
    quiet = palette.hexadecimal(palette.QUIET) if coloured else ""
    wide = max((len(name) for name in goals), default=0)
    entries = [
        Text.assemble((goal_key(at) or "o", strong), f" {name:<{wide}}", (f"  x {x_m:6.2f} m  y {y_m:6.2f} m", quiet))
        for at, (name, (x_m, y_m)) in enumerate(goals.items())
    ]
    columns = max(1, min((cols + 3) // (len(entries[0]) + 3), 3)) if entries else 1
    lines = math.ceil(len(entries) / columns)
    rows = [Text("   ").join(entries[line::lines]) for line in range(lines)]
    return Text("\n").join(rows)
