from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from furnished_room import (
    BETWEEN_S,
    CONFIG,
    FIRST_S,
    ROOM,
    SENSOR,
    START,
    mapped,
    noisy,
    odometry_of,
    ranges_at,
    readings_of,
    way,
)

from twonav_cli.config import MappingConfig
from twonav_cli.errors import TwonavError
from twonav_cli.events import Event, KeyframeMapped, MapDrawn
from twonav_cli.geometry import Pose, compose, distance_m, relative_pose, wrap_angle
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.mapper import KEYFRAMES_PER_DRAWING, GridMapper
from twonav_cli.mapping.scan import RangeSensor, Reading

STEPS = 110
"""Once around the table."""


def turned_deg(a: Pose, b: Pose) -> float:
    return float(abs(np.degrees(wrap_angle(a.theta_rad - b.theta_rad))))


@cache
def drive() -> tuple[list[Pose], list[Reading]]:
    """Return where the robot is and what it reads."""
    poses = way(STEPS)
    return poses, readings_of(poses, odometry_of(poses))


@cache
def finished() -> GridMapper:
    return mapped(drive()[1])


def distance_to_walls_m(points: np.ndarray) -> np.ndarray:
    """Return how far points [N, 2] are from the nearest wall of the room."""
    along = ROOM[:, 1] - ROOM[:, 0]
    away = points[:, None] - ROOM[None, :, 0]
    share = np.clip((away * along).sum(axis=-1) / (along**2).sum(axis=-1), 0, 1)
    return np.asarray(np.hypot(*(away - share[..., None] * along).T).T.min(axis=1))


def test_a_drive_whose_odometry_drifts_is_mapped() -> None:
    poses, readings = drive()
    odom = compose(START, relative_pose(readings[0].pose_odom, readings[-1].pose_odom))
    assert distance_m(odom, poses[-1]) > 0.2
    assert turned_deg(odom, poses[-1]) > 10
    mapper = finished()
    assert distance_m(mapper.pose(), poses[-1]) < 0.02
    assert turned_deg(mapper.pose(), poses[-1]) < 0.3
    true = {reading.stamp_s: pose for reading, pose in zip(readings, poses, strict=True)}
    pairs = [(stamped.pose, true[stamped.stamp_s]) for stamped in mapper.trajectory()]
    assert len(pairs) == mapper.keyframes > 15
    assert max(distance_m(*pair) for pair in pairs) < 0.03
    assert np.mean([turned_deg(*pair) for pair in pairs]) < 0.3


@pytest.mark.parametrize("changes", [{"particles": 1}, {"proposal": "maximum"}, {"resample_share": 0.999}])
def test_one_particle_the_maximum_and_many_draws_map_the_drive_as_well(changes: dict[str, object]) -> None:
    poses, readings = drive()
    mapper = mapped(readings, replace(CONFIG, **changes))  # type: ignore[arg-type]  # each field is given its own type
    assert distance_m(mapper.pose(), poses[-1]) < 0.02
    assert turned_deg(mapper.pose(), poses[-1]) < 0.3


def test_walls_and_pixels_lie_on_the_walls_of_the_room() -> None:
    walls = finished().walls()
    assert len(walls) > 300
    off_m = distance_to_walls_m(walls)
    assert np.median(off_m) < 0.007
    assert np.quantile(off_m, 0.95) < 0.03
    map_ = finished().occupancy()
    xs_m, ys_m = map_.frame.centres()
    rows, cols = np.nonzero(map_.occupied)
    assert distance_to_walls_m(np.stack([xs_m[cols], ys_m[rows]], axis=1)).max() < 0.1
    assert map_.free[map_.frame.cell_at(START.x_m, START.y_m)]
    assert not map_.free[map_.frame.cell_at(0.04, 0.02)]  # within the table
    assert map_.free.sum() * CONFIG.resolution_m**2 == pytest.approx(6.21 * 4.55 - 1.09 * 1.47 - 2.7, rel=0.06)


def test_the_frame_asked_for_is_the_frame_of_the_map() -> None:
    frame = GridFrame(-1.0, -0.5, CONFIG.resolution_m, 40, 60)
    map_, whole = finished().occupancy(frame), finished().occupancy()
    assert map_.frame == frame
    for row, col in ((0, 0), (39, 59), (20, 33), (35, 20)):
        x_m, y_m = frame.centre_of(whole.frame.cell_at(0.0, 0.0)._replace(row=row, col=col))
        assert map_.pixels[row, col] == whole.pixels[whole.frame.cell_at(x_m, y_m)]
    assert map_.occupied.sum() > 30


