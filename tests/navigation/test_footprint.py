import math

import numpy as np
import pytest
from kinematic_body import KinematicBody

from twonav_cli.config import ROBOT_FOOTPRINT_M
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.distance import distances_m
from twonav_cli.navigation.footprint import (
    WindowGrid,
    distance_at,
    grown_outline,
    overlap,
    ring_points,
    robot_footprint,
    touches,
)

SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])


def test_an_outline_grows_by_the_margin_on_every_side():
    assert grown_outline(SQUARE, 0.1) == pytest.approx(np.array([(-0.1, -0.1), (1.1, -0.1), (1.1, 1.1), (-0.1, 1.1)]))
    assert grown_outline(SQUARE, -0.25) == pytest.approx(SQUARE * 0.5 + 0.25)


def test_ring_points_hold_the_corners_and_lie_close_together():
    ring = ring_points(np.array(ROBOT_FOOTPRINT_M), 0.01)
    gaps = np.linalg.norm(np.roll(ring, -1, axis=0) - ring, axis=1)
    assert gaps.max() <= 0.01 + 1e-12
    assert all(np.isclose(ring, corner).all(axis=1).any() for corner in ROBOT_FOOTPRINT_M)


def test_row_zero_is_the_top_and_outside_the_window_is_far():
    distance = np.array([[1.0, 2.0], [3.0, 4.0]])
    grid = WindowGrid(-1.0, 5.0, 0.5)
    assert distance_at(distance, grid, -0.9, 5.9) == 1.0
    assert distance_at(distance, grid, -0.1, 5.1) == 4.0
    assert distance_at(distance, grid, -1.1, 5.1) > 100
    assert distance_at(distance, grid, -0.1, 6.1) > 100


def test_a_footprint_touches_what_a_filled_one_touches():
    rng = np.random.default_rng(5)
    occupied = rng.random((40, 40)) < 0.01
    frame = GridFrame(0.0, 0.0, 0.05, 40, 40)
    distance, grid, robot = distances_m(occupied, 0.05), WindowGrid(0.0, 0.0, 0.05), robot_footprint()
    truth = KinematicBody(occupied, frame, Pose(0.0, 0.0, 0.0))
    both = {True: 0, False: 0}
    for _ in range(400):
        pose = Pose(*rng.uniform(0.5, 1.5, 2), rng.uniform(-math.pi, math.pi))
        where = (pose.x_m, pose.y_m, math.cos(pose.theta_rad), math.sin(pose.theta_rad))
        found = touches(distance, grid, robot, *where)
        deep = overlap(distance, grid, robot, *where)
        assert found or not truth.touches(pose)
        if found and deep > 3:
            assert truth.touches(pose)
        both[bool(found)] += 1
    assert min(both.values()) > 50
