"""Many runs: the same on one and on several processors, stopped cleanly, and wrong in one line."""

import multiprocessing
import signal
from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.repeats import Item, first_of_each_learner, make_runs
from twonav_cli.learner.learners import learner_settings
from twonav_cli.random_maze import random_maze
from twonav_cli.worker_pool import StoppedError, processors

MAZES = [random_maze(0, number, size=6, goals=3, goal_distance=3) for number in range(2)]
QUICK = learner_settings("multi", consecutive_successes=3)
ITEMS = [Item(QUICK, maze, repeat) for maze in range(2) for repeat in range(3)]


def fingerprint(run: LearningRun) -> tuple[object, ...]:
    return run.learner, run.outcome, run.optimal_at, run.goal_order.tolist(), run.trial_steps.tolist()


def test_one_and_two_processors_give_the_same_runs_in_the_same_order() -> None:
    seen: list[int] = []
    before = signal.getsignal(signal.SIGINT)
    alone = make_runs(ITEMS, MAZES, seed=7)
    shared = make_runs(ITEMS, MAZES, seed=7, processes=2, on_run=lambda run: seen.append(run.steps))
    assert [fingerprint(run) for run in alone] == [fingerprint(run) for run in shared]
    assert sorted(seen) == sorted(run.steps for run in alone)
    assert signal.getsignal(signal.SIGINT) is before, "Ctrl-C is ignored only while workers are started"


def test_every_item_has_its_own_seed_which_does_not_depend_on_the_settings() -> None:
    seeds = [item.seed(7) for item in ITEMS]
    assert len(set(seeds)) == len(ITEMS)
    assert [replace(item, config=learner_settings("single")).seed(7) for item in ITEMS] == seeds
    assert [item.seed(8) for item in ITEMS] != seeds


def test_a_repeat_differs_from_the_one_before() -> None:
    first, second = make_runs(ITEMS[:2], MAZES, seed=7)
    assert first.trial_steps.tolist() != second.trial_steps.tolist()


def test_one_run_of_each_learner_comes_first() -> None:
    single = learner_settings("single", consecutive_successes=3)
    items = [*ITEMS, Item(single, 0, 0), Item(single, 0, 1)]
    assert first_of_each_learner(items) == [0, 6]


@pytest.mark.parametrize("processes", [1, 2])
def test_a_request_to_stop_ends_the_runs_and_leaves_no_worker(processes: int) -> None:
    made: list[LearningRun] = []
    with pytest.raises(StoppedError):
        make_runs(ITEMS, MAZES, 0, processes, should_stop=lambda: len(made) >= 2, on_run=made.append)
    assert 2 <= len(made) < len(ITEMS)
    assert not multiprocessing.active_children()


def test_an_error_in_a_worker_comes_through_as_it_is() -> None:
    wrong = [*ITEMS[:2], Item(replace(QUICK, discount=1.5), 0, 0)]
    with pytest.raises(TwonavError, match=r"discount must be .* 1\.5 was given"):
        make_runs(wrong, MAZES, 0, processes=2)
    assert not multiprocessing.active_children()


def test_a_worker_that_is_killed_is_one_line() -> None:
    def kill_workers(run: LearningRun) -> None:
        for worker in multiprocessing.active_children():
            worker.kill()

    items = [Item(learner_settings("multi"), 0, repeat) for repeat in range(40)]
    with pytest.raises(TwonavError, match="a worker ended unexpectedly"):
        make_runs(items, MAZES, 0, processes=2, on_run=kill_workers)


def test_runs_that_give_up_are_kept_as_such() -> None:
    runs = make_runs(ITEMS, MAZES, 0, steps_at_most=100)
    assert {run.outcome for run in runs} == {"gave-up"}
    assert np.mean([run.steps for run in runs]) >= 100


def test_there_is_a_processor() -> None:
    assert processors() >= 1
