import math

import numpy as np
import pytest

from twonav_cli.config import MappingConfig
from twonav_cli.geometry import Pose
from twonav_cli.mapping.motion_model import motion_covariance

STILL = MappingConfig(
    error_m_per_m=0.0, error_m_per_rad=0.0, error_rad_per_m=0.0, error_rad_per_rad=0.0, error_m=0.0, error_rad=0.0
)
CONFIG = MappingConfig(
    error_m_per_m=0.2, error_m_per_rad=0.1, error_rad_per_m=0.05, error_rad_per_rad=0.3, error_m=0.02, error_rad=0.01
)


def test_the_parts_add_up_by_hand() -> None:
    covariance = motion_covariance(CONFIG, Pose(0.6, 0.0, 0.5), 0.0)
    place_m2 = (0.2 * 0.6) ** 2 + (0.1 * 0.5) ** 2 + 0.02**2
    turn_rad2 = (0.05 * 0.6) ** 2 + (0.3 * 0.5) ** 2 + 0.01**2
    aside_m2 = turn_rad2 * 0.3**2
    assert covariance[0, 0] == pytest.approx(place_m2 / 0.05**2)
    assert covariance[1, 1] == pytest.approx((place_m2 + aside_m2) / 0.05**2)
    assert covariance[2, 2] == pytest.approx(turn_rad2, rel=1e-6)
    assert covariance[1, 2] == pytest.approx(turn_rad2 * 0.3 / 0.05)
    assert covariance[0, 2] == pytest.approx(0.0, abs=1e-12)


def test_a_turn_to_the_right_is_as_unsure_as_one_to_the_left() -> None:
    left, right = (motion_covariance(CONFIG, Pose(0.0, 0.0, turn), 0.3) for turn in (0.4, -0.4))
    assert left == pytest.approx(right)


@pytest.mark.parametrize(("motion", "theta_rad"), [(Pose(0.5, 0.0, 0.0), 1.1), (Pose(0.3, -0.4, 0.2), 2.5)])
def test_a_turn_that_is_wrong_carries_the_end_aside_in_the_maps_directions(motion: Pose, theta_rad: float) -> None:
    only_turn = MappingConfig(**{**STILL.__dict__, "error_rad": 0.02})
    covariance = motion_covariance(only_turn, motion, theta_rad)
    rng = np.random.default_rng(0)
    wrong = 0.02 * rng.standard_normal(200_000)
    middle = theta_rad + math.atan2(motion.y_m, motion.x_m)
    # An error that grows along the way carries the end as far aside as the whole of it on the second half.
    way = 0.5 * math.hypot(motion.x_m, motion.y_m) / 0.05
    ends = np.stack([way * np.cos(middle + wrong), way * np.sin(middle + wrong), wrong])
    assert covariance == pytest.approx(np.cov(ends), rel=0.05, abs=2e-4)


def test_the_covariance_turns_with_the_robot() -> None:
    one, other = (motion_covariance(CONFIG, Pose(0.6, 0.0, 0.1), theta) for theta in (0.0, math.pi / 2))
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    assert other == pytest.approx(quarter @ one @ quarter.T)


def test_a_robot_that_does_not_move_is_still_unsure_and_every_covariance_has_a_root() -> None:
    still = motion_covariance(MappingConfig(), Pose(0.0, 0.0, 0.0), 0.7)
    assert np.diag(still) == pytest.approx([1.0, 1.0, 0.01], rel=1e-3)
    for motion in (Pose(0.0, 0.0, 0.0), Pose(5.0, 1.0, 3.0), Pose(-0.5, 0.0, 0.0)):
        covariance = motion_covariance(CONFIG, motion, 1.0)
        assert np.linalg.cholesky(covariance) @ np.linalg.cholesky(covariance).T == pytest.approx(covariance)
