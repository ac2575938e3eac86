from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.recording.td_pictures import FIRST_UNTRIED, HIGHEST, LEVELS, LOWEST, WALL, level_classes, td_levels

FREE = np.zeros((3, 4), dtype=np.bool_)


def levels_of(td_error: float) -> int:
    return int(td_levels(np.full((3, 4, 4), td_error), FREE)[0, 0])


def test_the_cell_with_the_large_td_error_is_the_bright_one_and_walls_are_dark() -> None:
    td, blocked = np.full((3, 4, 4), 0.5), FREE.copy()
    td[1, 2] = 4000.0
    blocked[0, 0] = True
    levels = td_levels(td, blocked)
    brightness = {level: sum(rgb) for level, _, rgb in level_classes()}
    shown = np.vectorize(brightness.get)(levels)
    assert np.unravel_index(shown.argmax(), shown.shape) == (1, 2)
    assert np.unravel_index(shown.argmin(), shown.shape) == (0, 0)
    assert (shown == shown.max()).sum() == 1


def test_a_level_is_a_quarter_of_a_power_of_ten_of_the_mean_over_the_actions() -> None:
    td = np.zeros((3, 4, 4))
    td[0, 0] = (400.0, 0.0, 0.0, 0.0)
    assert td_levels(td, FREE)[0, 0] == levels_of(100.0) == levels_of(10.0) + 4 == levels_of(1.0) + 8


@pytest.mark.parametrize(("td_error", "level"), [(0.0, 1), (10**LOWEST, 1), (10**HIGHEST, LEVELS), (1e9, LEVELS)])
def test_the_scale_ends_at_both_ends(td_error: float, level: int) -> None:
    assert levels_of(td_error) == level


@pytest.mark.parametrize("untried", [1, 2, 3, 4])
def test_a_cell_with_untried_actions_says_how_many_whatever_the_others_are(untried: int) -> None:
    td = np.full((3, 4, 4), 9000.0)
    td[2, 3, :untried] = np.nan
    level = int(td_levels(td, FREE)[2, 3])
    assert level == FIRST_UNTRIED + untried - 1
    assert {number: text for number, text, _ in level_classes()}[level] == f"{untried} of 4 actions never tried"


def test_a_wall_is_a_wall_even_where_its_entries_were_never_tried() -> None:
    assert (td_levels(np.full((3, 4, 4), np.nan), ~FREE) == WALL).all()


def test_every_level_has_its_own_number_and_colour() -> None:
    numbers, colours = [c[0] for c in level_classes()], [c[2] for c in level_classes()]
    assert numbers == list(range(LEVELS + 5))
    assert len(set(colours)) == len(colours)
