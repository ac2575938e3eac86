"""What `twonav inspect` says of a learning run."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.events import Clock, GoalChosen, GoalLearned, RunStarted, TrialBatch
from twonav_cli.maze import Cell, Maze
from twonav_cli.recording.recorder import Recorder
from twonav_cli.recording.trained_goals import TrainedGoal
from twonav_cli.terminal.console import out
from twonav_cli.terminal.inspect import run_inspect, why_chosen

MAZE = Maze(np.zeros((2, 4), dtype=np.bool_), {"bed": Cell(0, 0), "sofa": Cell(1, 3)}, {"door": Cell(0, 3)})


def trials(first: int, count: int, goal: int) -> TrialBatch:
    whole = np.ones(count, dtype=np.int64)
    last_step = 500 * (first - 1 + np.arange(1, count + 1))
    reached = np.arange(count) > 0
    return TrialBatch(
        Clock(first + count - 1, int(last_step[-1])), goal * whole, 0 * whole, 500 * whole, reached, 3 * whole,
        np.ones((count, 2)), last_step,
    )  # fmt: skip


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path, reason = tmp_path / "run.rrd", "its TD error is the largest"
    with Recorder(path, "maze") as recorder:
        recorder(RunStarted(Clock(), "train", "maze", "rooms", 0, maze=MAZE))
        recorder(GoalChosen(Clock(), "sofa", reason, np.array([1e4, 2e4]), np.array([False, False])))
        recorder(trials(1, 30, 1))
        recorder(GoalLearned(Clock(30, 15000), "sofa"))
        recorder(GoalChosen(Clock(30, 15000), "bed", reason, np.array([7.25, 8.0]), np.array([False, True])))
        recorder(trials(31, 12, 0))
    return path


def test_every_goal_is_listed_with_its_trials_its_reason_and_when_it_was_learned(
    path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "200")
    out.cache_clear()
    assert run_inspect(path, as_json=False) == 0
    out.cache_clear()
    lines = [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]
    sofa = "1 sofa 1 to 30 30 15,000 after action 15,000 its TD error is the largest (20,000; bed 10,000)"
    assert sofa in lines
    assert "2 bed 31 to 42 12 6,000 no its TD error is the largest (7.25)" in lines
    assert "trials that did not reach their goal, the last ones: 1, 31" in lines
    assert "(the last 10 of 42 recorded trials)" in lines


def test_programs_get_the_same_goals_as_json(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run_inspect(path, as_json=True)
    sofa, bed = json.loads(capsys.readouterr().out)["learning"]
    assert (sofa["goal"], sofa["first_trial"], sofa["last_trial"], sofa["actions"]) == ("sofa", 1, 30, 15000)
    assert (sofa["td_error"], sofa["rival"], sofa["rival_td_error"]) == (2e4, "bed", 1e4)
    assert (bed["rival"], bed["rival_td_error"], bed["learned_at_trial"]) == ("", None, None)


def test_a_goal_without_numbers_has_only_its_reason() -> None:
    turn = TrainedGoal("bed", 5, 9, 5, 50, "the run goes on with it", None, "", None, None, None)
    assert why_chosen(turn) == "the run goes on with it"