def test_a_corner_puts_the_cells_on_a_frame_that_does_not_begin_at_a_whole_cell() -> None:
    corner = (-3.013, 1.027)
    mapper = GridMapper(CONFIG, SENSOR, start=START, corner=corner)
    mapper.add(drive()[1][0])
    frame = GridFrame(corner[0] - 1.0, corner[1] - 3.0, CONFIG.resolution_m, 100, 130)
    map_ = mapper.occupancy(frame)
    xs_m, ys_m = frame.centres()
    rows, cols = np.nonzero(map_.occupied)
    assert len(rows) > 60
    assert distance_to_walls_m(np.stack([xs_m[cols], ys_m[rows]], axis=1)).max() < 0.05
    assert np.median(distance_to_walls_m(mapper.walls())) < 0.005


def test_the_same_seed_gives_the_same_bytes_and_another_seed_others() -> None:
    _, readings = drive()
    again, other = mapped(readings), mapped(readings, seed=1)
    assert again.occupancy().digest == finished().occupancy().digest
    assert again.walls().tobytes() == finished().walls().tobytes()
    assert again.trajectory() == finished().trajectory()
    assert other.trajectory() != finished().trajectory()
    assert other.walls().tobytes() != finished().walls().tobytes()


def test_who_listens_changes_nothing() -> None:
    sent: list[Event] = []
    mapper = GridMapper(CONFIG, SENSOR, 0, START, sent.append)
    for reading in drive()[1]:
        mapper.add(reading)
    assert mapper.trajectory() == finished().trajectory()
    assert mapper.occupancy().digest == finished().occupancy().digest
    assert len(sent) > mapper.keyframes


def test_every_keyframe_is_told_with_weights_that_sum_to_one() -> None:
    poses, readings = drive()
    sent: list[Event] = []
    mapper = GridMapper(CONFIG, SENSOR, 0, START, sent.append)
    taken = [mapper.add(reading, pose) for reading, pose in zip(readings, poses, strict=True)]
    told = [event for event in sent if isinstance(event, KeyframeMapped)]
    assert taken[0]
    assert len(told) == sum(taken) == mapper.keyframes
    assert [event.clock.step for event in told] == list(range(1, len(told) + 1))
    for index, event in zip(np.flatnonzero(taken).tolist(), told, strict=True):
        assert event.clock.time_s == pytest.approx(BETWEEN_S * index)
        assert event.pose_true == poses[index]
        assert event.poses.shape == (CONFIG.particles, 3)
        assert event.weights.shape == (CONFIG.particles,)
        assert event.weights.sum() == pytest.approx(1.0)
        assert event.effective == pytest.approx(1 / (event.weights**2).sum())
        assert event.resampled == (event.effective < 0.5 * CONFIG.particles)
        assert event.unmatched == 0
        assert event.hits.shape == (len(SENSOR.angles_rad), 2)
        assert np.median(distance_to_walls_m(event.hits)) < 0.02
        assert distance_m(event.pose, poses[index]) < 0.03
        assert np.hypot(*(event.poses[:, :2] - event.pose[:2]).T).min() < 1e-9
    first = told[0]
    assert first.pose == pytest.approx(START)
    assert first.pose_odom == pytest.approx(START)
    last = np.flatnonzero(taken)[-1]
    odom = compose(START, relative_pose(readings[0].pose_odom, readings[last].pose_odom))
    assert told[-1].pose_odom == pytest.approx(odom)


def test_the_map_is_drawn_at_the_first_keyframe_and_then_now_and_again() -> None:
    sent: list[Event] = []
    mapper = GridMapper(CONFIG, SENSOR, 0, START, sent.append)
    for reading in drive()[1]:
        mapper.add(reading)
    drawings = [event for event in sent if isinstance(event, MapDrawn)]
    assert [event.clock.step for event in drawings] == list(range(1, mapper.keyframes + 1, KEYFRAMES_PER_DRAWING))
    for event in drawings:
        assert event.pixels.shape == event.frame.shape
        assert event.pixels.dtype == np.uint8
        assert set(np.unique(event.pixels)) == {0, 205, 254}
        assert event.path.shape == (event.clock.step, 3)
        assert event.path[0] == pytest.approx(np.array(START))
    mapper.draw()
    assert isinstance(sent[-1], MapDrawn)
    assert np.array_equal(sent[-1].pixels, mapper.occupancy().pixels)
    assert sent[-1].path == pytest.approx(np.array([stamped.pose for stamped in mapper.trajectory()]))


