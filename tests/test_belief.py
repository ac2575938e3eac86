"""A belief: its density is one, adds up to one, and its samples lie where it is dense."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.geometry import Pose, wrap_angles
from twonav_cli.grid import GridFrame

FRAME = GridFrame(0.0, 0.0, 0.5, 8, 12)
AREA_M2 = 24.0
PLACES = np.array([[0.7, 1.5, 1.0, 0.2], [0.3, 4.0, 3.0, 0.4]])
HEADINGS = np.array([[0.8, 3.1, 0.1], [0.2, 0.0, 0.3]])


def belief(lost: float = 0.1) -> Belief:
    return Belief(PLACES, HEADINGS, lost, AREA_M2, np.zeros(FRAME.shape, dtype=np.float32), FRAME)


def floor_points(step_m: float = 0.05) -> np.ndarray:
    """Return the middles [N, 2] of small squares that cover the floor."""
    xs, ys = np.arange(0.0, 6.0, step_m) + step_m / 2, np.arange(0.0, 4.0, step_m) + step_m / 2
    return np.stack([axis.ravel() for axis in np.meshgrid(xs, ys)], axis=1)


def circle(count: int = 720) -> np.ndarray:
    return np.linspace(-np.pi, np.pi, count, endpoint=False)


def test_its_pose_is_the_likeliest_place_with_the_likeliest_heading() -> None:
    assert belief().pose == pytest.approx(Pose(1.5, 1.0, 3.1))


def test_a_heading_beyond_half_a_turn_is_wrapped() -> None:
    over = Belief(PLACES, np.array([[1.0, 4.0, 0.1]]), 0.0, AREA_M2, np.zeros((8, 12), dtype=np.float32), FRAME)
    assert over.pose.theta_rad == pytest.approx(4.0 - 2 * np.pi)


def test_its_confidence_is_the_probability_of_the_likeliest_place() -> None:
    assert belief(0.1).confidence == pytest.approx(0.9 * 0.7)
    assert belief(1.0).confidence == 0.0


def test_the_density_of_places_adds_up_to_one_on_the_floor() -> None:
    assert belief().place_density(floor_points()).sum() * 0.05**2 == pytest.approx(1.0, abs=0.01)


def test_the_density_of_headings_adds_up_to_one_around_the_circle() -> None:
    assert belief().heading_density(circle()).sum() * 2 * np.pi / 720 == pytest.approx(1.0, abs=1e-6)


def test_the_density_in_the_middle_of_a_bell_by_hand() -> None:
    point, away = np.array([[1.5, 1.0]]), np.array([[1.7, 1.0]])
    peak = 0.9 * 0.7 / (2 * np.pi * 0.04)
    assert belief().place_density(point)[0] == pytest.approx(peak + 0.1 / AREA_M2, rel=1e-6)
    assert belief().place_density(away)[0] == pytest.approx(peak * np.exp(-0.5) + 0.1 / AREA_M2, rel=1e-6)


def test_a_heading_is_near_another_one_across_half_a_turn() -> None:
    density = belief(0.0).heading_density(np.array([3.1 - 0.2, 3.1 + 0.2 - 2 * np.pi]))
    assert density[0] == pytest.approx(density[1], rel=1e-6)
    assert density[0] > 0.4  # two deviations away


def test_far_from_everything_only_the_even_floor_is_left() -> None:
    far = np.array([[50.0, 50.0, 1.5]])
    assert belief(0.1).density(far)[0] == pytest.approx((0.1 / AREA_M2) * belief(0.1).heading_density(far[:, 2])[0])
    assert belief(0.1).place_density(far[:, :2])[0] == pytest.approx(0.1 / AREA_M2)
    assert belief(0.0).density(far)[0] == 0.0


def test_the_density_of_a_pose_is_that_of_its_place_times_that_of_its_heading() -> None:
    poses = np.array([[1.4, 1.1, 3.0], [4.0, 3.0, 0.1]])
    expected = belief().place_density(poses[:, :2]) * belief().heading_density(poses[:, 2])
    assert belief().density(poses) == pytest.approx(expected)


def test_samples_lie_in_the_bells_as_often_as_their_weights_say() -> None:
    drawn = belief().sample(20_000, np.random.default_rng(0))
    first = np.hypot(drawn[:, 0] - 1.5, drawn[:, 1] - 1.0) < 1.0
    assert first.mean() == pytest.approx(0.7, abs=0.02)
    assert drawn[first, :2].mean(axis=0) == pytest.approx([1.5, 1.0], abs=0.01)
    assert drawn[first, :2].std(axis=0) == pytest.approx([0.2, 0.2], rel=0.03)
    assert drawn[~first, :2].std(axis=0) == pytest.approx([0.4, 0.4], rel=0.05)


def test_sampled_headings_are_wrapped_and_as_wide_as_they_should_be() -> None:
    angles = belief().sample(20_000, np.random.default_rng(1))[:, 2]
    assert (np.abs(angles) <= np.pi).all()
    away = wrap_angles(angles - 3.1)
    near = np.abs(away) < 1.0
    assert near.mean() == pytest.approx(0.8, abs=0.02)
    assert away[near].std() == pytest.approx(0.1, rel=0.05)


def test_the_same_stream_gives_the_same_samples() -> None:
    one, two = (belief().sample(5, np.random.default_rng(3)) for _ in range(2))
    assert (one == two).all()
    assert not (one == belief().sample(5, np.random.default_rng(4))).any()
