"""Poses in the plane."""

from __future__ import annotations

import math

import numpy as np
import pytest

from twonav_cli.geometry import Pose, compose, distance_m, points_in_map, relative_pose, wrap_angle, wrap_angles


@pytest.mark.parametrize(
    ("angle_rad", "wrapped_rad"),
    [(0.0, 0.0), (math.pi, -math.pi), (-math.pi, -math.pi), (2.5 * math.pi, 0.5 * math.pi), (-7.0, 2 * math.pi - 7.0)],
)
def test_a_wrapped_angle_lies_in_minus_pi_to_pi_without_pi(angle_rad: float, wrapped_rad: float) -> None:
    assert wrap_angle(angle_rad) == pytest.approx(wrapped_rad)
    assert wrap_angles(np.array([[angle_rad]]))[0, 0] == pytest.approx(wrapped_rad)


def test_a_step_forward_goes_where_the_robot_looks() -> None:
    assert compose(Pose(2.0, 3.0, math.pi / 2), Pose(1.0, 0.0, 0.0)) == pytest.approx((2.0, 4.0, math.pi / 2))


def test_a_step_to_the_left_goes_left_of_where_the_robot_looks() -> None:
    assert compose(Pose(2.0, 3.0, math.pi / 2), Pose(0.0, 1.0, 0.2)) == pytest.approx((1.0, 3.0, math.pi / 2 + 0.2))


def test_headings_are_wrapped_when_poses_are_composed() -> None:
    assert compose(Pose(0.0, 0.0, 3.0), Pose(0.0, 0.0, 1.0)).theta_rad == pytest.approx(4.0 - 2 * math.pi)


def test_the_relative_pose_undoes_composing() -> None:
    origin, target = Pose(-1.2, 0.7, 2.9), Pose(3.4, -5.0, -2.8)
    assert compose(origin, relative_pose(origin, target)) == pytest.approx(target)


def test_what_is_ahead_is_ahead_in_the_relative_pose() -> None:
    seen = relative_pose(Pose(1.0, 1.0, math.pi / 2), Pose(1.0, 3.0, math.pi))
    assert seen == pytest.approx((2.0, 0.0, math.pi / 2))


def test_points_move_into_the_map_as_poses_do() -> None:
    pose, points = Pose(1.0, -2.0, 0.6), np.array([[0.5, 0.0], [0.0, 0.3], [-0.1, -0.2]])
    expected = [compose(pose, Pose(x, y, 0.0))[:2] for x, y in points]
    assert points_in_map(pose, points) == pytest.approx(np.array(expected))


def test_the_distance_does_not_ask_for_headings() -> None:
    assert distance_m(Pose(1.0, 1.0, 0.3), Pose(4.0, 5.0, -2.0)) == pytest.approx(5.0)
