"""A real learning run is recorded, stopped, gone on with, and told back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_rows import batches_of, column

from twonav_cli.config import LearningConfig
from twonav_cli.events import Clock, Event, RunStarted, TrialBatch
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Maze
from twonav_cli.recording.reader import Summary, summarize
from twonav_cli.recording.recorder import Recorder

MAZE = Maze(
    np.zeros((4, 5), dtype=np.bool_),
    {"bed": Cell(0, 0), "sofa": Cell(3, 4), "tv": Cell(0, 4)},
    {"door": Cell(2, 0), "window": Cell(3, 2)},
)
CONFIG = LearningConfig(consecutive_successes=5)


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


def learn(agent: Agent, path: Path, trials_at_most: int = 10**6) -> list[TrialBatch]:
    """Record a learning run until so many trials, and return what was sent of its trials."""
    sent = list[TrialBatch]()
    with Recorder(path, "maze", every_trial=False) as recorder:

        def sink(event: Event) -> None:
            recorder(event)
            if isinstance(event, TrialBatch):
                sent.append(event)

        recorder(RunStarted(Clock(agent.progress.trial, agent.progress.step), "train", "maze", "rooms", 0, maze=MAZE))
        learn_maze(agent, MAZE, 0, sink, lambda: agent.progress.trial >= trials_at_most)
    return sent


@pytest.fixture(scope="module")
def learned(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[TrialBatch], Agent]:
    agent, path = Agent.for_maze(MAZE, CONFIG), tmp_path_factory.mktemp("learned") / "run.rrd"
    return path, learn(agent, path), agent


def test_the_story_of_a_run_adds_up_to_the_run(learned: tuple[Path, list[TrialBatch], Agent]) -> None:
    path, _, agent = learned
    turns, progress = summarize(path).learning, agent.progress
    assert sorted(turn.goal for turn in turns) == sorted(MAZE.goals)
    for turn in turns:
        index = agent.goal_names.index(turn.goal)
        assert (turn.trials, turn.actions) == (progress.trials_of_goal[index], progress.steps_of_goal[index])
        assert turn.learned_at_trial == turn.last_trial
    assert [turn.first_trial for turn in turns] == [1, *(turn.last_trial + 1 for turn in turns[:-1])]
    assert (turns[0].td_error, turns[0].rival_td_error) == (1e4, 1e4)
    assert turns[1].td_error is not None
    assert turns[1].rival_td_error is not None
    assert turns[1].td_error >= turns[1].rival_td_error


def test_every_trials_curve_and_the_means_of_its_round_are_those_of_the_run(
    learned: tuple[Path, list[TrialBatch], Agent],
) -> None:
    path, sent, _ = learned
    found, steps = batches_of(path), np.concatenate([batch.steps for batch in sent])
    taken = np.array(column(found["/learning/steps"], "Scalars:scalars"))[:, 0]
    rounds = np.array(column(found["/learning/round"], "Scalars:scalars"))
    assert taken.tolist() == steps.tolist()
    assert np.allclose(rounds[:, 0], steps.reshape(-1, 2).mean(axis=1))
    errors = np.array(column(found["/learning/td_error"], "Scalars:scalars"))
    assert np.allclose(10 ** errors[:, 1].max(), 1e4)
    assert errors[-1, 1] < errors[0, 1]


def test_values_and_td_errors_of_every_goal_are_recorded_from_the_first_trials_on(
    learned: tuple[Path, list[TrialBatch], Agent],
) -> None:
    found = batches_of(learned[0])
    for index in range(len(MAZE.goals)):
        for entity in (f"/q/goal_0{index}/map/policy", f"/td/goal_0{index}/map/error"):
            assert column(found[entity], "trial")[:3] == [0, 1, 2]


def test_numbers_of_trials_go_on_after_a_resume(tmp_path: Path) -> None:
    agent = Agent.for_maze(MAZE, CONFIG)
    before = learn(agent, tmp_path / "first.rrd", trials_at_most=12)
    stopped_at = agent.progress.trial
    after = learn(agent, tmp_path / "second.rrd")
    first, second = (summarize(tmp_path / f"{name}.rrd") for name in ("first", "second"))
    assert numbers_of(first) == list(range(1, stopped_at + 1))
    assert numbers_of(second) == list(range(stopped_at + 1, agent.progress.trial + 1))
    assert len(numbers_of(second)) == sum(len(batch.steps) for batch in after) > 0
    assert len(numbers_of(first)) == sum(len(batch.steps) for batch in before)
    assert second.learning[0].reason == "the run goes on with it"
    assert second.learning[0].first_trial == stopped_at + 1
    chunks = batches_of(tmp_path / "second.rrd")
    assert max(column(chunks["/learning/td_error"], "trial")) == agent.progress.trial


def numbers_of(summary: Summary) -> list[int]:
    return [row.number for row in summary.trials]
