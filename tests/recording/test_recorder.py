"""A made-up run is recorded and read back value by value."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_rows import batches_of, column

from twonav_cli import events
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock
from twonav_cli.recording import rehearsal
from twonav_cli.recording.reader import summarize
from twonav_cli.recording.recorder import Recorder


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[events.Event]]:
    path = tmp_path_factory.mktemp("driven") / "run.rrd"
    sent = list(rehearsal.driven_run(3))
    with Recorder(path, "3d") as recorder:
        for event in sent:
            recorder(event)
    return path, sent


def test_every_pose_of_every_tick_is_in_the_file_in_metres_with_y_up(driven: tuple[Path, list[events.Event]]) -> None:
    path, sent = driven
    ticks = [event for event in sent if isinstance(event, events.Tick)]
    origins = column(batches_of(path)["/drive/map/robot/true"], "Arrows2D:origins")
    assert np.allclose(np.array(origins)[:, 0], [tick.pose_true[:2] for tick in ticks], atol=1e-5)


def test_the_pose_error_is_the_distance_between_true_and_believed(driven: tuple[Path, list[events.Event]]) -> None:
    path, sent = driven
    ticks = [event for event in sent if isinstance(event, events.Tick)]
    recorded = column(batches_of(path)["/metrics/position_error/believed"], "Scalars:scalars")
    expected = [np.hypot(t.pose_true.x_m - t.pose_believed.x_m, t.pose_true.y_m - t.pose_believed.y_m) for t in ticks]
    assert np.allclose(np.ravel(recorded), expected)


def test_every_moving_row_is_on_every_timeline(driven: tuple[Path, list[events.Event]]) -> None:
    for entity, chunks in batches_of(driven[0]).items():
        for chunk in chunks:
            if not chunk.is_static and not entity.startswith("/__properties"):
                assert set(chunk.timeline_names) == {"step", "trial", "sim_time"}, entity


def test_the_whole_trial_has_the_colour_of_its_outcome(driven: tuple[Path, list[events.Event]]) -> None:
    path, sent = driven
    starts = [event.clock.step for event in sent if isinstance(event, events.TrialStarted)]
    chunks = batches_of(path)["/state/outcome"]
    assert column(chunks, "step") == starts
    assert column(chunks, "StateChange:state") == [["reached"], ["reached"], ["false-arrival"]]


def test_the_log_names_cause_and_evidence_of_a_failure(driven: tuple[Path, list[events.Event]]) -> None:
    chunks = batches_of(driven[0])["/log"]
    lines = dict(zip(np.ravel(column(chunks, "TextLog:text")), np.ravel(column(chunks, "TextLog:level")), strict=True))
    failure = next(line for line in lines if line.startswith("trial 3"))
    assert lines[failure] == "ERROR"
    assert "Cause: mislocalized. Evidence: the estimate was 0.90 m off" in failure


def test_failures_accumulate_on_the_map(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    with Recorder(path, "3d") as recorder:
        for event in rehearsal.driven_run(7):
            recorder(event)
    labels = column(batches_of(path)["/drive/map/failures/latest"], "Points2D:labels")
    assert labels == [["trial 3: mislocalized"], ["trial 3: mislocalized", "trial 7: loop"]]


def test_the_camera_picture_is_a_jpeg_of_the_size_it_had(driven: tuple[Path, list[events.Event]]) -> None:
    import cv2

    blob = column(batches_of(driven[0])["/camera/rgb"], "EncodedImage:blob")[0]
    image = cv2.imdecode(np.frombuffer(np.array(blob[0], dtype=np.uint8).tobytes(), np.uint8), cv2.IMREAD_COLOR)
    assert image.shape == (84, 84, 3)


def test_the_q_picture_is_the_best_value_and_walls_are_not_a_number(driven: tuple[Path, list[events.Event]]) -> None:
    path, sent = driven
    table = next(event.q for event in sent if isinstance(event, events.QSnapshot))
    maze, _, _ = rehearsal.rooms()
    buffer = column(batches_of(path)["/q/goal_02/map/value"], "DepthImage:buffer")[0][0]
    value = np.array(buffer, dtype=np.uint8).view(np.float16).reshape(maze.rows, maze.cols)
    assert np.isnan(value[maze.blocked]).all()
    assert np.allclose(value[~maze.blocked], table[2].max(axis=-1)[~maze.blocked], rtol=2e-3)


def test_a_succeeding_trial_is_thinned_and_a_failing_one_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    rng = np.random.default_rng(0)
    clock, ends = Clock(), []
    with Recorder(path, "3d", every_trial=False) as recorder:
        recorder(rehearsal.started())
        for trial in range(1, 9):
            for event in rehearsal.driven_trial(trial, clock, rng, "time-out" if trial == 8 else "reached"):
                recorder(event)
                clock = event.clock
            ends.append(trial)
    trials = column(batches_of(path)["/drive/map/dwa/candidates"], "trial")
    assert set(trials) == {1, 2, 3, 4, 5, 8}
    assert set(column(batches_of(path)["/drive/map/robot/true"], "trial")) == set(ends)


def test_beyond_the_budget_only_rows_per_trial_are_written(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    with Recorder(path, "3d", budget_mb=0.8) as recorder:
        for event in rehearsal.driven_run(4):
            recorder(event)
    found = batches_of(path)
    assert set(column(found["/camera/rgb"], "trial")) == {1}
    assert [row.number for row in summarize(path).trials] == [1, 2, 3, 4]


def test_a_long_maze_run_is_thinned_but_counted_in_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twonav_cli.recording.learning_rows.ROWS_PER_DOUBLING", 1000)
    path = tmp_path / "maze.rrd"
    sent = list(rehearsal.compiled_batches(8000, np.random.default_rng(0)))
    with Recorder(path, "maze") as recorder:
        for event in [rehearsal.started(stage="maze"), *sent]:
            recorder(event)
    summary = summarize(path)
    assert 1000 < len(summary.trials) < 4500
    assert summary.counts["reached"] == sum(int(batch.reached.sum()) for batch in sent)
    assert sum(summary.counts.values()) == 8000


def test_a_maze_without_a_map_is_recorded_too(tmp_path: Path) -> None:
    path = tmp_path / "maze.rrd"
    maze, _, _ = rehearsal.rooms()
    clock, start = Clock(1, 0), maze.starts["door"]
    with Recorder(path, "maze") as recorder:
        recorder(events.RunStarted(Clock(), "play", "maze", "rooms", 0, maze=maze))
        recorder(events.TrialStarted(clock, "bed", start))
        step = events.StepTaken(
            clock, "bed", start, 0, maze.moved(start, 0), "reached", np.zeros(4), np.zeros(10), True
        )
        recorder(step)
        recorder(events.TrialEnded(clock, "bed", start, "time-out", 1, 9, "time-out", "1 action was allowed"))
    position = column(batches_of(path)["/drive/map/robot/cell"], "Points2D:positions")[0][0]
    assert position == [10.5, 4.5]  # row 19 of 24, column 10: the centre, y up
    assert summarize(path).failures[0].evidence == "1 action was allowed"


@pytest.mark.parametrize("name", ["run.txt", "folder.rrd"])
def test_a_path_that_cannot_be_written_is_refused_in_one_line(tmp_path: Path, name: str) -> None:
    (tmp_path / "folder.rrd").mkdir()
    with pytest.raises(TwonavError) as error:
        Recorder(tmp_path / name, "3d")
    assert len(str(error.value).splitlines()) == 1


def test_an_unknown_kind_lists_the_right_ones(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="maze, 2d, 3d, localizer"):
        Recorder(tmp_path / "run.rrd", "3D-stage")
