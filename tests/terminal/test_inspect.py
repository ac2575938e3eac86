"""What `twonav inspect` says of a learning run, and of a mapping."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rerun.chunk import LazyChunkStream, RrdReader

from twonav_cli.events import (
    Clock,
    Event,
    GoalAdded,
    GoalChosen,
    GoalLearned,
    KeyframeMapped,
    Note,
    RunEnded,
    RunStarted,
    TrialBatch,
)
from twonav_cli.geometry import Pose
from twonav_cli.maze import Cell, Maze
from twonav_cli.recording.looks import LookSummary
from twonav_cli.recording.recorder import Recorder
from twonav_cli.recording.rehearsal import driven_run
from twonav_cli.recording.trained_goals import TrainedGoal
from twonav_cli.terminal.console import out
from twonav_cli.terminal.inspect import because, looks_line, run_inspect

MAZE = Maze(np.zeros((2, 4), dtype=np.bool_), {"bed": Cell(0, 0), "sofa": Cell(1, 3)}, {"door": Cell(0, 3)})

STARTED = RunStarted(Clock(), "train", "maze", "rooms", 0, maze=MAZE)


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
        recorder(STARTED)
        recorder(GoalChosen(Clock(), "sofa", reason, np.array([1e4, 2e4]), np.array([False, False])))
        recorder(trials(1, 30, 1))
        recorder(GoalLearned(Clock(30, 15000), "sofa"))
        recorder(GoalChosen(Clock(30, 15000), "bed", reason, np.array([7.25, 8.0]), np.array([False, True])))
        recorder(trials(31, 12, 0))
    return path


def record(path: Path, sent: Iterable[Event]) -> Path:
    with Recorder(path, "maze") as recorder:
        for event in sent:
            recorder(event)
    return path


def without_the_choice_of(goal: str, path: Path) -> Path:
    """Write a recording again without a chunk, as if it had been killed before, and return the new file."""
    reader, cut = RrdReader(str(path)), path.with_name(f"cut-{path.name}")
    (store,) = reader.recordings()
    chunks = list(reader.stream())
    kept = [chunk for chunk in chunks if chunk.entity_path != "/choices" or goals_of(chunk) != [[goal]]]
    assert len(kept) == len(chunks) - 1
    stream = LazyChunkStream.from_iter(kept)
    stream.write_rrd(cut, application_id=store.application_id, recording_id=store.recording_id)
    return cut


def goals_of(chunk: Any) -> list[list[str]]:
    goals: list[list[str]] = chunk.to_record_batch()["goal"].to_pylist()
    return goals


@pytest.fixture(autouse=True)
def _wide(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setenv("COLUMNS", "200")
    out.cache_clear()
    yield
    out.cache_clear()


def told(path: Path, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the lines that are printed of a recording, without their padding."""
    assert run_inspect(path, as_json=False) == 0
    return [" ".join(line.split()) for line in capsys.readouterr().out.splitlines()]


