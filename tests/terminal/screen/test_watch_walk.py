"""The walk that moves a learning run on for the screen: it learns what the run learns by itself."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from small_run import CONFIG, GOALS, small_maze, small_walk

from twonav_cli.events import Event, GoalChosen, GoalLearned, RunEnded, to_nobody
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.learner.agent import Agent
from twonav_cli.terminal.screen.watch_keys import END, GOAL, TRIAL
from twonav_cli.terminal.screen.watch_state import TRAIL_CELLS, Walked
from twonav_cli.terminal.screen.watch_walk import Walk

CARD = {"scene": "test", "scene_digest": "s", "map_digest": "m", "command": "test", "seed": 0, "metrics": {}}


def one_by_one(walk: Walk) -> None:
    walk.take(1)


def skipping(walk: Walk) -> None:
    walk.run(TRIAL, 1.0)
    walk.take(3)
    walk.run(GOAL, 1.0)
    walk.take(500)


def as_fast_as_it_goes(walk: Walk) -> None:
    walk.run("", 0.001)


def to_the_end(walk: Walk) -> None:
    walk.run(END, 60.0)


@pytest.mark.parametrize("go_on", [one_by_one, skipping, as_fast_as_it_goes, to_the_end])
def test_a_watched_run_is_the_run_that_nobody_watches(go_on: Callable[[Walk], None]) -> None:
    batches: tuple[list[Event], list[Event]] = ([], [])
    alone = Agent.for_maze(small_maze(), CONFIG, 3)
    outcome = learn_maze(alone, small_maze(), 3, batches[0].append, lambda: False)
    walk = small_walk(seed=3, sink=batches[1].append)
    while not walk.over:
        go_on(walk)
    assert walk.close() == outcome
    assert np.array_equal(walk.agent.q, alone.q)
    assert np.array_equal(walk.agent.td, alone.td)
    assert walk.agent.replay.counts == alone.replay.counts
    assert [(type(e), e.clock) for e in batches[0]] == [(type(e), e.clock) for e in batches[1]]


def test_a_watched_run_that_was_stopped_inside_a_trial_goes_on_to_the_same_end(tmp_path: Path) -> None:
    alone = Agent.for_maze(small_maze(), CONFIG)
    outcome = learn_maze(alone, small_maze(), 0, to_nobody, lambda: False)
    walk = small_walk()
    while not walk.learning.loop.in_trial or walk.agent.progress.step < 100:
        walk.take(1)
    assert walk.close().outcome == "stopped"
    walk.agent.save(tmp_path, CARD)
    again = Agent.load(tmp_path)
    assert learn_maze(again, small_maze(), 0, to_nobody, lambda: False) == outcome
    assert np.array_equal(again.q, alone.q)


def test_the_first_call_chooses_a_goal_and_takes_no_action() -> None:
    walk = small_walk()
    chosen, walked = walk.take(0)
    assert isinstance(chosen, GoalChosen)
    assert isinstance(walked, Walked)
    assert (walked.steps_in_trial, walked.trials, walk.agent.progress.step) == (0, (), 0)
    assert walked.td_errors is not None


def test_what_was_asked_for_is_taken_and_the_last_actions_are_seen_one_by_one() -> None:
    walk = small_walk()
    events = walk.take(200)
    assert walk.agent.progress.step == 200
    steps = [event.clock.step for event in events if isinstance(event, Walked)]
    assert steps[-TRAIL_CELLS:] == list(range(201 - TRAIL_CELLS, 201))


def test_a_skip_to_the_end_of_the_trial_ends_exactly_there() -> None:
    walk = small_walk()
    walk.take(3)
    events = walk.run(TRIAL, 10.0)
    assert walk.has_ended(TRIAL, events)
    assert sum(len(event.trials) for event in events if isinstance(event, Walked)) == 1
    assert not walk.learning.loop.in_trial
    assert walk.agent.progress.trial == 1


def test_a_skip_to_the_next_goal_ends_where_that_is_chosen() -> None:
    walk = small_walk()
    events = walk.run(GOAL, 10.0)
    kinds = [type(event) for event in events]
    assert kinds.count(GoalLearned) == 1
    assert kinds[kinds.index(GoalLearned) :] == [GoalLearned, GoalChosen, Walked]
    assert walk.agent.progress.learned.sum() == 1
    assert walk.agent.progress.step == events[-1].clock.step


def test_a_skip_whose_time_is_used_up_goes_on_with_the_next_call() -> None:
    walk, calls = small_walk(), 0
    while not walk.has_ended(END, walk.run(END, 0.0)):
        calls += 1
    assert calls > 1
    assert walk.over


def test_the_end_is_told_once_and_nothing_happens_after_it() -> None:
    walk = small_walk()
    events = walk.run(END, 60.0)
    assert [event.outcome for event in events if isinstance(event, RunEnded)] == ["learned"]
    assert sorted(event.goal for event in events if isinstance(event, GoalLearned)) == sorted(GOALS)
    assert walk.take(5) == walk.take(0) == walk.run("", 0.01) == []


def test_a_run_that_is_stopped_between_two_trials_takes_no_further_action() -> None:
    walk = small_walk()
    walk.take(0)
    assert walk.close().steps == 0
    walk = small_walk()
    walk.run(TRIAL, 10.0)
    steps = walk.agent.progress.step
    assert walk.close().steps == steps > 0


@pytest.mark.parametrize("go_on", [one_by_one, skipping, as_fast_as_it_goes, to_the_end])
@pytest.mark.parametrize("learner", ["multi", "single"])
def test_a_run_that_is_saved_at_every_trial_learns_the_same_and_can_be_gone_on_with(
    tmp_path: Path, learner: str, go_on: Callable[[Walk], None]
) -> None:
    config, maze = replace(CONFIG, learner=learner), small_maze()
    alone = Agent.for_maze(maze, config)
    outcome = learn_maze(alone, maze, 0, to_nobody, lambda: False)
    agent, saved = Agent.for_maze(maze, config), []

    def save() -> None:
        agent.save(tmp_path / str(len(saved)), CARD)
        saved.append(agent.progress.trial)

    walk = Walk(agent, maze, 0, to_nobody, lambda: len(saved) < 30 or walk.over, save)
    while not walk.over:
        go_on(walk)
    assert walk.close() == outcome
    assert np.array_equal(agent.q, alone.q)
    assert agent.replay.counts == alone.replay.counts
    assert saved[-1] == agent.progress.trial
    for number in range(0, len(saved), 10):
        again = Agent.load(tmp_path / str(number))
        assert learn_maze(again, maze, 0, to_nobody, lambda: False) == outcome
        assert np.array_equal(again.q, alone.q)


def test_a_run_is_only_saved_between_two_trials() -> None:
    saved: list[int] = []
    agent, maze = Agent.for_maze(small_maze(), CONFIG), small_maze()
    walk = Walk(agent, maze, 0, to_nobody, lambda: True, lambda: saved.append(walk.learning.loop.in_trial))
    walk.take(300)
    assert len(saved) > 2
    assert not any(saved)
