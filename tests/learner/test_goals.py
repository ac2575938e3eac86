"""Rewards, the criterion, and the choice of the next goal."""

import numpy as np
import pytest

from twonav_cli.config import Rewards
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.learner.goals import NO_GOAL, Progress, is_learned, next_goal, record_trial, rewards_of_goals

REWARDS = Rewards(goal=100.0, blocked=-2.0, step=-0.1)
GOALS = [Cell(0, 1), Cell(3, 3)]


def test_entering_a_goal_rewards_that_goal_only() -> None:
    assert rewards_of_goals(REWARDS, Cell(0, 0), Cell(0, 1), False, GOALS).tolist() == [100.0, -0.1]


def test_a_bump_costs_every_goal() -> None:
    assert rewards_of_goals(REWARDS, Cell(0, 0), Cell(0, 0), True, GOALS).tolist() == [-2.0, -2.0]


def test_a_bump_inside_a_goals_cell_is_no_arrival() -> None:
    assert rewards_of_goals(REWARDS, Cell(0, 1), Cell(0, 1), True, GOALS).tolist() == [-2.0, -2.0]


def recorded(trials: list[tuple[int, int, bool]], starts: int, length: int) -> Progress:
    progress = Progress.fresh(1, starts, length)
    for start, steps, reached in trials:
        record_trial(progress.consecutive, progress.window, start, steps, reached)
    return progress


def test_a_goal_is_learned_after_enough_successes_from_every_start() -> None:
    progress = recorded([(0, 5, True)] * 3 + [(1, 9, True)] * 2, starts=2, length=3)
    assert not is_learned(progress.consecutive, progress.window, 10.0)
    record_trial(progress.consecutive, progress.window, 1, 9, True)
    assert is_learned(progress.consecutive, progress.window, 10.0)


def test_one_failure_starts_the_count_of_its_start_again() -> None:
    progress = recorded([(0, 5, True), (0, 5, True), (0, 500, False), (0, 5, True)], starts=1, length=3)
    assert progress.consecutive.tolist() == [1]


def test_trials_that_differ_too_much_from_each_other_are_not_learned() -> None:
    # differences 20, 10: mean 15
    progress = recorded([(0, 10, True), (0, 30, True), (0, 20, True)], starts=1, length=3)
    assert not is_learned(progress.consecutive, progress.window, 15.0)
    assert is_learned(progress.consecutive, progress.window, 15.1)


def test_only_the_latest_window_counts_and_in_its_order() -> None:
    # 99 falls out; 10, 12, 15 remain: mean difference 2.5 (with the ring read from its wrong end it would be 3.5)
    progress = recorded([(0, n, True) for n in (99, 10, 12, 15)], starts=1, length=3)
    assert not is_learned(progress.consecutive, progress.window, 2.5)
    assert is_learned(progress.consecutive, progress.window, 2.51)


def test_the_goal_of_largest_td_error_among_the_unlearned_is_next() -> None:
    errors, learned, rng = (
        np.array([9.0, 1.0, 5.0, 5.0]),
        np.array([True, False, False, False]),
        np.random.default_rng(0),
    )
    assert next_goal("td-error", errors, learned, rng) == 2
    assert next_goal("sequential", errors, learned, rng) == 1
    assert {next_goal("random", errors, learned, rng) for _ in range(60)} == {1, 2, 3}


def test_a_wrong_rule_and_nothing_left_are_refused() -> None:
    rng = np.random.default_rng(0)
    with pytest.raises(TwonavError, match="td-error, random, sequential"):
        next_goal("td", np.zeros(1), np.array([False]), rng)
    with pytest.raises(TwonavError, match="every goal is learned"):
        next_goal("random", np.zeros(1), np.array([True]), rng)


def test_a_finished_goal_is_marked_and_a_new_one_starts_at_zero() -> None:
    progress = recorded([(0, 5, True)], starts=2, length=3)
    progress.goal = 0
    progress.finish_goal()
    assert progress.learned.tolist() == [True]
    assert progress.goal == NO_GOAL
    progress.begin_goal(0)
    assert progress.consecutive.tolist() == [0, 0]
    assert not progress.window.any()
