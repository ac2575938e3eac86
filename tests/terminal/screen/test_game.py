"""The game's state machine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from fake_game import FakeGame, fake_belief

from twonav_cli.events import (
    Clock,
    Filtered,
    GoalAdded,
    Kidnapped,
    Looked,
    Note,
    QSnapshot,
    StepTaken,
    Tick,
    TrialEnded,
)
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.terminal.screen.game import (
    LOG_LINES,
    NO_ARROW,
    GameState,
    advance,
    faster,
    greedy_actions,
    headline,
    pose_error,
    tally,
)


def after(events) -> GameState:
    state = GameState()
    for event in events:
        state = advance(state, event)
    return state


@pytest.fixture
def game() -> FakeGame:
    return FakeGame()


def test_the_headline_is_the_goal_and_its_number_of_actions(game: FakeGame) -> None:
    assert headline(after([*game.began(), *game.walk("kitchen")])) == "kitchen in 26 actions, shortest 26"


def test_a_missed_goal_says_why(game: FakeGame) -> None:
    ended = TrialEnded(Clock(1), "sofa", Cell(12, 23), "time-out", 40, 21, "mislocalized")
    state = after([*game.began(), ended])
    assert headline(state) == "sofa missed after 40 actions: mislocalized"
    assert tally(state) == "0 of 1 reached, 1 time-out"
    assert state.log[-1].level == "WARN"


def test_during_a_trial_the_headline_counts_the_actions_so_far(game: FakeGame) -> None:
    events = [*game.began(), *game.walk("kitchen")]
    second = next(i for i, e in enumerate(events) if isinstance(e, StepTaken) and e.clock.step == 2)
    assert headline(after(events[: second + 1])) == "to kitchen: 2 actions, shortest 26"


def test_a_tick_moves_both_poses_and_its_error_is_the_distance_between_them(game: FakeGame) -> None:
    state = after([*game.began(), *game.walk("kitchen")])
    error = pose_error(state)
    assert error is not None
    assert error[0] == pytest.approx(np.hypot(0.06, 0.03))
    assert error[1] == pytest.approx(0.06)


def test_arrows_are_the_best_actions_and_missing_where_all_are_equal() -> None:
    q = np.full((1, 1, 2, 4), 80.0)
    q[0, 0, 1, 2] = 81.0
    assert greedy_actions(q).tolist() == [[[NO_ARROW, 2]]]


def test_a_step_brings_the_arrow_of_its_cell_up_to_date_and_leaves_the_earlier_state_alone(game: FakeGame) -> None:
    state = after([*game.began(), QSnapshot(Clock(), np.full_like(game.q, 80.0))])
    step = StepTaken(
        Clock(1, 1), "bathroom", Cell(4, 18), 3, Cell(4, 19), "reached", np.array([1.0, 2, 3, 9]), np.arange(10.0), True
    )
    later = advance(state, step)
    assert later.greedy is not None
    assert later.greedy[1, 4, 18] == 3
    assert later.td_error == 1.0
    assert state.greedy is not None
    assert (state.greedy == NO_ARROW).all()


def test_without_poses_the_robot_stands_at_the_centre_of_its_cell(game: FakeGame) -> None:
    step = StepTaken(
        Clock(1, 1), "kitchen", Cell(4, 18), 3, Cell(4, 19), "reached", np.zeros(4), np.zeros(10), True
    )  # fmt: skip
    state = after([*game.began(), step])
    assert state.pose_true == pytest.approx(Pose(-2.4 + 19.5 * 0.4, 9.5 - 4.5 * 0.4, 0.0))
    assert pose_error(state) == (0.0, 0.0)


def test_a_kidnap_starts_the_trail_anew_and_keeps_the_belief(game: FakeGame) -> None:
    before = after([*game.began(), *game.walk("kitchen")])
    state = advance(before, Kidnapped(Clock(), Pose(0, 0, 0), Pose(3, 4, 0)))
    assert state.trail == ((3, 4),)
    assert state.pose_estimate == before.pose_estimate
    assert "carried 5.0 m" in state.log[-1].text


def test_the_log_is_bounded_and_keeps_the_newest() -> None:
    state = after([Note(Clock(), "INFO", str(i)) for i in range(LOG_LINES + 5)])
    assert len(state.log) == LOG_LINES
    assert state.log[-1].text == str(LOG_LINES + 4)


def test_speeds_double_and_stop_at_the_ends() -> None:
    assert faster(2.0, 1) == 4.0
    assert faster(64.0, 1) == 64.0
    assert faster(0.125, -1) == 0.125
    assert faster(0.0, -1) == 64.0


def test_a_goal_that_is_added_is_listed_and_its_arrows_follow_the_steps_at_once(game: FakeGame) -> None:
    before = after([*game.began()])
    state = advance(before, GoalAdded(game.clock, "plant", Cell(4, 20)))
    assert state.goal_names == [*before.goal_names, "plant"]
    assert state.greedy is not None
    assert (state.greedy[10] == NO_ARROW).all()
    step = StepTaken(
        Clock(1, 1), "plant", Cell(4, 18), 3, Cell(4, 19), "reached", np.array([1.0, 2, 3, 9]), np.arange(11.0), True
    )
    later = advance(state, step)
    assert later.greedy is not None
    assert later.greedy[10, 4, 18] == 3
    assert later.td_error == 10.0
    assert len(before.goal_names) == 10


def test_a_look_brings_the_pose_and_the_belief_that_the_next_one_replaces(game: FakeGame) -> None:
    before = after([*game.began(), *game.walk("kitchen")])
    said = fake_belief((1.0, 3.0, 4.0))
    looked = Looked(Clock(), Pose(5, 5, 0), np.zeros((84, 84, 3), np.uint8), Pose(3, 4, 0), said)
    state = advance(before, looked)
    assert (state.pose_true, state.pose_estimate, state.belief) == (Pose(5, 5, 0), Pose(3, 4, 0), said)
    assert advance(state, Tick(Clock(), Pose(5, 5, 0), Pose(3, 4, 0), np.zeros(180))).belief is said
    nothing = advance(state, replace(looked, pose_estimate=None, belief=None))
    assert (nothing.pose_estimate, nothing.belief) == (Pose(3, 4, 0), None)


def test_a_step_brings_what_the_filter_makes_of_it(game: FakeGame) -> None:
    filtered = Filtered(0.8, 0.1, 0.1, np.zeros((2, 3), np.float32), np.zeros((0, 3)))
    step = StepTaken(
        Clock(1, 1), "kitchen", Cell(4, 18), 3, Cell(4, 19), "reached", np.zeros(4), np.zeros(10), True,
        filtered=filtered,
    )  # fmt: skip
    assert after([*game.began(), step]).filtered is filtered
