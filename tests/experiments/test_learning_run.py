"""One learning run as arrays: they add up, and they are in the order of training."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.learning_run import run_learner, shortest_ways
from twonav_cli.learner.learners import LEARNERS, learner_settings
from twonav_cli.random_maze import random_maze

MAZE = random_maze(0, 0, size=6, goals=3, goal_distance=3)


@pytest.mark.parametrize("learner", LEARNERS)
def test_the_columns_of_a_run_add_up(learner: str) -> None:
    run = run_learner(MAZE, learner_settings(learner, consecutive_successes=5), 3)
    assert run.learner == learner
    assert run.learned
    assert sorted(run.goal_order) == [0, 1, 2]
    assert run.steps == run.trial_steps.sum() == run.steps_of_goal.sum()
    assert run.trials == len(run.trial_steps) == run.trials_of_goal.sum()
    assert list(np.bincount(run.trial_goal_rank)) == list(run.trials_of_goal)
    for rank in range(3):
        assert run.trial_steps[run.trial_goal_rank == rank].sum() == run.steps_of_goal[rank]
    assert (np.diff(run.trial_goal_rank) >= 0).all()
    assert run.floor_steps == 5 * shortest_ways(MAZE).sum()


def test_ranks_follow_the_order_of_training_and_not_that_of_the_maze() -> None:
    config = learner_settings("multi", consecutive_successes=5, goal_selection="random")
    runs = [run_learner(MAZE, config, seed) for seed in range(6)]
    moved = next(run for run in runs if list(run.goal_order) != [0, 1, 2])
    expected = shortest_ways(MAZE).mean(axis=1)[moved.goal_order]
    assert list(moved.shortest_of_goal) == list(expected)


def test_a_run_that_gives_up_says_so_and_keeps_what_it_did() -> None:
    run = run_learner(MAZE, learner_settings("multi"), 0, steps_at_most=50)
    assert (run.outcome, run.learned) == ("gave-up", False)
    assert len(run.goal_order) == 1
    assert run.trial_steps.sum() == run.steps


def test_a_run_that_is_stopped_at_once_is_empty() -> None:
    run = run_learner(MAZE, learner_settings("multi"), 0, should_stop=lambda: True)
    assert run.outcome == "stopped"
    assert len(run.trial_steps) == len(run.goal_order) == 0


def test_a_run_travels_between_programs_unchanged() -> None:
    run = run_learner(MAZE, learner_settings("multi", consecutive_successes=5), 3)
    again = pickle.loads(pickle.dumps(run))
    assert again.trial_steps.tolist() == run.trial_steps.tolist()
    assert (again.steps, again.optimal_at) == (run.steps, run.optimal_at)


def test_a_wrong_setting_is_an_error_with_its_name() -> None:
    with pytest.raises(TwonavError, match="discount must be"):
        run_learner(MAZE, replace(learner_settings("multi"), discount=1.5), 0)


def test_shortest_ways_are_known_for_another_maze_of_the_same_size_too() -> None:
    other = random_maze(1, 0, size=6, goals=3, goal_distance=3)
    expected = [[int(other.distances_to(g)[s]) for s in other.starts.values()] for g in other.goals.values()]
    assert shortest_ways(MAZE).shape == (3, 3)
    assert shortest_ways(other).tolist() == expected != shortest_ways(MAZE).tolist()
