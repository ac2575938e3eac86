"""Laser logs are read as they were written, and what is wrong with them is said or counted."""

from __future__ import annotations

import gzip
import math
import time
from collections.abc import Callable, Iterable
from pathlib import Path

import numpy as np
import pytest
from room_log import BETWEEN_S, FIRST_S, NOTHING_M, START, flaser, odom, ranges_at, room_lines, way

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, compose
from twonav_cli.mapping.carmen import LaserLog, beam_angles, read_carmen
from twonav_cli.mapping.carmen_lines import CUT_OFF
from twonav_cli.mapping.scan import points_of
from twonav_cli.paths import scenes_dir

SLAM = scenes_dir().parent.parent / "shared" / "data" / "slam"
ORIGIN = Pose(0.0, 0.0, 0.0)

Read = Callable[..., LaserLog]


@pytest.fixture
def read(tmp_path: Path) -> Read:
    """Return a function that writes lines as a log and reads it."""

    def written(lines: Iterable[str], mount: Pose | None = None) -> LaserLog:
        path = tmp_path / "room.clf"
        path.write_text("".join(f"{line}\n" for line in lines))
        return read_carmen(path, mount)

    return written


def complaint(path: Path) -> str:
    with pytest.raises(TwonavError) as caught:
        read_carmen(path)
    message = str(caught.value)
    assert "\n" not in message
    assert str(path) in message
    return message


def scan(index: int, ranges_m: Iterable[float] = (1.0, 2.0, 3.0), pose: Pose | None = None) -> str:
    return flaser(FIRST_S + index, ranges_m, pose or Pose(0.1 * index, 0.0, 0.0))


# What is in a log


def test_scans_keep_their_stamps_poses_and_ranges(read: Read) -> None:
    log = read(room_lines(5))
    expected = [f"{FIRST_S + BETWEEN_S * index:.6f}" for index in range(5)]
    assert [f"{reading.stamp_s:.6f}" for reading in log.readings] == expected
    assert log.readings[0].pose_odom == (0.0, 0.0, 0.0)
    assert log.readings[3].ranges_m == pytest.approx(ranges_at(way(4)[3], 181), abs=0.0051)
    assert log.left_out == {}
    assert log.warnings == []


def test_the_points_of_a_scan_lie_on_the_walls_of_the_room(read: Read) -> None:
    log = read(room_lines(1, beams=361))
    x_m, y_m = points_of(log.sensor, log.readings[0].ranges_m, START).T
    on_wall = np.minimum(np.abs(np.abs(x_m) - 3.0), np.abs(np.abs(y_m) - 2.0))
    assert on_wall.max() < 0.01


@pytest.mark.parametrize(
    ("beams", "spacing_deg", "last_deg"), [(180, 1.0, 89.0), (181, 1.0, 90.0), (360, 0.5, 89.5), (361, 0.5, 90.0)]
)
def test_beams_begin_at_the_right_and_only_an_odd_number_ends_at_the_left(
    beams: int, spacing_deg: float, last_deg: float
) -> None:
    angles_deg = np.degrees(beam_angles(beams))
    assert angles_deg[[0, -1]] == pytest.approx([-90.0, last_deg])
    assert np.diff(angles_deg) == pytest.approx(spacing_deg)


def test_the_place_of_the_laser_is_read_from_the_two_poses_of_a_line(read: Read) -> None:
    mount = Pose(0.2, -0.1, math.pi)
    poses = way(9)
    lines = [flaser(FIRST_S + i, (1.0, 2.0), pose, compose(pose, mount)) for i, pose in enumerate(poses)]
    seen = read([*lines, flaser(FIRST_S + 20, (1.0, 2.0), poses[-1], Pose(5.0, 5.0, 0.0))]).sensor.mount
    assert seen[:2] == pytest.approx(mount[:2], abs=1e-5)
    assert abs(seen.theta_rad) == pytest.approx(math.pi, abs=1e-5)


def test_a_laser_whose_place_changes_sits_in_the_middle_and_that_is_said(read: Read) -> None:
    lines = [flaser(FIRST_S + i, (1.0, 2.0), pose, compose(pose, Pose(0.1 * i, 0, 0))) for i, pose in enumerate(way(9))]
    log = read(lines)
    assert log.sensor.mount == ORIGIN
    assert "of 9 scans say otherwise where the laser sits" in log.warnings[0]


