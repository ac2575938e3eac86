"""Trajectories are found again as they were written, with the stamps of the log."""

from __future__ import annotations

from pathlib import Path

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.mapping.scan import StampedPose
from twonav_cli.mapping.trajectory import read_trajectory, write_trajectory

POSES = [
    StampedPose(1134864629.895182, Pose(0.0, -0.25, 3.141592)),
    StampedPose(1134864630.105179, Pose(12.3456789, 1e-7, -1.5)),
]


def test_a_trajectory_is_text_with_the_stamps_of_the_log(tmp_path: Path) -> None:
    path = write_trajectory(tmp_path / "new" / "trajectory.txt", POSES)
    assert path.read_text().splitlines() == [
        "1134864629.895182 0.000000 -0.250000 3.141592",
        "1134864630.105179 12.345679 0.000000 -1.500000",
    ]


def test_a_trajectory_is_read_as_it_was_written(tmp_path: Path) -> None:
    found = read_trajectory(write_trajectory(tmp_path / "trajectory.txt", POSES))
    assert [stamped.stamp_s for stamped in found] == [stamped.stamp_s for stamped in POSES]
    for read, written in zip(found, POSES, strict=True):
        assert read.pose == pytest.approx(written.pose, abs=1e-6)


def test_comments_and_empty_lines_are_passed_over(tmp_path: Path) -> None:
    path = tmp_path / "trajectory.txt"
    path.write_text("# stamp x y theta\n\n 1.5 2 3 0.5 \n")
    assert read_trajectory(path) == [StampedPose(1.5, Pose(2.0, 3.0, 0.5))]


@pytest.mark.parametrize("line", ["1 2 3", "1 2 3 4 5", "1 2 3 x", "1 2 nan 0", "inf 2 3 0"])
def test_a_line_that_is_no_stamped_pose_is_named(tmp_path: Path, line: str) -> None:
    path = tmp_path / "trajectory.txt"
    path.write_text(f"1 2 3 0\n{line}\n")
    with pytest.raises(TwonavError, match="line 2 is not `timestamp x y theta`"):
        read_trajectory(path)


def test_a_missing_trajectory_is_named(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="there is no trajectory at"):
        read_trajectory(tmp_path / "none.txt")


def test_a_trajectory_that_cannot_be_written_leaves_nothing(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(TwonavError, match="cannot write"):
        write_trajectory(tmp_path / "file" / "trajectory.txt", POSES)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
