import math

import numpy as np
import pytest

from twonav_cli.geometry import Pose, compose
from twonav_cli.mapping.cell_units import CellUnits, composed

UNITS = CellUnits(0.05, (-2.4, 0.1))


def test_a_pose_is_counted_from_the_corner() -> None:
    assert UNITS.of_pose(Pose(-2.4, 0.1, 0.5)) == pytest.approx([0.0, 0.0, 0.5])
    assert UNITS.of_pose(Pose(-2.375, 0.125, 0.0)) == pytest.approx([0.5, 0.5, 0.0])
    assert UNITS.of_pose(Pose(-3.4, -0.9, 0.0)) == pytest.approx([-20.0, -20.0, 0.0])


def test_a_pose_comes_back_as_it_was_with_its_heading_within_a_turn() -> None:
    assert UNITS.pose(UNITS.of_pose(Pose(1.23, -4.56, -0.7))) == pytest.approx(Pose(1.23, -4.56, -0.7))
    assert UNITS.pose(np.array([20.0, 40.0, 1.5 * math.pi])) == pytest.approx((-1.4, 2.1, -0.5 * math.pi))


def test_a_motion_does_not_know_the_corner() -> None:
    assert UNITS.of_motion(Pose(0.1, -0.2, 0.3)) == pytest.approx([2.0, -4.0, 0.3])


def test_many_poses_move_as_one_does() -> None:
    poses = [Pose(1.0, 2.0, 0.3), Pose(-4.0, 0.5, -2.0), Pose(0.0, 0.0, 3.0)]
    motion = Pose(0.7, -0.2, 0.1)
    ends = composed(np.array(poses), np.array(motion))
    for end, pose in zip(ends, poses, strict=True):
        assert end == pytest.approx(np.array(compose(pose, motion)))


def test_a_heading_is_not_wrapped_while_it_is_composed() -> None:
    assert composed(np.array([[0.0, 0.0, 3.0]]), np.array([1.0, 0.0, 1.0]))[0, 2] == pytest.approx(4.0)
