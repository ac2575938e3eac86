"""The simulated robot as the cell driver sees it."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, Twist
from twonav_cli.scene.catalog import read_scene
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.robot_body import RobotBody
from twonav_cli.scene.world import World

NO_NOISE = OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.0)
FREE = Pose(2.9, 3.3, -math.pi / 2)
"""A start of the kitchen, looking down, with more than half a metre of floor ahead."""

FORWARD = Twist(0.4, 0.0, 0.0)


@pytest.fixture(scope="module")
def world() -> Iterator[World]:
    return World(read_scene("kitchen"))


def body_in(world: World, noise: OdometryNoise = NO_NOISE, seed: int = 0) -> RobotBody:
    world.place(FREE)
    body = RobotBody(world, RangeFinder(world), noise, np.random.default_rng(seed))
    body.settle()
    return body


def test_odometry_reports_motion_in_the_robots_own_frame(world: World) -> None:
    body = body_in(world)
    body.drive(FORWARD, 1.0)
    moved = body.odometry()
    assert moved.x_m == pytest.approx(FREE.y_m - world.pose().y_m, abs=1e-6)
    assert moved.x_m == pytest.approx(0.4, abs=0.05)
    assert (moved.y_m, moved.theta_rad) == pytest.approx((0.0, 0.0), abs=0.01)


def test_odometry_reports_motion_since_the_last_call_only(world: World) -> None:
    body = body_in(world)
    body.drive(FORWARD, 0.5)
    first = body.odometry()
    assert body.odometry() == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    body.drive(FORWARD, 0.5)
    assert first.x_m + body.odometry().x_m == pytest.approx(FREE.y_m - world.pose().y_m, abs=1e-6)


def test_being_carried_is_no_motion_of_the_wheels(world: World) -> None:
    body = body_in(world)
    world.place(Pose(5.7, 4.1, 0.0))
    body.settle()
    assert body.odometry() == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


def test_odometry_is_noisy_by_a_few_percent_and_the_same_for_the_same_seed(world: World) -> None:
    reports = []
    for seed in (1, 1, 2):
        body = body_in(world, OdometryNoise(), seed)
        body.drive(FORWARD, 1.0)
        reports.append(body.odometry())
    assert reports[0] == reports[1]
    assert reports[0] != reports[2]
    assert reports[0].x_m == pytest.approx(FREE.y_m - world.pose().y_m, rel=0.15)


def test_noise_never_moves_the_robot_itself(world: World) -> None:
    ends = []
    for noise in (NO_NOISE, OdometryNoise()):
        body = body_in(world, noise)
        body.drive(FORWARD, 0.5)
        body.odometry()
        ends.append(world.pose())
    assert ends[0] == ends[1]


def test_the_scan_and_the_velocity_are_those_of_the_world(world: World) -> None:
    body = body_in(world)
    body.drive(FORWARD, 1.0)
    assert body.twist().forward_mps == pytest.approx(0.4, abs=0.05)
    assert np.array_equal(body.scan(), RangeFinder(world).scan())


def test_driving_freely_touches_nothing(world: World) -> None:
    body = body_in(world)
    body.drive(FORWARD, 0.2)
    assert body.touched == []
    assert body.collisions == 0


def test_every_period_against_a_wall_is_a_collision_until_the_robot_is_put_elsewhere(world: World) -> None:
    body = body_in(world)
    world.place(Pose(0.5, 0.5, math.pi))  # the left wall is half a metre ahead
    body.settle()
    for _ in range(20):
        body.drive(Twist(0.5, 0.0, 0.0), 0.2)
    hit, names = body.collisions, body.touched
    assert names
    assert hit >= 1
    world.place(FREE)
    body.settle()
    assert body.touched == []
    body.drive(FORWARD, 0.2)
    assert body.collisions == hit
