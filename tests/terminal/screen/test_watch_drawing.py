"""The maze in characters while an agent learns in it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_run import GOALS, STARTS, small_maze

from twonav_cli.grid import Cell
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.game import NO_ARROW
from twonav_cli.terminal.screen.picture import Picture
from twonav_cli.terminal.screen.watch_drawing import (
    AGENT,
    AGENT_PIXEL,
    CURRENT_GOAL,
    UNKNOWN,
    WALL,
    Heat,
    Sight,
    draw_sight,
    framed,
    heat_of,
    scale_colour,
)
from twonav_cli.terminal.screen.watch_keys import TD_ERRORS, VALUES, VISITS

SHAPE = (5, 6)
UNTRIED = Heat(np.full(SHAPE, np.nan), np.nan, np.nan, np.full(SHAPE, NO_ARROW, dtype=np.int8))


def sight(**changes: object) -> Sight:
    made = Sight(small_maze().blocked, UNTRIED, dict(GOALS), "desk", STARTS["s1"], Cell(0, 3))
    return framed(replace(made, **changes))


def lines(picture: Picture) -> list[str]:
    return picture.text().plain.split("\n")


def drawn(shown: Sight, zoom: int, coloured: bool = True) -> Picture:
    return draw_sight(shown, zoom, 99, 99, coloured)


def tables(value: float = 80.0, td: float = 1e4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return np.full((*SHAPE, 4), value), np.full((*SHAPE, 4), td), np.zeros((*SHAPE, 4), dtype=np.int64)


def test_without_colour_walls_goals_start_and_agent_are_characters() -> None:
    assert lines(drawn(sight(), 1, coloured=False)) == [
        "################",
        "##S     @   2 ##",
        "##  ########  ##",
        "##    3       ##",
        "########      ##",
        "##1           ##",
        "################",
    ]


def test_a_wide_wall_around_the_maze_is_cut_to_one_cell() -> None:
    blocked = np.pad(small_maze().blocked, 4, constant_values=True)
    wide = Heat(np.full(blocked.shape, np.nan), np.nan, np.nan, np.full(blocked.shape, NO_ARROW, dtype=np.int8))
    goals = {name: Cell(row + 4, col + 4) for name, (row, col) in GOALS.items()}
    moved = framed(Sight(blocked, wide, goals, "desk", Cell(4, 4), Cell(4, 7), (Cell(4, 6),)))
    assert np.array_equal(moved.blocked, sight().blocked)
    assert (moved.goals, moved.start, moved.cell) == (sight().goals, sight().start, sight().cell)
    assert moved.trail == (Cell(1, 3),)


@pytest.mark.parametrize(("zoom", "size"), [(0, (4, 8)), (1, (7, 16)), (2, (14, 32)), (3, (21, 48))])
def test_a_zoom_takes_the_places_it_says(zoom: int, size: tuple[int, int]) -> None:
    for coloured in (True, False):
        picture = drawn(sight(), zoom, coloured)
        assert (picture.rows, picture.cols) == size


def test_where_there_is_no_room_the_surroundings_of_the_agent_are_shown() -> None:
    assert lines(draw_sight(sight(), 1, 3, 7, coloured=False)) == ["#######", "   @   ", "#######"]
    assert lines(draw_sight(sight(cell=Cell(4, 5)), 1, 2, 4, coloured=False)) == ["    ", "  @ "]


def test_cells_are_coloured_by_their_share_and_grey_before_the_first_try() -> None:
    shares = np.full(SHAPE, np.nan)
    shares[4, 2], shares[4, 3] = 0.0, 1.0
    picture = drawn(sight(heat=replace(UNTRIED, shares=shares)), 1)
    row = picture.paper[5]
    assert tuple(row[2 * 3]) == scale_colour(0.0)
    assert tuple(row[2 * 4]) == scale_colour(1.0)
    assert tuple(row[2 * 5]) == UNKNOWN
    assert tuple(picture.paper[0, 0]) == WALL


def test_the_scale_gets_brighter_so_that_it_is_read_without_telling_its_hues() -> None:
    brightness = [np.array(scale_colour(share)) @ (0.299, 0.587, 0.114) for share in np.linspace(0, 1, 9)]
    assert (np.diff(brightness) > 0).all()


def test_arrows_stand_in_wide_cells_and_beside_them_the_trail() -> None:
    arrows = np.full(SHAPE, NO_ARROW, dtype=np.int8)
    arrows[0, 1:3] = (3, 1)
    shown = sight(heat=replace(UNTRIED, arrows=arrows), trail=(Cell(0, 1), Cell(0, 2), Cell(0, 3)))
    assert lines(drawn(shown, 1))[1][:10] == "  S →•↓•● "
    assert lines(drawn(shown, 1, coloured=False))[1][:10] == "##S >*v*@ "


def test_the_trail_fades_towards_its_beginning() -> None:
    shown = sight(trail=tuple(Cell(4, col) for col in (1, 2, 3, 4)), cell=Cell(4, 4), goal="bed")
    pixels = drawn(shown, 0).paper[2]  # the lower halves of maze rows 3 and 4: row 5 of the frame
    nearness = [np.abs(pixels[col].astype(int) - AGENT).sum() for col in (2, 3, 4)]
    assert nearness == sorted(nearness, reverse=True)
    assert nearness[0] > nearness[-1]


@pytest.mark.parametrize("cell", [Cell(0, 3), Cell(4, 3), GOALS["bed"]])
def test_in_half_places_the_agent_is_one_pixel_that_nothing_hides(cell: Cell) -> None:
    picture = drawn(sight(cell=cell), 0)
    row, col = cell.row + 1, cell.col + 1
    half = picture.ink if row % 2 == 0 else picture.paper
    assert tuple(half[row // 2, col]) == AGENT_PIXEL
    assert picture.glyphs[row // 2, col] == "▀"


def test_the_current_goal_and_the_agent_fill_their_cells() -> None:
    picture = drawn(sight(), 2)
    goal, agent = GOALS["desk"], Cell(0, 3)
    for cell, colour in ((goal, CURRENT_GOAL), (agent, AGENT)):
        places = picture.paper[2 * cell.row + 2 : 2 * cell.row + 4, 4 * cell.col + 4 : 4 * cell.col + 8]
        assert (places == colour).all()
    other = GOALS["bed"]
    assert tuple(picture.paper[2 * other.row + 2, 4 * other.col + 5]) == palette.DARK
    assert tuple(picture.paper[2 * other.row + 3, 4 * other.col + 4]) == UNKNOWN


def test_values_are_those_of_the_best_action_where_anything_was_tried() -> None:
    q, td, visits = tables()
    q[0, 0], td[0, 0] = (70, 90, 60, 50), 4.0
    q[4, 5, 2], td[4, 5, 2] = 79.0, 1.0
    heat = heat_of(VALUES, q, td, visits, 80.0, 1e4)
    assert (heat.low, heat.high) == (80.0, 90.0)
    assert (heat.shares[0, 0], heat.shares[4, 5]) == (1.0, 0.0)
    assert np.isnan(heat.shares).sum() == 30 - 2
    assert heat.arrows[0, 0] == 1
    assert heat.arrows[2, 2] == NO_ARROW


def test_td_errors_and_visits_are_on_a_logarithmic_scale() -> None:
    q, td, visits = tables()
    td[0, 0], td[0, 1], td[0, 2] = 1.0, 100.0, 1e4
    q[0, 2] = 1.0
    heat = heat_of(TD_ERRORS, q, td, visits, 80.0, 1e4)
    assert heat.shares[0, :3].tolist() == pytest.approx([0.0, 0.5, 1.0])
    assert (heat.arrows == NO_ARROW).all()
    visits[1, 0], visits[0, 0], visits[0, 5] = 25, (0, 0, 1, 0), (10, 0, 0, 0)
    heat = heat_of(VISITS, q, td, visits, 80.0, 1e4)
    assert (heat.low, heat.high) == (1.0, 100.0)
    assert heat.shares[0, 5] == pytest.approx(0.5)


def test_a_table_of_which_nothing_is_known_has_no_scale() -> None:
    heat = heat_of(VALUES, *tables(), 80.0, 1e4)
    assert np.isnan(heat.shares).all()
    assert np.isnan(heat.low)
    assert drawn(sight(heat=heat), 1).rows == 7


def test_a_table_of_one_value_is_drawn_too() -> None:
    q, td, visits = tables(td=5.0)
    heat = heat_of(VALUES, q, td, visits, 80.0, 1e4)
    assert (heat.shares == 1.0).all()