def test_a_line_whose_laser_has_no_place_does_not_count_for_it(read: Read) -> None:
    mount = Pose(0.2, 0.0, 0.0)
    lasers = [Pose(0.0, math.nan, 0.0), *(compose(pose, mount) for pose in way(9)[1:])]
    lines = [flaser(FIRST_S + i, (1.0, 2.0), pose, lasers[i]) for i, pose in enumerate(way(9))]
    log = read(lines)
    assert log.sensor.mount == pytest.approx(mount, abs=1e-5)
    assert len(log.readings) == 9


def test_the_place_of_the_laser_may_be_known_better(read: Read) -> None:
    assert read(room_lines(3), Pose(-0.04, 0.0, 0.0)).sensor.mount == (-0.04, 0.0, 0.0)


@pytest.mark.parametrize(("nothing_m", "limit_m"), [(NOTHING_M, 80.0), (8191.0, 80.0), (8.19, 8.19), (None, 80.0)])
def test_what_the_laser_says_where_it_sees_nothing_is_no_measurement(
    read: Read, nothing_m: float | None, limit_m: float
) -> None:
    seen = [[1.0 + 0.02 * i + 0.01 * k for k in range(60)] for i in range(5)]
    lines = [scan(i, [*ranges[:-2], nothing_m or ranges[-2], nothing_m or ranges[-1]]) for i, ranges in enumerate(seen)]
    log = read(lines)
    assert log.sensor.max_m == pytest.approx(limit_m)
    assert len(points_of(log.sensor, log.readings[0].ranges_m, ORIGIN)) == (60 if nothing_m is None else 58)


def test_odometry_lines_are_kept_in_order_and_tell_the_way_between_scans(read: Read) -> None:
    corner = [odom(FIRST_S + 1.0, Pose(1.0, 0.0, 0.0)), odom(FIRST_S, ORIGIN), odom(FIRST_S + 2.0, Pose(1.0, 1.0, 0.0))]
    log = read([scan(0, pose=ORIGIN), *corner, scan(2, pose=Pose(1.0, 1.0, 0.0))])
    assert [stamped.pose.x_m for stamped in log.odometry] == [0.0, 1.0, 1.0]
    assert log.driven_m == pytest.approx(2.0)
    assert log.duration_s == pytest.approx(2.0)


def test_the_first_scans_of_a_log_are_a_log_too(read: Read) -> None:
    log = read([scan(0), odom(FIRST_S + 0.5, Pose(0.3, 0, 0)), scan(1), odom(FIRST_S + 1.5, Pose(9.0, 0, 0)), scan(2)])
    assert (log.first(2).duration_s, len(log.first(2).odometry)) == (pytest.approx(1.0), 1)
    assert log.first(3).odometry == log.odometry


def test_without_odometry_lines_the_way_is_that_of_the_scans(read: Read) -> None:
    assert read([scan(0), scan(1), scan(4)]).driven_m == pytest.approx(0.4)


def test_a_packed_log_is_known_by_its_content(tmp_path: Path) -> None:
    content = "\n".join(room_lines(4)).encode()
    (tmp_path / "a.log").write_bytes(gzip.compress(content))
    (tmp_path / "b.gz").write_bytes(content)
    (tmp_path / "c.gz").write_bytes(gzip.compress(content[:20000]) + gzip.compress(content[20000:]))
    assert [len(read_carmen(tmp_path / name).readings) for name in ("a.log", "b.gz", "c.gz")] == [4, 4, 4]


# What is wrong with a log


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (b"", "has no scans: it is empty"),
        (b"# nothing but a comment\n", "has no scans: it holds comments 1"),
        (odom(FIRST_S, ORIGIN).encode(), "has no scans: it holds ODOM lines 1"),
        (b"ROBOTLASER1 0 -1.57\nPARAM a b\nPARAM c d\n", "it holds PARAM lines 2, ROBOTLASER1 lines 1"),
        (b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR", "is not a text log"),
        (b"\x1f\x8b no gzip at all", "has no scans"),
        (f"FLASER 2 1 2 {'nan ' * 6}5.0 r 0".encode(), "no pose in the FLASER lines, and no ODOM lines"),
    ],
)
def test_a_file_that_is_no_log_is_one_line(tmp_path: Path, content: bytes, said: str) -> None:
    path = tmp_path / "some.log"
    path.write_bytes(content)
    assert said in complaint(path)