def test_particles_that_carry_little_weight_are_drawn_again_and_that_is_told() -> None:
    told: list[KeyframeMapped] = []
    mapper = GridMapper(
        replace(CONFIG, weight_gain=1.0), SENSOR, 0, START,
        lambda event: told.append(event) if isinstance(event, KeyframeMapped) else None,
    )  # fmt: skip
    for reading in drive()[1]:
        mapper.add(reading)
    resampled = np.array([event.resampled for event in told])
    assert 0 < resampled.sum() < len(told)
    assert np.array_equal(resampled, [event.effective < 0.5 * CONFIG.particles for event in told])
    assert distance_m(mapper.pose(), drive()[0][-1]) < 0.02


def test_a_keyframe_comes_after_a_way_or_a_turn() -> None:
    still = Pose(0.0, 0.0, 0.0)
    ranges_m = ranges_at(START)
    for step, scans in ((Pose(0.11, 0.0, 0.0), 5), (Pose(0.0, 0.0, 0.06), 5), (Pose(0.0, 0.0, -0.06), 5)):
        mapper, odom, taken = GridMapper(CONFIG, SENSOR, start=START), still, []
        for k in range(11):
            taken.append(mapper.add(Reading(FIRST_S + k, odom, ranges_m)))
            odom = compose(odom, step)
        assert np.flatnonzero(taken).tolist() == [0, scans, 2 * scans]


def test_stamps_are_those_of_the_log() -> None:
    stamps = {reading.stamp_s for reading in drive()[1]}
    path = finished().trajectory()
    assert path[0].stamp_s == FIRST_S
    assert all(stamped.stamp_s in stamps for stamped in path)
    assert path[0].pose == pytest.approx(START)
    assert (np.diff([stamped.stamp_s for stamped in path]) > 0).all()


def test_a_robot_that_never_moves_stays_where_it_is() -> None:
    mapper, rng = GridMapper(CONFIG, SENSOR, start=START), np.random.default_rng(0)
    for k in range(30):
        assert mapper.add(Reading(FIRST_S + k, Pose(3.0, 4.0, 2.0), noisy(ranges_at(START), rng))) == (k == 0)
    assert distance_m(mapper.pose(), START) < 0.005
    assert turned_deg(mapper.pose(), START) < 0.2
    assert len(mapper.trajectory()) == 1


@pytest.mark.parametrize("scans", [5, 12])
def test_odometry_that_stalls_and_then_jumps_is_followed(scans: int) -> None:
    poses, readings = drive()
    for begin in (20, 41, 60):
        stalled = list(readings)
        for k in range(begin, begin + scans):
            stalled[k] = replace(readings[k], pose_odom=readings[begin - 1].pose_odom)
        mapper = GridMapper(CONFIG, SENSOR, 0, START)
        for reading, pose in zip(stalled, poses, strict=True):
            mapper.add(reading)
            assert distance_m(mapper.pose(), pose) < 0.05
        assert distance_m(mapper.pose(), poses[-1]) < 0.02
        assert turned_deg(mapper.pose(), poses[-1]) < 0.5


def test_odometry_that_turns_far_too_much_in_one_step_is_corrected() -> None:
    poses, readings = drive()
    at, slip = readings[40].pose_odom, compose(readings[40].pose_odom, Pose(0.1, 0.05, 0.35))
    slipped = [replace(reading, pose_odom=compose(slip, relative_pose(at, reading.pose_odom))) for reading in readings]
    mapper = mapped([*readings[:40], *slipped[40:]])
    assert distance_m(mapper.pose(), poses[-1]) < 0.02
    assert turned_deg(mapper.pose(), poses[-1]) < 0.3


def test_odometry_that_jumps_out_of_the_world_is_an_error() -> None:
    mapper = GridMapper(CONFIG, SENSOR, start=START)
    mapper.add(Reading(FIRST_S, Pose(0.0, 0.0, 0.0), ranges_at(START)))
    with pytest.raises(TwonavError, match="jump in the odometry"):
        mapper.add(Reading(FIRST_S + 1, Pose(1e5, 0.0, 0.0), unseen("NaN")))


def test_beams_that_measured_nothing_are_left_out() -> None:
    poses, readings = drive()
    rng = np.random.default_rng(0)
    holed = []
    for reading in readings[:60]:
        ranges_m = reading.ranges_m.copy()
        ranges_m[rng.random(len(ranges_m)) < 0.2] = np.nan
        ranges_m[rng.random(len(ranges_m)) < 0.1] = rng.choice([np.inf, 0.0, -1.0, 81.91])
        holed.append(replace(reading, ranges_m=ranges_m))
    mapper = mapped(holed)
    assert distance_m(mapper.pose(), poses[59]) < 0.02
    assert distance_to_walls_m(mapper.walls()).max() < 0.1


