import math

import numpy as np
import pytest

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose
from twonav_cli.motion import noisy_motion

SILENT = {"forward_per_m": 0.0, "sideways_per_m": 0.0, "turn_per_rad": 0.0, "turn_per_m": 0.0, "shift_per_rad": 0.0}


def errors_of(term: str, relative: Pose, draws: int = 2000) -> np.ndarray:
    """Return the errors [draws, 3] in x, y and heading when only one term is on, at 0.1."""
    noise = OdometryNoise(**{**SILENT, term: 0.1})
    rng = np.random.default_rng(1)
    return np.array([noisy_motion(relative, noise, rng) for _ in range(draws)]) - np.array(relative)


@pytest.mark.parametrize(
    ("term", "relative", "deviation"),
    [
        ("forward_per_m", Pose(1.0, 0.0, 0.0), (0.1, 0.0, 0.0)),
        ("forward_per_m", Pose(0.0, 1.0, 0.0), (0.0, 0.1, 0.0)),
        ("forward_per_m", Pose(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        ("sideways_per_m", Pose(1.0, 0.0, 0.0), (0.0, 0.1, 0.0)),
        ("sideways_per_m", Pose(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        ("turn_per_rad", Pose(0.0, 0.0, 1.0), (0.0, 0.0, 0.1)),
        ("turn_per_rad", Pose(1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        ("turn_per_m", Pose(1.0, 0.0, 0.0), (0.0, 0.0, 0.1)),
        ("turn_per_m", Pose(0.0, 0.0, 1.0), (0.0, 0.0, 0.0)),
        ("shift_per_rad", Pose(0.0, 0.0, -1.0), (0.1, 0.1, 0.0)),
        ("shift_per_rad", Pose(1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
    ],
)
def test_each_term_disturbs_what_it_names_and_nothing_else(term, relative, deviation):
    errors = errors_of(term, relative)
    assert errors.std(axis=0) == pytest.approx(deviation, rel=0.06, abs=1e-12)
    assert np.abs(errors.mean(axis=0)).max() < 0.01


def test_no_motion_is_reported_as_none():
    assert noisy_motion(Pose(0.0, 0.0, 0.0), OdometryNoise(), np.random.default_rng(0)) == Pose(0.0, 0.0, 0.0)


def test_without_noise_the_motion_itself_is_reported():
    relative = Pose(0.05, -0.02, 0.3)
    reported = noisy_motion(relative, OdometryNoise(**SILENT), np.random.default_rng(0))
    assert reported == pytest.approx(relative)


def test_a_metre_in_ten_periods_is_as_uncertain_as_a_metre_in_one():
    noise = OdometryNoise(**{**SILENT, "forward_per_m": 0.1})
    rng = np.random.default_rng(2)
    sums = [sum(noisy_motion(Pose(0.1, 0.0, 0.0), noise, rng).x_m for _ in range(10)) for _ in range(1000)]
    assert np.std(sums) == pytest.approx(0.1, rel=0.08)


def test_the_stream_stays_in_step_whatever_the_motion():
    a, b = np.random.default_rng(3), np.random.default_rng(3)
    noisy_motion(Pose(0.0, 0.0, 0.0), OdometryNoise(), a)
    noisy_motion(Pose(0.4, 0.0, math.pi / 2), OdometryNoise(), b)
    assert a.random() == b.random()