def test_every_goal_is_listed_with_its_trials_its_reason_and_when_it_was_learned(
    path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = told(path, capsys)
    sofa = "1 sofa 1 to 30 30 15,000 after action 15,000 its TD error is the largest (20,000; that of bed is 10,000)"
    assert sofa in lines
    assert "2 bed 31 to 42 12 6,000 no its TD error is the largest (7.25, and no other goal is left)" in lines
    assert "trials that did not reach their goal, the last ones: 1, 31" in lines
    assert "(the last 10 of 42 recorded trials)" in lines


def test_programs_get_the_same_goals_as_json(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run_inspect(path, as_json=True)
    sofa, bed = json.loads(capsys.readouterr().out)["learning"]
    assert (sofa["goal"], sofa["first_trial"], sofa["last_trial"], sofa["actions"]) == ("sofa", 1, 30, 15000)
    assert (sofa["td_error"], sofa["rival"], sofa["rival_td_error"]) == (2e4, "bed", 1e4)
    assert (bed["rival"], bed["rival_td_error"], bed["learned_at_trial"]) == ("", None, None)


def test_a_recording_whose_last_choice_was_lost_says_so(path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = told(without_the_choice_of("bed", path), capsys)
    assert "2 bed 31 to 42 12 6,000 no why it was chosen was not written" in lines
    assert any(line.startswith("1 sofa 1 to 30 30 15,000 after action 15,000 its TD") for line in lines)


def test_equal_td_errors_are_called_equal(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chosen = GoalChosen(Clock(), "bed", "its TD error is the largest", np.full(2, 1e4), np.zeros(2, dtype=np.bool_))
    lines = told(record(tmp_path / "run.rrd", [STARTED, chosen, trials(1, 3, 0)]), capsys)
    assert any("its TD error is the largest (10,000, as that of sofa; the first of equals)" in line for line in lines)


@pytest.mark.parametrize(
    ("ended", "said"),
    [
        ([RunEnded(Clock(42, 900), "learned")], "no trial was made: every goal was learned before"),
        ([RunEnded(Clock(42, 900), "stopped")], "no trial was made"),
        ([], "no trial was written"),
    ],
)
def test_a_run_without_trials_says_why(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], ended: list[Event], said: str
) -> None:
    begun = RunStarted(Clock(42, 900), "train", "maze", "rooms", 0, maze=MAZE)
    assert said in told(record(tmp_path / "run.rrd", [begun, *ended]), capsys)


def test_a_goal_that_was_added_is_mentioned(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    begun = RunStarted(Clock(), "play", "maze", "rooms", 0, maze=MAZE)
    sent = [begun, GoalAdded(Clock(2, 25), "plant", Cell(1, 1)), GoalAdded(Clock(4, 60), "tv", Cell(0, 2))]
    lines = told(record(tmp_path / "run.rrd", sent), capsys)
    assert "goal plant was added in cell (1, 1) at trial 2" in lines
    assert "goal tv was added in cell (0, 2) at trial 4" in lines


def test_a_goal_without_numbers_has_only_its_reason() -> None:
    turn = TrainedGoal("bed", 5, 9, 5, 50, "the run goes on with it", None, "", None, None, None)
    assert because(turn) == "the run goes on with it"


def test_of_a_mapping_it_names_every_warning_and_both_of_the_largest_jumps(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def at(number: int, pose: Pose, unmatched: int = 0) -> KeyframeMapped:
        odometry, clock = Pose(float(number), 0.0, 0.0), Clock(step=number, time_s=float(number))
        return KeyframeMapped(
            clock, pose, np.array([pose]), np.ones(1), 1.0, False, unmatched, np.zeros((1, 2)), odometry
        )

    path = tmp_path / "mapped.rrd"
    warning = "odometry jumped 1000 m at 3.0 s [of the log]"
    with Recorder(path, "map") as recorder:
        recorder(RunStarted(Clock(), "map", "map", "hall", 0, {}))
        recorder(Note(Clock(), "WARN", warning))
        for event in (at(1, Pose(1.0, 0.0, 0.0)), at(2, Pose(2.0, 0.7, 0.0)), at(3, Pose(3.0, 0.7, 0.6))):
            recorder(event)
    lines = told(path, capsys)
    assert f"warnings: {warning}" in lines
    jumps = "#2 (the largest jump in metres), #3 (the largest in degrees)"
    assert f"look at it: timeline keyframe, {jumps}" in lines
    run_inspect(path, as_json=True)
    assert json.loads(capsys.readouterr().out)["warnings"] == [warning]
    with Recorder(path, "map") as recorder:
        for event in (RunStarted(Clock(), "map", "map", "hall", 0, {}), at(1, Pose(1.0, 0.0, 0.0), unmatched=1)):
            recorder(event)
    failed = "look at it: timeline keyframe, #1 (scan matching failed), #1"
    assert any(line.startswith(failed) for line in told(path, capsys))


def test_inspect_says_how_many_looks_were_wrong_and_how_sure_the_robot_was_then() -> None:
    assert looks_line(LookSummary(200, 3, 0.412, 0.98)) == (
        "looks: 200, 3 of them (1.5 %) more than 0.5 m off; confidence (median) 0.41 in these, 0.98 in the others"
    )
    assert looks_line(LookSummary(7, 0, None, 0.9)) == (
        "looks: 7, none of them more than 0.5 m off; confidence (median) 0.90"
    )


def test_the_looks_of_a_driven_run_are_printed_and_in_the_json(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "run.rrd"
    with Recorder(path, "3d") as recorder:
        for event in driven_run(1):
            recorder(event)
    run_inspect(path, as_json=True)
    looks = json.loads(capsys.readouterr().out)["looks"]
    assert (looks["wrong"], looks["confidence_wrong"]) == (0, None)
    assert looks["looks"] > 10
