"""What the robot believes, recorded and read back."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from recorded_rows import batches_of, column, record

from twonav_cli import events
from twonav_cli.events import Clock
from twonav_cli.geometry import Pose
from twonav_cli.recording import rehearsal
from twonav_cli.recording.belief_columns import HEAT_LEVELS, heat_classes, heat_levels
from twonav_cli.recording.reader import summarize

HEAT = "/drive/map/belief/heat"


@pytest.fixture(autouse=True)
def _strict(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN_STRICT", "1")


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[events.StepTaken]]:
    sent = list(rehearsal.driven_run(3))
    path = record(tmp_path_factory.mktemp("driven") / "run.rrd", "3d", sent)
    return path, [event for event in sent if isinstance(event, events.StepTaken)]


def test_the_heat_of_every_look_is_in_the_file_and_lies_on_the_map(driven: tuple[Path, list[events.StepTaken]]) -> None:
    path, steps = driven
    chunks = batches_of(path)[HEAT]
    levels = [np.array(buffer[0], dtype=np.uint8) for buffer in column(chunks, "SegmentationImage:buffer")]
    assert len(levels) == len(steps)
    for level, step in zip(levels[::20], steps[::20], strict=True):
        assert step.belief is not None
        assert np.array_equal(level.reshape(step.belief.grid.shape), heat_levels(step.belief))
        frame = rehearsal.BELIEF_FRAME
        assert step.pose_true is not None
        cell = frame.cell_at(step.pose_true.x_m, step.pose_true.y_m)
        assert level.reshape(frame.shape)[cell] == level.max()
    (corner,) = column(chunks, "Transform3D:translation", static=True)
    assert corner[0][:2] == pytest.approx([rehearsal.BELIEF_FRAME.x_min_m, rehearsal.BELIEF_FRAME.y_max_m])


def test_a_level_is_a_fifth_of_a_power_of_ten_and_below_a_thousandth_nothing() -> None:
    said = rehearsal.belief_about(Pose(3.0, 3.0, 0.0), 1.0)
    said.grid[:] = 0.0
    said.grid[0, :5] = (0.0009, 0.0011, 0.09, 0.5, 1.0)
    assert heat_levels(said)[0, :6].tolist() == [0, 1, 10, 14, HEAT_LEVELS, 0]
    classes = heat_classes()
    assert [number for number, _, _ in classes] == list(range(HEAT_LEVELS + 1))
    assert classes[10][1] == "probability up to 0.1"
    assert classes[0][2][3] == 0
    light = [sum(colour[:3]) for _, _, colour in classes[1:]]
    assert light == sorted(light, reverse=True)


def test_other_places_carry_their_weights_and_particles_come_with_a_filter(
    driven: tuple[Path, list[events.StepTaken]],
) -> None:
    path, steps = driven
    found = batches_of(path)
    places = column(found["/drive/map/belief/places"], "Points2D:positions")
    believed = steps[0].pose_estimate
    assert believed is not None
    assert places[0][0] == pytest.approx([believed.x_m - 2.0, believed.y_m], abs=1e-5)
    assert column(found["/drive/map/belief/places/weights"], "Points2D:labels")[0] == ["0.08"]
    cloud = column(found["/drive/map/belief/particles"], "Points2D:positions")
    assert [len(points) for points in cloud] == [rehearsal.PARTICLES] * len(steps)


def test_both_confidences_spreads_and_errors_are_curves(driven: tuple[Path, list[events.StepTaken]]) -> None:
    path, steps = driven
    found = batches_of(path)

    def curve(entity: str) -> list[float]:
        return np.ravel(column(found[f"/metrics/{entity}"], "Scalars:scalars")).tolist()

    assert curve("confidence/estimate") == pytest.approx([0.9] * len(steps))
    assert curve("confidence/picture") == pytest.approx([0.98 * 0.8] * len(steps))
    assert curve("spread/filter") == pytest.approx([0.11] * len(steps))
    assert curve("spread/picture") == pytest.approx([0.08] * len(steps))
    assert curve("position_error/picture") == pytest.approx([0.0] * len(steps))
    assert max(curve("position_error/estimate")) > 0.9


def looked(belief: bool, clock: Clock) -> events.Looked:
    pose = Pose(3.0, 3.0, 0.0)
    said = rehearsal.belief_about(pose, 0.6) if belief else None
    return events.Looked(clock, pose, rehearsal.picture(pose), pose._replace(x_m=3.7), said)


def test_a_look_before_the_first_action_is_recorded_without_a_filter_too(tmp_path: Path) -> None:
    path = record(tmp_path / "run.rrd", "3d", [rehearsal.started(), looked(True, Clock(1, 0, 0.0))])
    found = batches_of(path)
    assert len(column(found[HEAT], "SegmentationImage:buffer")) == 1
    assert len(column(found["/camera/rgb"], "EncodedImage:blob")) == 1
    assert np.ravel(column(found["/metrics/confidence/estimate"], "Scalars:scalars")) == pytest.approx([0.98 * 0.6])
    assert column(found["/drive/map/belief/places/weights"], "Points2D:labels") == [["0.39"]]
    assert not column(found["/drive/map/belief/particles"], "Points2D:positions")
    assert not column(found["/metrics/position_error/picture"], "Scalars:scalars")


def test_without_a_localizer_there_is_no_belief_and_no_summary_of_looks(tmp_path: Path) -> None:
    path = record(tmp_path / "run.rrd", "3d", [rehearsal.started(), looked(False, Clock(1, 0, 0.0))])
    found = batches_of(path)
    assert not column(found["/metrics/confidence/estimate"], "Scalars:scalars")
    for pose in ("estimate", "believed"):
        assert np.ravel(column(found[f"/metrics/position_error/{pose}"], "Scalars:scalars")) == pytest.approx([0.7])
    assert summarize(path).looks is None


def test_looks_are_summed_up_by_whether_they_were_right(driven: tuple[Path, list[events.StepTaken]]) -> None:
    path, steps = driven
    looks = summarize(path).looks
    assert looks is not None
    off_m = [np.hypot(s.pose_true[0] - s.pose_estimate[0], s.pose_true[1] - s.pose_estimate[1]) for s in steps]  # type: ignore[index]  # in 3D
    assert (looks.looks, looks.wrong) == (len(steps), int((np.array(off_m) > 0.5).sum()))
    assert 0 < looks.wrong < looks.looks
    assert looks.confidence_wrong == looks.confidence_right == pytest.approx(0.9)


def test_of_looks_that_are_all_right_there_is_no_confidence_of_wrong_ones(tmp_path: Path) -> None:
    sent = [*rehearsal.driven_run(1)]
    looks = summarize(record(tmp_path / "run.rrd", "3d", sent)).looks
    assert looks is not None
    assert (looks.wrong, looks.wrong_share, looks.confidence_wrong) == (0, 0.0, None)
