"""The numbers of the game."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fake_game import FakeGame, fake_belief

from twonav_cli.events import Filtered
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.terminal.screen.game import GameState, advance
from twonav_cli.terminal.screen.game_view import marks_of_game, pose_text

COLUMNS = 25
"""Width of the poses on the screen."""


@pytest.fixture
def state() -> GameState:
    """Return the state after a trial, far off and unsure."""
    state = GameState()
    game = FakeGame()
    for event in [*game.began(), *game.walk("kitchen")]:
        state = advance(state, event)
    return replace(
        state,
        pose_true=Pose(11.62, 10.64, 2.0),
        pose_estimate=Pose(11.0, 14.1, 0.1),
        cell_true=Cell(22, 27),
        cell_believed=Cell(13, 28),
        belief=fake_belief((0.5, 11.0, 14.1), (0.3, 12.3, 4.2), (0.15, 1.0, 2.0), (0.02, 5.0, 5.0), lost=0.1),
    )


def shown(state: GameState, rows: int) -> list[str]:
    return pose_text(state, rows).plain.split("\n")


def test_the_confidence_is_one_number_and_other_places_have_their_weights(state: GameState) -> None:
    assert shown(state, 10)[3:6] == ["sure   0.45", "or 0.27 at (12.3, 4.2)", "or 0.14 at (1.0, 2.0)"]


@pytest.mark.parametrize("rows", [5, 6, 9, 15])
def test_every_line_fits_its_column_and_their_number_its_rows(state: GameState, rows: int) -> None:
    lines = shown(state, rows)
    assert len(lines) <= rows
    assert max(len(line) for line in lines) <= COLUMNS
    assert any(line.startswith("or 0.27") for line in lines)


def test_a_filter_has_the_say_over_the_picture_and_tells_its_spread(state: GameState) -> None:
    others = np.array([(0.22, 3.0, 1.0), (0.01, 2.0, 2.0)])
    filtered = Filtered(0.77, 0.123, 0.1, np.zeros((5, 3), np.float32), others)
    lines = shown(replace(state, filtered=filtered), 10)
    assert lines[3:5] == ["sure   0.77 ±12 cm", "or 0.22 at (3.0, 1.0)"]
    assert marks_of_game(replace(state, filtered=filtered)).others == ((3.0, 1.0),)


def test_without_a_belief_nothing_is_said_of_it(state: GameState) -> None:
    lines = shown(replace(state, belief=None), 10)
    assert [line.split()[0] for line in lines] == ["true", "belief", "error", "cell", "action"]


def test_the_heat_can_be_left_out_but_not_the_other_places(state: GameState) -> None:
    marks = marks_of_game(state, heat=False)
    assert marks.belief is None
    assert [round(x_m, 1) for x_m, _ in marks.others] == [12.3, 1.0]
    assert marks_of_game(state).belief is state.belief
