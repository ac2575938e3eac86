import numpy as np
import pytest
from conftest import MakeScene

from twonav_cli.geometry import Pose, Twist
from twonav_cli.scene.laser import BEAM_ANGLES_RAD, RangeFinder
from twonav_cli.scene.world import World

LASER_X_M = 0.02


def test_a_scan_measures_the_walls_from_the_laser(make_scene: MakeScene) -> None:
    world = World(make_scene())
    world.place(Pose(0.5, 0.25, 0.0))
    ranges_m = RangeFinder(world).scan()
    x_m, y_m = 0.5 + LASER_X_M, 0.25
    with np.errstate(divide="ignore"):
        to_right = (2.0 - x_m) / np.cos(BEAM_ANGLES_RAD)
        to_side = np.where(BEAM_ANGLES_RAD > 0, 1.5 - y_m, 1.5 + y_m) / np.abs(np.sin(BEAM_ANGLES_RAD))
    assert ranges_m.shape == (180,)
    assert ranges_m == pytest.approx(np.minimum(to_right, to_side), abs=1e-6)


def test_the_first_beam_points_right_and_the_last_left(make_scene: MakeScene) -> None:
    world = World(make_scene())
    world.place(Pose(0.0, 1.0, 0.0))
    ranges_m = RangeFinder(world).scan()
    assert (ranges_m[0], ranges_m[-1]) == pytest.approx((2.5, 0.5))


def test_nothing_within_reach_is_the_greatest_range(make_scene: MakeScene) -> None:
    world = World(make_scene())
    world.place(Pose(0.0, 0.0, 0.0))
    assert RangeFinder(world, max_m=0.5).scan() == pytest.approx(np.full(180, 0.5))


def test_only_what_is_at_the_height_of_the_laser_is_seen(make_scene: MakeScene) -> None:
    low = '<geom type="box" size="0.1 0.1 0.12" pos="1 0 0.12"/>'
    high = '<geom type="box" size="0.1 0.1 0.2" pos="0 1 0.2"/>'
    world = World(make_scene(more=low + high))
    world.place(Pose(-LASER_X_M, 0.0, 0.0))
    ranges_m = RangeFinder(world).scan()
    assert ranges_m[90] == pytest.approx(2.0, abs=1e-3)
    assert ranges_m[-1] == pytest.approx(0.9, abs=1e-3)


def test_a_scan_follows_the_robot_while_it_drives(make_scene: MakeScene) -> None:
    world = World(make_scene())
    world.place(Pose(0.0, 0.0, 0.0))
    finder = RangeFinder(world)
    world.drive(Twist(0.5, 0.0, 0.0), 1.0)
    ahead_m = 2.0 - LASER_X_M - world.pose().x_m
    assert finder.scan()[89:91] * np.cos(BEAM_ANGLES_RAD[89:91]) == pytest.approx([ahead_m] * 2, abs=1e-9)
