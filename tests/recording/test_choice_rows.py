"""Which goal was chosen, when, and why: lanes, log, marks and rows of a made-up learning run."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_rows import batches_of, column, record
from rerun.chunk import RrdReader

from twonav_cli.events import Clock, Event, GoalAdded, GoalChosen, GoalLearned, RunStarted, StepTaken, TrialBatch
from twonav_cli.grid import Cell
from twonav_cli.maze import Maze

MAZE = Maze(np.zeros((3, 4), dtype=np.bool_), {"bed": Cell(0, 0), "sofa": Cell(2, 3)}, {"door": Cell(0, 3)})
STARTED = RunStarted(Clock(), "train", "maze", "rooms", 0, maze=MAZE)
RULE = "its TD error is the largest"


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


def trials(first: int, count: int, goal: int, goals: int = 2) -> TrialBatch:
    whole = np.ones(count, dtype=np.int64)
    last_step = 10 * (first + np.arange(count))
    return TrialBatch(
        Clock(first + count - 1, int(last_step[-1])), goal * whole, 0 * whole, 10 * whole, whole.astype(np.bool_),
        3 * whole, np.full((count, goals), 100.0), last_step,
    )  # fmt: skip


def chosen(trial: int, goal: str, errors: list[float], learned: list[bool]) -> GoalChosen:
    return GoalChosen(Clock(trial, 10 * trial), goal, RULE, np.array(errors), np.array(learned))


RUN: list[Event] = [
    STARTED,
    chosen(0, "sofa", [50.0, 200.0], [False, False]),
    trials(1, 20, 1),
    GoalLearned(Clock(20, 200), "sofa"),
    chosen(20, "bed", [10.0, 30.0], [False, True]),
    trials(21, 5, 0),
]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return record(tmp_path_factory.mktemp("story") / "run.rrd", "maze", RUN)


def test_every_goal_has_a_lane_of_waiting_current_and_learned(path: Path) -> None:
    found = batches_of(path)
    for lane, states in (
        ("/goals/01/bed", [(0, "waiting"), (20, "current")]),
        ("/goals/02/sofa", [(0, "waiting"), (0, "current"), (20, "learned")]),
    ):
        rows = zip(column(found[lane], "trial"), np.ravel(column(found[lane], "StateChange:state")), strict=True)
        assert sorted(rows) == sorted(states)


def test_the_log_says_why_with_the_two_largest_numbers_and_what_a_goal_took(path: Path) -> None:
    lines = np.ravel(column(batches_of(path)["/log"], "TextLog:text")).tolist()
    assert lines == [
        "after 0 trials, goal sofa: its TD error is the largest (200; that of bed is 50)",
        "after 20 trials, goal sofa is learned: 20 trials and 200 actions of its own",
        "after 20 trials, goal bed: its TD error is the largest (10, and no other goal is left)",
    ]


def test_a_goal_that_is_learned_already_is_never_the_next_largest(path: Path) -> None:
    rows = batches_of(path)["/choices"]
    assert np.ravel(column(rows, "goal")).tolist() == ["sofa", "bed"]
    assert np.ravel(column(rows, "rival")).tolist() == ["bed", ""]
    assert np.ravel(column(rows, "td_error")).tolist() == [200.0, 10.0]


def test_the_mark_of_a_choice_stands_on_the_chosen_goals_curve(path: Path) -> None:
    marks = batches_of(path)["/learning/chosen"]
    assert np.allclose(np.ravel(column(marks, "Scalars:scalars")), [np.log10(200.0), 1.0])
    assert column(marks, "trial") == [0, 20]


def test_reasons_and_sums_of_trials_are_two_documents_that_do_not_take_turns(path: Path) -> None:
    found = batches_of(path)
    reasons = np.ravel(column(found["/learning/choice"], "TextDocument:text"))
    sums = np.ravel(column(found["/learning/totals"], "TextDocument:text"))
    assert [text.split(":")[0] for text in reasons] == ["**sofa**", "**bed**"]
    assert "| **sofa** | 200 | **chosen** | 1 |" in reasons[0]
    assert all(text.startswith("| goal | reached | not |") for text in sums)
    assert "| sofa | 20 | 0 | 200 | 10.0 | 3.0 |" in sums[-1]


def test_equal_td_errors_are_called_equal(tmp_path: Path) -> None:
    sent = [STARTED, chosen(0, "bed", [1e4, 1e4], [False, False])]
    lines = column(batches_of(record(tmp_path / "run.rrd", "maze", sent))["/log"], "TextLog:text")
    assert lines == [[f"after 0 trials, goal bed: {RULE} (10,000, as that of sofa; the first of equals)"]]


def test_a_goal_that_was_chosen_before_the_recording_began_goes_on(tmp_path: Path) -> None:
    begun = RunStarted(Clock(70, 700), "train", "maze", "rooms", 0, maze=MAZE)
    found = batches_of(record(tmp_path / "run.rrd", "maze", [begun, trials(71, 5, 1)]))
    assert np.ravel(column(found["/choices"], "reason")).tolist() == ["the run goes on with it"]
    assert column(found["/goals/02/sofa"], "trial") == [70, 70]
    assert np.ravel(column(found["/state/goal"], "StateChange:state")).tolist() == ["sofa"]


def test_wherever_a_recording_is_cut_no_trial_comes_before_the_choice_of_its_goal(tmp_path: Path) -> None:
    goals = {str(i): Cell(0, i) for i in range(4)}
    maze = Maze(np.zeros((2, 4), dtype=np.bool_), goals, {"door": Cell(1, 3)})
    sent: list[Event] = [RunStarted(Clock(), "train", "maze", "rooms", 0, maze=maze)]
    for i in range(4):
        sent += [chosen(20 * i, str(i), [9.0] * 4, [other < i for other in range(4)]), trials(20 * i + 1, 20, i, 4)]
        sent += [GoalLearned(Clock(20 * i + 20, 200 * i + 200), str(i))]
    told: dict[str, list[str]] = {"/choices": [], "/learned": []}
    ended, summed = list[str](), 0
    for chunk in RrdReader(str(record(tmp_path / "run.rrd", "maze", sent))).stream():
        if chunk.entity_path in told:
            told[chunk.entity_path] += np.ravel(column([chunk], "goal")).tolist()
        if chunk.entity_path == "/trials":
            ended += np.ravel(column([chunk], "goal")).tolist()
        if chunk.entity_path == "/totals":
            summed = int(np.sum(column([chunk], "reached")[-1]))
            assert summed == len(ended)
        assert set(ended) <= set(told["/choices"])
        assert set(ended) <= set(told["/learned"])
    assert summed == len(ended) == 80


def test_a_goal_that_a_person_asks_for_needs_no_numbers(tmp_path: Path) -> None:
    sent = [STARTED, *(GoalChosen(Clock(i), goal, "asked for", np.ones(2)) for i, goal in enumerate(["bed", "sofa"]))]
    found = batches_of(record(tmp_path / "run.rrd", "maze", sent))
    assert np.ravel(column(found["/log"], "TextLog:text")).tolist() == ["goal bed: asked for", "goal sofa: asked for"]
    assert np.ravel(column(found["/goals/01/bed"], "StateChange:state")).tolist() == ["waiting", "current", "waiting"]


def test_an_added_goal_gets_its_own_lane_and_curve_and_the_others_keep_theirs(tmp_path: Path) -> None:
    here = Clock(25, 250)
    step = StepTaken(here, "bed", Cell(0, 1), 0, Cell(0, 0), "reached", np.zeros(4), np.ones(3), True)
    before = StepTaken(here, "bed", Cell(0, 1), 0, Cell(0, 0), "reached", np.zeros(4), np.ones(2), True)
    sent = [
        *RUN,
        before,
        GoalAdded(here, "plant", Cell(1, 1)),
        GoalChosen(here, "plant", "asked for", np.array([1.0, 10.0, 1000.0])),
        step,
        trials(26, 3, 2, goals=3),
    ]
    found = batches_of(record(tmp_path / "run.rrd", "maze", sent))
    assert {len(row) for row in column(found["/learning/td_error"], "Scalars:scalars")} == {2}
    assert {len(row) for row in column(found["/metrics/td_error"], "Scalars:scalars")} == {2}
    added = np.ravel(column(found["/learning/td_error/goal_02"], "Scalars:scalars"))
    assert np.allclose(added[~np.isnan(added)], [2.0, 2.0, 2.0, 3.0])
    assert np.ravel(column(found["/goals/03/plant"], "StateChange:state")).tolist() == ["waiting", "current"]
    assert np.ravel(column(found["/trials"], "goal")).tolist()[-1] == "plant"
    assert "goal plant was added in cell (1, 1)" in np.ravel(column(found["/log"], "TextLog:text"))
    assert len(column(found["/drive/map/goals"], "Points2D:positions", static=True)[-1]) == 3
