"""`twonav map LOG`: what is written, what is said, and what is refused."""

from __future__ import annotations

import gzip
import json
import os
import re
import shlex
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from room_log import BETWEEN_S, FIRST_S, START, drifting, flaser, odom, ranges_at, room_lines, way

from twonav_cli.checkpoint import signed
from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.geometry import Pose, compose, relative_pose
from twonav_cli.mapping import occupancy, trajectory
from twonav_cli.mapping.mapper import GridMapper
from twonav_cli.mapping.occupancy import load_map
from twonav_cli.mapping.scan import Reading
from twonav_cli.mapping.trajectory import read_trajectory
from twonav_cli.paths import scenes_dir
from twonav_cli.recording.reader import summarize
from twonav_cli.terminal import map_log
from twonav_cli.terminal.map_log import MapRequest, _kept_apart
from twonav_cli.terminal.map_options import MapChoices

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line",)

SLAM = scenes_dir().parent.parent / "shared" / "data" / "slam"
SMALL = ["--particles", "4"]


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """Return a log of a drive through the room whose odometry turns half a degree too far at every step."""
    return written(tmp_path / "room.clf", room_lines(60, turn_rad=0.009))


def written(path: Path, lines: list[str]) -> Path:
    path.write_text("".join(f"{line}\n" for line in lines))
    return path


def card_in(folder: Path) -> dict[str, Any]:
    card = json.loads((folder / "card.json").read_text())
    assert isinstance(card, dict)
    return card


# What is made


def test_a_log_becomes_a_map_a_trajectory_a_card_and_a_recording(twonav: Twonav, runs: Path, log: Path) -> None:
    ended = twonav("map", log, *SMALL)
    assert ended.code == 0
    folder = runs / "maps" / "room"
    assert sorted(path.name for path in folder.iterdir()) == ["card.json", "map.pgm", "map.yaml", "trajectory.txt"]
    (recorded,) = (runs / "recordings").iterdir()
    assert recorded.name.startswith("map-room-")
    for path in (*folder.iterdir(), recorded):
        assert str(path) in ended.out
    assert "scans: 60 of 181 beams, 12 s, 4 m by odometry" in ended.out
    assert "left out: nothing" in ended.out
    assert "warning" not in ended.err


def test_the_map_has_the_walls_of_the_room_where_odometry_alone_would_not(
    twonav: Twonav, tmp_path: Path, log: Path
) -> None:
    assert twonav("map", log, *SMALL, "--no-record", "--out", tmp_path / "a").code == 0
    map_ = load_map(tmp_path / "a" / "map.yaml")
    rows, cols = np.nonzero(map_.occupied)
    x_m, y_m = (axis[index] for axis, index in zip(map_.frame.centres(), (cols, rows), strict=True))
    placed = [compose(START, Pose(float(x), float(y), 0.0)) for x, y in zip(x_m, y_m, strict=True)]
    off = [min(abs(abs(pose.x_m) - 3.0), abs(abs(pose.y_m) - 2.0)) for pose in placed]
    assert np.median(off) < 0.05
    assert np.mean(np.array(off) < 0.12) > 0.95
    assert 0.8 * 24 < map_.free.sum() * 0.05**2 < 24


def test_the_trajectory_has_the_stamps_of_the_log_and_is_nearer_the_truth_than_odometry(
    twonav: Twonav, tmp_path: Path, log: Path
) -> None:
    assert twonav("map", log, *SMALL, "--no-record", "--out", tmp_path / "a").code == 0
    found = read_trajectory(tmp_path / "a" / "trajectory.txt")
    poses = way(60)
    odometry = drifting(poses, 0.009)
    at = [round((stamped.stamp_s - FIRST_S) / BETWEEN_S) for stamped in found]
    assert [stamped.stamp_s for stamped in found] == pytest.approx([FIRST_S + BETWEEN_S * i for i in at], abs=1e-6)
    assert at[0] == 0
    truth = [relative_pose(START, poses[index]) for index in at]
    errors = [np.hypot(s.pose.x_m - t.x_m, s.pose.y_m - t.y_m) for s, t in zip(found, truth, strict=True)]
    without = [np.hypot(odometry[i].x_m - t.x_m, odometry[i].y_m - t.y_m) for i, t in zip(at, truth, strict=True)]
    assert max(errors) < 0.06
    assert max(without) > 0.3


