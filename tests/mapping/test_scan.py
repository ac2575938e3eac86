import math
from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.geometry import Pose
from twonav_cli.mapping.scan import RangeSensor, clear_points, points_of, usable

SENSOR = RangeSensor(np.array([-math.pi / 2, 0.0, math.pi / 2]), Pose(0.2, 0.1, 0.0), 8.0)
ORIGIN = Pose(0.0, 0.0, 0.0)


def test_only_a_positive_number_below_the_limit_is_of_something() -> None:
    ranges_m = np.array([np.nan, -1.0, 0.0, 1e-6, 7.99, 8.0, np.inf])
    assert usable(ranges_m, 8.0).tolist() == [False, False, False, True, True, False, False]


def test_ends_are_given_in_the_map_from_where_the_sensor_sits() -> None:
    points = points_of(SENSOR, np.array([1.0, 2.0, 3.0]), ORIGIN)
    assert points == pytest.approx(np.array([[0.2, -0.9], [2.2, 0.1], [0.2, 3.1]]))
    turned = points_of(SENSOR, np.array([1.0, 2.0, 3.0]), Pose(-5.0, 1.0, math.pi / 2))
    assert turned == pytest.approx(np.array([[-4.1, 1.2], [-5.1, 3.2], [-8.1, 1.2]]))


def test_a_sensor_that_looks_aside_turns_its_beams() -> None:
    aside = RangeSensor(np.array([0.0]), Pose(0.0, 0.0, math.pi / 2), 8.0)
    assert points_of(aside, np.array([2.0]), ORIGIN) == pytest.approx(np.array([[0.0, 2.0]]))


def test_beams_that_hit_nothing_are_left_out() -> None:
    assert points_of(SENSOR, np.array([np.nan, 2.0, 8.0]), ORIGIN) == pytest.approx(np.array([[2.2, 0.1]]))
    assert points_of(SENSOR, np.array([np.nan, np.inf, 8.0]), ORIGIN).shape == (0, 2)


def test_a_limit_shortens_the_range_and_never_makes_it_longer() -> None:
    ranges_m = np.array([1.0, 5.0, 9.0])
    assert len(points_of(SENSOR, ranges_m, ORIGIN, 4.0)) == 1
    assert len(points_of(SENSOR, ranges_m, ORIGIN, 20.0)) == 2


def test_a_beam_that_ends_beyond_the_limit_is_free_up_to_it() -> None:
    ranges_m = np.array([1.0, 5.0, np.nan])
    assert clear_points(SENSOR, ranges_m, 2.0) == pytest.approx(np.array([[2.0, 0.0]]))


def test_a_beam_that_hit_nothing_is_free_as_far_as_the_sensor_is_sure() -> None:
    lost = np.array([8.0, 1.0, 9.0])
    assert clear_points(SENSOR, lost, 20.0).shape == (0, 2)
    sure = replace(SENSOR, clear_m=7.5)
    assert clear_points(sure, lost, 20.0) == pytest.approx(np.array([[0.0, -7.5], [0.0, 7.5]]))
    assert clear_points(sure, lost, 4.0) == pytest.approx(np.array([[0.0, -4.0], [0.0, 4.0]]))