def unseen(kind: str) -> np.ndarray:
    value = {"NaN": np.nan, "beyond the limit": 81.91, "infinite": np.inf}[kind]
    return np.full(len(SENSOR.angles_rad), value)


@pytest.mark.parametrize("kind", ["NaN", "beyond the limit", "infinite"])
def test_scans_of_nothing_leave_the_robot_to_odometry_and_the_next_scan_finds_it(kind: str) -> None:
    poses, readings = drive()
    blind = [replace(reading, ranges_m=unseen(kind)) if 30 <= k < 36 else reading for k, reading in enumerate(readings)]
    mapper = GridMapper(CONFIG, SENSOR, 0, START)
    for k, reading in enumerate(blind[:70]):
        mapper.add(reading)
        assert distance_m(mapper.pose(), poses[k]) < (0.15 if 30 <= k < 36 else 0.04)
    assert distance_m(mapper.pose(), poses[69]) < 0.02


@pytest.mark.parametrize("kind", ["NaN", "beyond the limit"])
def test_a_first_scan_of_nothing_is_a_keyframe_with_an_empty_map(kind: str) -> None:
    told: list[Event] = []
    mapper = GridMapper(CONFIG, SENSOR, 0, START, told.append)
    assert mapper.add(Reading(FIRST_S, Pose(0.0, 0.0, 0.0), unseen(kind)))
    assert (mapper.occupancy().pixels == 205).all()
    assert mapper.walls().shape == (0, 2)
    assert [type(event) for event in told] == [KeyframeMapped, MapDrawn]
    assert mapper.add(Reading(FIRST_S + 1, Pose(0.0, 0.0, 0.0), ranges_at(START))) is False
    assert mapper.pose() == pytest.approx(START)


def test_a_log_without_a_single_wall_is_driven_by_odometry() -> None:
    poses = way(40)
    readings = [Reading(FIRST_S + k, pose, unseen("infinite")) for k, pose in enumerate(poses)]
    mapper = mapped(readings, replace(CONFIG, error_m=0.001, error_rad=0.001, error_m_per_m=0.01, error_rad_per_m=0.01))
    assert mapper.keyframes > 5
    assert distance_m(mapper.pose(), poses[-1]) < 0.2


def test_how_far_a_beam_counts_can_be_shortened() -> None:
    mapper = GridMapper(MappingConfig(particles=1, max_range_m=1.5), SENSOR, start=START)
    mapper.add(Reading(FIRST_S, Pose(0.0, 0.0, 0.0), ranges_at(START)))
    at = compose(START, SENSOR.mount)
    assert 20 < len(mapper.walls()) < 100
    assert np.hypot(*(mapper.walls() - (at.x_m, at.y_m)).T).max() < 1.5 + 1e-3


def test_a_range_finder_that_sits_askew_is_taken_as_it_sits() -> None:
    poses = way(50)
    askew = RangeSensor(np.linspace(-2.0, 2.0, 120), Pose(-0.2, 0.15, 2.5), 8.0)
    odometry = odometry_of(poses)
    mapper = GridMapper(CONFIG, askew, 0, START)
    for k, (pose, odom) in enumerate(zip(poses, odometry, strict=True)):
        mapper.add(Reading(FIRST_S + k, odom, ranges_at(pose, askew)))
    assert distance_m(mapper.pose(), poses[-1]) < 0.02
    assert np.median(distance_to_walls_m(mapper.walls())) < 0.007


def test_a_second_time_around_takes_little_more_memory() -> None:
    config = replace(CONFIG, resolution_m=0.02)
    poses = way(2 * STEPS)
    readings = readings_of(poses, odometry_of(poses))
    once, twice = mapped(readings[: STEPS + 1], config), mapped(readings, config)
    assert once.map_bytes > 1.5 * GridMapper(config, SENSOR).map_bytes
    assert twice.map_bytes < 1.3 * once.map_bytes
    assert distance_m(twice.pose(), poses[-1]) < 0.02


def test_odometry_that_is_not_a_number_is_refused() -> None:
    mapper = GridMapper(CONFIG, SENSOR, start=START)
    with pytest.raises(TwonavError, match="not a number"):
        mapper.add(Reading(FIRST_S, Pose(0.0, float("nan"), 0.0), ranges_at(START)))