def test_the_card_tells_where_the_map_is_from_and_its_command_makes_it_again(
    twonav: Twonav, tmp_path: Path, log: Path
) -> None:
    chosen = [*SMALL, "--resolution", "0.1", "--keyframe-turn", "30", "--laser-forward", "0.05", "--seed", "2"]
    assert twonav("map", log, *chosen, "--no-record", "--out", tmp_path / "a").code == 0
    card = card_in(tmp_path / "a")
    assert signed(card) == card
    assert (card["kind"], card["log"], card["seed"]) == ("map", "room.clf", 2)
    assert card["settings"]["keyframe_turn_rad"] == pytest.approx(0.5236, abs=1e-4)
    assert card["map_digest"] == load_map(tmp_path / "a" / "map.yaml").digest
    assert card["metrics"]["keyframes"] == len(read_trajectory(tmp_path / "a" / "trajectory.txt"))
    command = shlex.split(card["command"])
    assert twonav(*command[1:], "--no-record", "--out", tmp_path / "b").code == 0
    for name in ("map.pgm", "map.yaml", "trajectory.txt"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()


def test_the_object_for_scripts_holds_the_counts_and_the_files(twonav: Twonav, tmp_path: Path) -> None:
    lines = [*room_lines(30), "# a comment", "PARAM a b", "FLASER 181 1.0"]
    path = tmp_path / "room.log.gz"
    path.write_bytes(gzip.compress("\n".join(lines).encode()))
    ended = twonav("map", path, *SMALL, "--json", "--record", tmp_path / "r.rrd", "--out", tmp_path / "a")
    report = ended.only_object()
    assert (report["log"], report["outcome"], report["scans"]) == ("room", "mapped", 30)
    assert report["left_out"] == {"comments": 1, "PARAM lines": 1, "broken lines": 1}
    assert report["map"]["cols"] * report["map"]["resolution_m"] == pytest.approx(report["map"]["width_m"])
    assert [Path(file).name for file in report["files"]] == ["map.yaml", "map.pgm", "trajectory.txt", "card.json"]
    assert report["recording"] == str(tmp_path / "r.rrd")


def test_the_recording_is_read_by_inspect(twonav: Twonav, tmp_path: Path, log: Path) -> None:
    path = tmp_path / "r.rrd"
    assert twonav("map", log, *SMALL, "--record", path, "--out", tmp_path / "a").code == 0
    metrics = card_in(tmp_path / "a")["metrics"]
    said = twonav("inspect", path).out
    assert "map of log room, seed 0: mapped" in said
    assert f"keyframes: {metrics['keyframes']} in " in said
    assert "; particles: 4" in said
    assert f"{metrics['map']['cols']} x {metrics['map']['rows']} pixels of 0.05 m" in said
    assert "scan matching failed: at no keyframe" in said
    assert re.search(r"largest jump from odometry's guess: 0\.\d+ m at keyframe \d+", said)
    assert f"open it:  rerun {path}" in said
    assert "trial" not in said
    summary = twonav("inspect", path, "--json").only_object()
    assert summary["mapping"]["keyframes"] == metrics["keyframes"]
    assert summary["settings"]["particles"] == "4"


def test_the_same_seed_makes_the_same_map(twonav: Twonav, tmp_path: Path, log: Path) -> None:
    for name in "ab":
        assert twonav("map", log, *SMALL, "--no-record", "--out", tmp_path / name).code == 0
    assert (tmp_path / "a" / "map.pgm").read_bytes() == (tmp_path / "b" / "map.pgm").read_bytes()


def test_a_run_into_a_pipe_ends_with_whole_lines(
    twonav: Twonav, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(map_log, "SHOW_EVERY_S", 0.0)
    err = twonav("map", log, *SMALL, "--no-record", "--out", tmp_path / "a").err
    assert "59 of 60 scans" in err
    assert "━" not in err
    assert "…" not in err


# What is odd about a log


def test_what_is_odd_about_a_log_is_a_warning_on_screen_and_in_the_recording(twonav: Twonav, tmp_path: Path) -> None:
    packed = gzip.compress("\n".join(room_lines(40)).encode())
    path, recorded = tmp_path / "cut.clf.gz", tmp_path / "r.rrd"
    path.write_bytes(packed[:-3000])
    ended = twonav("map", path, *SMALL, "--record", recorded, "--out", tmp_path / "a")
    assert ended.code == 0
    assert "warning: the compressed log is cut off or damaged" in ended.err
    assert "cut off" in card_in(tmp_path / "a")["metrics"]["warnings"][0]
    assert summarize(recorded).ending == "mapped"


def test_a_robot_that_never_moves_makes_the_map_of_one_scan_and_that_is_said(twonav: Twonav, tmp_path: Path) -> None:
    ranges_m = ranges_at(START, 181)
    path = written(tmp_path / "still.clf", [flaser(FIRST_S + i, ranges_m, Pose(1.0, 2.0, 0.5)) for i in range(5)])
    ended = twonav("map", path, *SMALL, "--no-record", "--out", tmp_path / "a")
    assert ended.code == 0
    assert "warning: the robot never moved: the map is that of the first scan" in ended.err
    assert len(read_trajectory(tmp_path / "a" / "trajectory.txt")) == 1


def test_a_log_with_odometry_lines_only_between_scans_is_mapped(twonav: Twonav, tmp_path: Path) -> None:
    lines = []
    for index, line in enumerate(room_lines(20)):
        lines += [line, odom(FIRST_S + BETWEEN_S * (index + 0.5), Pose(0.06 * index, 0.0, 0.0))]
    ended = twonav("map", written(tmp_path / "room.clf", lines), *SMALL, "--no-record")
    assert ended.code == 0
    assert "left out: nothing" in ended.out


# Being interrupted


@pytest.fixture
def interrupted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Send Ctrl-C with the twentieth scan."""

    class Interrupting(GridMapper):
        scans = 0

        def add(self, reading: Reading, pose_true: Pose | None = None) -> bool:
            self.scans += 1
            if self.scans == 20:
                os.kill(os.getpid(), signal.SIGINT)
            return super().add(reading, pose_true)

    monkeypatch.setattr(map_log, "GridMapper", Interrupting)


@pytest.mark.usefixtures("interrupted")
def test_an_interrupted_run_saves_the_map_so_far(twonav: Twonav, tmp_path: Path, log: Path) -> None:
    recorded = tmp_path / "r.rrd"
    ended = twonav("map", log, *SMALL, "--record", recorded, "--out", tmp_path / "a")
    assert ended.code == 130
    assert "stopping: saving the map so far" in ended.err
    assert "stopped after 20 of 60 scans" in ended.err
    assert load_map(tmp_path / "a" / "map.yaml").free.any()
    metrics = card_in(tmp_path / "a")["metrics"]
    assert (metrics["outcome"], metrics["scans"]) == ("stopped", 20)
    assert len(read_trajectory(tmp_path / "a" / "trajectory.txt")) == metrics["keyframes"]
    assert (summarize(recorded).ending, summarize(recorded).whole) == ("stopped", True)


# Writing over an earlier result


@pytest.mark.parametrize("last", ["map.pgm", "map.yaml", "trajectory.txt"])
def test_a_stop_while_writing_never_leaves_new_pixels_under_an_old_card(
    twonav: Twonav, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch, last: str
) -> None:
    folder = tmp_path / "a"
    assert twonav("map", log, *SMALL, "--no-record", "--out", folder).code == 0
    old_yaml = (folder / "map.yaml").read_bytes()

    def stopping(path: Path, content: bytes | str) -> Path:
        written = write_whole(path, content)
        if path.name == last:
            raise TwonavError("stopped here")
        return written

    for module in (occupancy, trajectory, map_log):
        monkeypatch.setattr(module, "write_whole", stopping)
    again = [*SMALL, "--resolution", "0.1", "--no-record", "--out", folder]
    assert "stopped here" in twonav("map", log, *again).complaint
    assert not (folder / "card.json").exists()
    if last == "map.pgm":
        assert not (folder / "map.yaml").exists()
    else:
        assert (folder / "map.yaml").read_bytes() != old_yaml


def test_a_log_with_a_time_that_is_absurdly_far_away_is_mapped_without_it(twonav: Twonav, tmp_path: Path) -> None:
    lines = [flaser(0.0, ranges_at(START, 181), START), *room_lines(20)]
    milliseconds = [line.replace(" 1134864", " 1134864000") for line in lines]
    path = written(tmp_path / "room.clf", milliseconds)
    ended = twonav("map", path, *SMALL, "--record", tmp_path / "r.rrd", "--out", tmp_path / "a")
    assert ended.code == 0
    assert "left out: scans whose time is far from the others' 1" in ended.out


# What is refused


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--particles", "0"], "--particles must be between 1 and 1000: 0 was given"),
        (["--particles", "-3"], "--particles must be between 1 and 1000"),
        (["--particles", "1001"], "--particles must be between 1 and 1000"),
        (["--resolution", "0.001"], "--resolution must be between 0.01 and 1 m: 0.001 was given"),
        (["--resolution", "nan"], "--resolution must be between 0.01 and 1 m"),
        (["--max-range", "0"], "--max-range must be between 0.5 and 1000 m"),
        (["--max-range", "inf"], "--max-range must be between 0.5 and 1000 m"),
        (["--keyframe-distance", "0"], "--keyframe-distance must be between 0.01 and 100 m"),
        (["--keyframe-turn", "400"], "--keyframe-turn must be between 0.1 and 360 degrees"),
        (["--laser-forward", "nan"], "--laser-forward must be within 5 m"),
        (["--record", "run.txt"], "must end in .rrd"),
    ],
)
def test_what_cannot_be_is_one_line_and_nothing_is_written(
    twonav: Twonav, runs: Path, log: Path, arguments: list[str], said: str
) -> None:
    assert said in twonav("map", log, *arguments).complaint
    assert not (runs / "maps" / "room" / "map.yaml").exists()


def test_a_log_that_is_not_there_is_one_line(twonav: Twonav, tmp_path: Path) -> None:
    assert "there is no log at" in twonav("map", tmp_path / "none.clf").complaint


def test_a_log_is_needed(twonav: Twonav) -> None:
    assert twonav("map").code == 2


def test_a_log_in_which_no_beam_hits_anything_is_one_line(twonav: Twonav, tmp_path: Path) -> None:
    path = written(tmp_path / "open.clf", [flaser(FIRST_S + i, [81.91] * 181, Pose(i, 0.0, 0.0)) for i in range(5)])
    said = twonav("map", path).complaint
    assert "no beam" in said
    assert "hits anything nearer than 80 m, where the laser ends: name another log, with ranges in metres" in said
    assert "--max-range" not in said
    path = written(tmp_path / "far.clf", [flaser(FIRST_S + i, [30.0 + 0.01 * i] * 181, START) for i in range(5)])
    assert "name another log, or a larger --max-range" in twonav("map", path, "--max-range", "5").complaint


def test_a_folder_with_something_else_in_it_is_not_written_into(twonav: Twonav, tmp_path: Path, log: Path) -> None:
    (tmp_path / "card.json").write_text('{"kind": "agent", "scene": "kitchen"}')
    before = sorted(path.name for path in tmp_path.iterdir())
    assert "holds something else than the map of a log" in twonav("map", log, "--out", tmp_path).complaint
    assert sorted(path.name for path in tmp_path.iterdir() if path.name != "runs") == before


def test_a_folder_that_cannot_be_written_is_said_before_anything_is_mapped(
    twonav: Twonav, tmp_path: Path, log: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def not_called(*_: Any) -> None:
        raise AssertionError("something was mapped")

    monkeypatch.setattr(map_log, "GridMapper", not_called)
    (tmp_path / "file").write_text("in the way")
    assert "name another --out" in twonav("map", log, "--out", tmp_path / "file" / "out").complaint


@pytest.mark.parametrize(
    ("log_name", "name"),
    [("mit-csail.clf.gz", "mit-csail"), ("a.b.log", "a.b"), ("plain", "plain"), (".hidden", ".hidden"), ("x.gz", "x")],
)
def test_the_folder_has_the_name_of_the_log_without_its_endings(log_name: str, name: str) -> None:
    assert MapRequest(Path("somewhere") / log_name).name == name


def test_the_command_leaves_out_what_was_not_said() -> None:
    assert MapRequest(Path("a b.clf")).command() == "twonav map 'a b.clf' --seed 0"
    chosen = MapRequest(Path("a.clf"), MapChoices(max_range=12.5, keyframe_turn=30.0), laser_forward_m=-0.04, seed=3)
    assert chosen.command() == "twonav map a.clf --max-range 12.5 --keyframe-turn 30.0 --laser-forward -0.04 --seed 3"


# A real one


@pytest.mark.skipif(not SLAM.is_dir(), reason="the real logs are not here")
def test_the_beginning_of_a_real_log_is_mapped(twonav: Twonav, tmp_path: Path) -> None:
    with gzip.open(SLAM / "mit-csail.clf.gz", "rt") as packed:
        lines = [next(packed) for _ in range(203)]
    (tmp_path / "csail.clf").write_text("".join(lines))
    ended = twonav("map", tmp_path / "csail.clf", *SMALL, "--no-record", "--json", "--out", tmp_path / "a")
    report = ended.only_object()
    assert (report["scans"], report["keyframes_without_match"]) == (200, 0)
    stamps = {line.split()[-3] for line in lines if line.startswith("FLASER")}
    assert {f"{stamped.stamp_s:.6f}" for stamped in read_trajectory(tmp_path / "a" / "trajectory.txt")} <= stamps


def test_the_log_of_one_scan_is_a_warning(twonav: Twonav, tmp_path: Path) -> None:
    path = written(tmp_path / "one.clf", [flaser(FIRST_S, ranges_at(START, 181), Pose(1.0, 2.0, 0.5))])
    ended = twonav("map", path, *SMALL, "--no-record", "--out", tmp_path / "a")
    assert ended.code == 0
    assert "warning: there is one scan only" in ended.err


def test_a_folder_with_a_map_of_somebody_else_is_refused(twonav: Twonav, tmp_path: Path) -> None:
    path = written(tmp_path / "one.clf", [flaser(FIRST_S, ranges_at(START, 181), Pose(1.0, 2.0, 0.5))])
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "map.pgm").write_bytes(b"P5 1 1 255 x")
    ended = twonav("map", path, *SMALL, "--no-record", "--out", tmp_path / "a")
    assert ended.code == 1
    assert "something else" in ended.err
    assert (tmp_path / "a" / "map.pgm").read_bytes() == b"P5 1 1 255 x"


def test_another_log_of_the_same_name_does_not_replace_a_map(
    twonav: Twonav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path / "runs"))
    for folder, x_m in (("a", 1.0), ("b", 2.0)):
        (tmp_path / folder).mkdir()
        written(tmp_path / folder / "robot.clf", [flaser(FIRST_S, ranges_at(START, 181), Pose(x_m, 2.0, 0.5))])
    assert twonav("map", tmp_path / "a" / "robot.clf", *SMALL, "--no-record").code == 0
    ended = twonav("map", tmp_path / "b" / "robot.clf", *SMALL, "--no-record")
    assert ended.code == 1
    assert "another log of that name" in ended.err
    assert twonav("map", tmp_path / "a" / "robot.clf", *SMALL, "--no-record").code == 0


def test_what_was_stopped_does_not_replace_the_map_of_the_whole_log(tmp_path: Path) -> None:
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "card.json").write_text(json.dumps({"kind": "map", "log": "x", "metrics": {"outcome": "mapped"}}))
    assert _kept_apart(tmp_path / "a", "stopped") == tmp_path / "a-stopped"
    assert _kept_apart(tmp_path / "a", "mapped") == tmp_path / "a"
    assert _kept_apart(tmp_path / "b", "stopped") == tmp_path / "b"