def test_a_missing_log_and_a_folder_are_one_line(tmp_path: Path) -> None:
    assert "there is no log at" in complaint(tmp_path / "none.clf")
    assert "cannot read the log" in complaint(tmp_path)


def test_a_log_larger_than_the_limit_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("twonav_cli.mapping.carmen_lines.MAX_BYTES", 1000)
    for name, pack in (("a.clf", bytes), ("a.gz", gzip.compress)):
        (tmp_path / name).write_bytes(pack("\n".join(room_lines(3)).encode()))
        assert "cut the log into parts" in complaint(tmp_path / name)


def test_other_lines_are_counted_by_what_they_are(read: Read) -> None:
    others = ["# a comment", "", "PARAM robot_width 0.4", "PARAM robot_length 0.4", "TRUEPOS 1 2 3", "what is this"]
    log = read([*others[:3], scan(0), *others[3:], scan(1)])
    assert len(log.readings) == 2
    assert log.left_out == {"comments": 1, "PARAM lines": 2, "TRUEPOS lines": 1, "unknown lines": 1}


@pytest.mark.parametrize(
    "line",
    [
        "FLASER",
        "FLASER 3",
        "FLASER three 1 2 3",
        "FLASER -3 1 2 3 0 0 0 0 0 0 5.0 r 0",
        "FLASER 0 0 0 0 0 0 0 5.0 r 0",
        "FLASER 999999999 1 2 3 0 0 0 0 0 0 5.0 r 0",
        "FLASER 3 1 2 x 0 0 0 0 0 0 5.0 r 0",
        "FLASER 3 1 2 3 0 0 0 0 0 0 nan r 0",
        "ODOM 1 2",
        "ODOM nan 2 3 0 0 0 5.0 r 0",
        "ODOM 1e300 2 3 0 0 0 5.0 r 0",
    ],
)
def test_a_broken_line_is_counted(read: Read, line: str) -> None:
    log = read([scan(0), line, scan(1)])
    assert len(log.readings) == 2
    assert log.left_out == {"broken lines": 1}


def test_a_log_whose_last_line_is_cut_off_is_read_without_it(tmp_path: Path) -> None:
    content = "\n".join(room_lines(4))
    path = tmp_path / "cut.clf"
    path.write_text(content[:-300])
    log = read_carmen(path)
    assert (len(log.readings), log.left_out) == (3, {"broken lines": 1})


@pytest.mark.parametrize("damage", [lambda packed: packed[:-2000], lambda packed: packed[:-4] + b"oops"])
def test_a_packed_log_that_is_cut_off_or_damaged_is_used_as_far_as_it_goes(
    tmp_path: Path, damage: Callable[[bytes], bytes]
) -> None:
    path = tmp_path / "cut.gz"
    path.write_bytes(damage(gzip.compress("\n".join(room_lines(40)).encode())))
    log = read_carmen(path)
    assert 20 < len(log.readings) <= 40
    assert CUT_OFF in log.warnings


def test_readings_that_are_no_distances_are_not_measured(read: Read) -> None:
    ranges_m = read([scan(0, (1.0, math.nan, -2.0, math.inf, 0.0, 3.0))]).readings[0].ranges_m
    assert np.isfinite(ranges_m).tolist() == [True, False, False, False, False, True]


def test_scans_of_another_number_of_beams_than_most_are_left_out(read: Read) -> None:
    log = read([scan(0, (1.0, 2.0)), scan(1), scan(2), scan(3, (1.0,) * 7), scan(4)])
    assert [reading.stamp_s - FIRST_S for reading in log.readings] == pytest.approx([1, 2, 4])
    assert log.left_out == {"scans of another number of beams": 2}


