import math

import numpy as np
import pytest

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, Twist, compose, relative_pose
from twonav_cli.grid import GridFrame
from twonav_cli.motion import noisy_motion
from twonav_cli.sim2d.flat_body import FlatBody, fits, put
from twonav_cli.sim2d.flat_world import flat_world

FRAME = GridFrame(-1.0, 0.5, 0.05, 80, 80)
OPEN = np.zeros(FRAME.shape, dtype=bool)
QUIET = OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.0)


def body_at(pose: Pose, occupied: np.ndarray = OPEN, base: str = "omni", noise: OdometryNoise = QUIET) -> FlatBody:
    body = FlatBody(flat_world(occupied, FRAME, base), noise, np.random.default_rng(3))
    put(body.state, *pose)
    return body


def wall_at(x_m: float) -> np.ndarray:
    """Return a map with a wall from x = `x_m` on."""
    occupied = OPEN.copy()
    occupied[:, round((x_m + 1.0) / 0.05) :] = True
    return occupied


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_a_free_robot_moves_along_the_arc_of_its_twist(base: str) -> None:
    body = body_at(Pose(0.5, 2.0, 0.3), base=base)
    for _ in range(10):
        body.drive(Twist(0.4, 0.0, 0.5), 0.1)
    radius = 0.4 / 0.5
    arc = Pose(radius * math.sin(0.5), radius * (1 - math.cos(0.5)), 0.5)
    assert body.pose() == pytest.approx(compose(Pose(0.5, 2.0, 0.3), arc), abs=1e-4)
    assert body.twist() == Twist(0.4, 0.0, 0.5)
    assert body.state["time_s"][0] == pytest.approx(1.0)


def test_only_an_omnidirectional_base_moves_sideways() -> None:
    for base, left_m in (("omni", 0.04), ("differential", 0.0)):
        body = body_at(Pose(0.5, 2.0, 0.0), base=base)
        body.drive(Twist(0.0, 0.4, 0.0), 0.1)
        assert body.pose() == pytest.approx(Pose(0.5, 2.0 + left_m, 0.0))


def test_a_wall_stops_the_robot_before_its_front_enters_it_and_counts_the_periods() -> None:
    body = body_at(Pose(0.5, 2.0, 0.0), wall_at(1.2))
    for _ in range(20):
        body.drive(Twist(0.5, 0.0, 0.0), 0.1)
    assert 1.2 - 0.21 - 0.011 < body.pose().x_m <= 1.2 - 0.21 + 1e-9
    assert body.twist() == Twist(0.0, 0.0, 0.0)
    assert body.state["collisions"][0] == pytest.approx(11, abs=1)


def test_a_robot_fits_where_its_outline_does_and_not_a_centimetre_further() -> None:
    world = flat_world(wall_at(1.2), FRAME, "omni")
    assert fits(world, 1.2 - 0.215, 2.0, 0.0)
    assert not fits(world, 1.2 - 0.20, 2.0, 0.0)
    assert fits(world, 1.2 - 0.295, 2.0, math.pi)
    assert not fits(world, 1.2 - 0.28, 2.0, math.pi)


def test_odometry_without_noise_is_the_motion_and_being_put_is_none() -> None:
    body = body_at(Pose(0.5, 2.0, 1.0))
    body.drive(Twist(0.4, 0.1, 0.8), 0.3)
    assert body.odometry() == pytest.approx(relative_pose(Pose(0.5, 2.0, 1.0), body.pose()))
    put(body.state, 1.0, 2.0, -1.0)
    assert body.odometry() == pytest.approx(Pose(0.0, 0.0, 0.0))


def test_odometry_errs_as_the_formula_of_the_3d_simulator_does() -> None:
    noise = OdometryNoise()
    body, errors = body_at(Pose(0.5, 2.0, 1.0), noise=noise), np.random.default_rng(3)
    for _ in range(5):
        before = body.pose()
        body.drive(Twist(0.4, 0.1, 0.8), 0.3)
        expected = noisy_motion(relative_pose(before, body.pose()), noise, errors)
        assert body.odometry() == pytest.approx(expected, abs=1e-12)
