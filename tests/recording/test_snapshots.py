"""The pictures of the tables: every goal's, at every snapshot, also of goals that were added on the way."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_rows import batches_of, column, pictures, record

from twonav_cli.events import Clock, Event, GoalAdded, GoalChosen, QSnapshot, RunStarted
from twonav_cli.grid import Cell
from twonav_cli.maze import Maze
from twonav_cli.recording.snapshots import AT_ONCE, FIRST_SNAPSHOTS
from twonav_cli.recording.td_pictures import FIRST_UNTRIED, WALL

BLOCKED = np.zeros((3, 4), dtype=np.bool_)
BLOCKED[1, 1] = True
MAZE = Maze(BLOCKED, {"bed": Cell(0, 0), "sofa": Cell(2, 3)}, {"door": Cell(0, 3)})


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


def started(stage: str = "maze") -> RunStarted:
    return RunStarted(Clock(), "train", stage, "rooms", 0, maze=MAZE)


def table(goals: int, value: float) -> np.ndarray:
    """Tables [G, R, C, A] of which every goal has its own value."""
    return np.arange(goals)[:, None, None, None] + np.full((goals, 3, 4, 4), value)


def test_the_td_picture_of_a_hand_made_table_has_the_right_cell_bright(tmp_path: Path) -> None:
    td = np.full((2, 3, 4, 4), 1.0)
    td[1, 0, 2] = 1000.0
    td[0, 2, 0, 3] = np.nan
    found = batches_of(record(tmp_path / "run.rrd", "maze", [started(), QSnapshot(Clock(5), table(2, 1.0), td)]))
    bed, sofa = (pictures(found[f"/td/goal_0{index}/map/error"], (3, 4))[5] for index in (0, 1))
    assert np.unravel_index(sofa.argmax(), sofa.shape) == (0, 2)
    assert bed[0, 2] == sofa[0, 0] < sofa[0, 2]
    assert bed[2, 0] == FIRST_UNTRIED
    assert bed[1, 1] == sofa[1, 1] == WALL


@pytest.mark.parametrize("kind", ["maze", "3d"])
def test_every_goal_has_both_pictures_of_every_snapshot(tmp_path: Path, kind: str) -> None:
    count = AT_ONCE + 3
    sent = [QSnapshot(Clock(i, 10 * i), table(2, i), table(2, 10.0**i)) for i in range(count)]
    found = batches_of(record(tmp_path / "run.rrd", kind, [started(kind), *sent]))
    for index in (0, 1):
        assert column(found[f"/q/goal_0{index}/map/value"], "trial") == list(range(count))
        assert len(pictures(found[f"/td/goal_0{index}/map/error"], (3, 4))) > 4


def test_a_picture_that_did_not_change_is_not_written_again(tmp_path: Path) -> None:
    sent = [QSnapshot(Clock(i), table(2, 1.0), table(2, 1.0)) for i in (1, 2, 3)]
    found = batches_of(record(tmp_path / "run.rrd", "maze", [started(), *sent]))
    assert column(found["/q/goal_00/map/value"], "trial") == [1]
    assert column(found["/td/goal_01/map/error"], "trial") == [1]


def test_late_snapshots_are_thinned_but_the_last_one_is_there(tmp_path: Path) -> None:
    trials = [10_000 + i for i in range(FIRST_SNAPSHOTS + 20)]
    sent = [QSnapshot(Clock(trial), table(2, trial % 50)) for trial in trials]
    found = batches_of(record(tmp_path / "run.rrd", "maze", [started(), *sent]))
    assert column(found["/q/goal_00/map/value"], "trial") == [*trials[:FIRST_SNAPSHOTS], trials[-1]]


def test_a_table_in_which_everything_was_tried_tells_the_td_error_of_every_goal(tmp_path: Path) -> None:
    whole, partly = table(2, 99.0), table(2, 1.0)
    whole[:, 1, 1] = 1e9  # a wall
    partly[0, 0, 0, 0] = np.nan
    sent = [QSnapshot(Clock(1), table(2, 1.0), partly), QSnapshot(Clock(2), table(2, 1.0), whole)]
    found = batches_of(record(tmp_path / "run.rrd", "3d", [started("3d"), *sent]))["/learning/td_error"]
    assert column(found, "trial") == [2]
    assert np.allclose(column(found, "Scalars:scalars"), np.log10([99.0, 100.0]))


@pytest.mark.parametrize("kind", ["maze", "3d"])
@pytest.mark.parametrize("announced", [True, False])
def test_tables_may_grow_by_a_goal(tmp_path: Path, kind: str, announced: bool) -> None:
    added = [GoalAdded(Clock(2), "plant", Cell(0, 1)), GoalChosen(Clock(2), "plant", "asked for", np.ones(3))]
    sent: list[Event] = [
        started(kind),
        QSnapshot(Clock(1), table(2, 1.0), table(2, 1.0)),
        *(added if announced else []),
        QSnapshot(Clock(2), table(3, 2.0), table(3, 2.0)),
    ]
    found = batches_of(record(tmp_path / "run.rrd", kind, sent))
    assert column(found["/q/goal_02/map/value"], "trial") == [2]
    assert column(found["/q/goal_01/map/value"], "trial") == [1, 2]
    assert list(pictures(found["/td/goal_02/map/error"], (3, 4))) == [2]
    places = column(found["/td/goal_02/map/goal"], "Points2D:positions", static=True)
    assert places == ([[[1.5, 2.5]]] if announced else [])