def test_a_scan_whose_time_goes_back_or_stands_still_is_left_out(read: Read) -> None:
    log = read([scan(0), scan(1), scan(2), scan(1), scan(2), scan(3)])
    assert [reading.stamp_s - FIRST_S for reading in log.readings] == pytest.approx([0, 1, 2, 3])
    assert log.left_out == {"scans whose time does not go on": 2}


def test_one_time_in_the_future_does_not_cost_the_scans_after_it(read: Read) -> None:
    log = read([scan(0), scan(9999), scan(1), scan(2), scan(3)])
    assert [reading.stamp_s - FIRST_S for reading in log.readings] == pytest.approx([0, 1, 2, 3])


@pytest.mark.parametrize("stamp_s", [-1e300, -1.7e12, 1.7e12, 1e300, 1.7e308])
@pytest.mark.parametrize("index", [0, 15, 29])
def test_a_scan_whose_time_is_absurdly_far_from_the_others_is_left_out(read: Read, stamp_s: float, index: int) -> None:
    lines = [scan(i) for i in range(30)]
    lines[index] = flaser(stamp_s, (1.0, 2.0, 3.0), ORIGIN)
    log = read(lines)
    assert len(log.readings) == 29
    assert log.duration_s < 30.0
    assert log.left_out == {"scans whose time is far from the others'": 1}
    assert log.warnings == []


def test_milliseconds_are_no_reason_to_leave_a_scan_out(read: Read) -> None:
    log = read([flaser(1.7e12 + 1000.0 * i, (1.0, 2.0, 3.0), Pose(0.1 * i, 0.0, 0.0)) for i in range(9)])
    assert (len(log.readings), log.left_out, log.warnings) == (9, {}, [])


def test_many_scans_whose_time_is_far_from_the_others_are_a_warning(read: Read) -> None:
    nanoseconds = [flaser(1.7e18 + 1e9 * i, (1.0, 2.0, 3.0), Pose(0.1 * i, 0.0, 0.0)) for i in range(30)]
    assert (
        "scans are left out: their time is far from the others' (time must be in seconds)"
        in read(nanoseconds).warnings[0]
    )


def test_a_clock_that_is_set_back_on_the_way_is_a_warning(read: Read) -> None:
    before, after = [scan(1000 + i) for i in range(5)], [scan(i) for i in range(4)]
    log = read([*before, *after])
    assert log.left_out == {"scans whose time does not go on": 4}
    (warning,) = log.warnings
    assert warning.startswith("4 of 9 scans are left out: their time does not go on")
    assert "cut the log" in warning


def test_a_few_scans_whose_time_does_not_go_on_are_only_counted(read: Read) -> None:
    log = read([scan(0), scan(1), scan(1), *(scan(i) for i in range(2, 12))])
    assert log.left_out == {"scans whose time does not go on": 1}
    assert log.warnings == []


def test_a_scan_without_a_pose_takes_it_from_the_odometry_lines_around_it(read: Read) -> None:
    lost = scan(2, pose=Pose(math.nan, 0.0, 0.0))
    turned = odom(FIRST_S + 3.0, Pose(0.4, 0.2, -3.0))
    log = read([scan(0), odom(FIRST_S + 1.0, Pose(0.2, 0.0, 3.0)), lost, turned, scan(4)])
    assert len(log.readings) == 3
    assert log.readings[1].pose_odom[:2] == pytest.approx((0.3, 0.1))
    assert abs(log.readings[1].pose_odom.theta_rad) == pytest.approx(math.pi, abs=1e-6)


@pytest.mark.parametrize(
    "pose",
    [
        Pose(math.nan, 0.0, 0.0),
        Pose(0.0, math.nan, 0.0),
        Pose(0.0, 0.0, math.nan),
        Pose(0.0, math.inf, 0.0),
        Pose(1e300, 0.0, 0.0),
    ],
)
def test_a_scan_that_has_no_pose_at_all_is_left_out(read: Read, pose: Pose) -> None:
    log = read([scan(0), scan(1, pose=pose), scan(2)])
    assert len(log.readings) == 2
    assert log.left_out == {"scans without a pose": 1}


def test_scans_that_carry_no_odometry_take_all_of_it_from_the_odometry_lines(read: Read) -> None:
    scans = [scan(i, pose=ORIGIN) for i in range(4)]
    poses = [odom(FIRST_S + i - 0.5, Pose(float(i), 0.0, 0.0)) for i in range(4)]
    log = read([*scans, *poses])
    assert [reading.pose_odom.x_m for reading in log.readings] == pytest.approx([0.5, 1.5, 2.5])
    assert log.left_out == {"scans without a pose": 1}
    assert "odometry: it is taken from the ODOM lines" in log.warnings[0]


def test_odometry_that_is_set_anew_on_the_way_does_not_move_the_robot(read: Read) -> None:
    before = [scan(i, pose=Pose(100.0 + i, 50.0, 0.0)) for i in range(3)]
    after = [scan(3 + i, pose=Pose(0.0, float(i), math.pi / 2)) for i in range(3)]
    log = read([*before, *after])
    assert [reading.pose_odom.x_m for reading in log.readings] == pytest.approx([100, 101, 102, 102, 103, 104])
    assert [reading.pose_odom.y_m for reading in log.readings] == pytest.approx([50.0] * 6)
    assert "(jumps in all: 1)" in log.warnings[0]


def test_odometry_that_is_set_anew_in_a_long_pause_does_not_move_the_robot_either(read: Read) -> None:
    log = read(
        [scan(0, pose=ORIGIN), scan(9000, pose=Pose(800.0, 900.0, 1.0)), scan(9001, pose=Pose(800.0, 901.0, 1.0))]
    )
    assert log.readings[1].pose_odom == pytest.approx(ORIGIN)
    assert log.driven_m == pytest.approx(1.0)


def test_a_robot_that_went_far_in_a_long_pause_did_not_jump(read: Read) -> None:
    log = read([scan(0, pose=ORIGIN), scan(60, pose=Pose(20.0, 0.0, 0.0))])
    assert log.readings[1].pose_odom.x_m == 20.0
    assert log.warnings == []


# The real ones


@pytest.mark.skipif(not SLAM.is_dir(), reason="the real logs are not here")
@pytest.mark.parametrize(
    ("name", "scans", "beams", "driven_m", "reference"),
    [
        ("mit-csail.clf.gz", 1988, 361, 373.6, "mit-csail.flirt_graph.txt"),
        ("mit-csail.clf.gz", 1988, 361, 373.6, "mit-csail.authors_gmapping.txt"),
        ("fr079_flirtseq.clf.gz", 1464, 360, 391.1, "fr079.relations"),
    ],
)
def test_a_real_log_is_read_whole_in_a_moment_and_has_the_stamps_of_its_reference(
    name: str, scans: int, beams: int, driven_m: float, reference: str
) -> None:
    begun_s = time.process_time()
    log = read_carmen(SLAM / name)
    assert time.process_time() - begun_s < 2.0
    assert (len(log.readings), len(log.sensor.angles_rad), log.sensor.max_m) == (scans, beams, 80.0)
    assert log.sensor.mount == ORIGIN
    assert log.warnings == []
    assert set(log.left_out) == {"comments"}
    assert log.driven_m == pytest.approx(driven_m, abs=0.1)
    stamps = {f"{reading.stamp_s:.6f}" for reading in log.readings}
    asked = [line.split()[0] for line in (SLAM / reference).read_text().splitlines() if line[:1].isdigit()]
    found = sum(stamp in stamps for stamp in asked)
    assert found >= (0.99 if "csail" in name else 0.08) * len(asked)


def test_ranges_that_are_no_distances_are_counted(read: Read) -> None:
    odd = [flaser(float(i), (1.0, float("nan"), -1.0), Pose(0.1 * i, 0.0, 0.0)) for i in range(4)]
    (warning,) = read(odd).warnings
    assert warning.startswith("8 of 12 ranges are negative or not a number")


def test_many_scans_of_another_number_of_beams_are_a_warning(read: Read) -> None:
    lines = [flaser(float(i), (1.0,) * (3 if i < 6 else 5), Pose(0.1 * i, 0.0, 0.0)) for i in range(10)]
    (warning,) = read(lines).warnings
    assert warning.startswith("4 of 10 scans are left out: they have another number of beams")
