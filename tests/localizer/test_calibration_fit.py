"""Fitting a calibration: what was made wrong on purpose is found again."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from made_up_looks import DEPTH_M, WIDTH_M, belief_at, random_pose

from twonav_cli.belief import Belief
from twonav_cli.errors import TwonavError
from twonav_cli.localizer.calibration import Calibration
from twonav_cli.localizer.calibration_fit import LOST, fit_calibration, mean_misfit


def drawn(count: int, lost: float, seed: int) -> tuple[list[Belief], np.ndarray]:
    """Return beliefs and a true pose [N, 3] drawn from each, its even floor included."""
    rng = np.random.default_rng(seed)
    beliefs, poses = [], []
    for _ in range(count):
        one, two = random_pose(rng), random_pose(rng)
        sigma_m, sigma_rad = rng.uniform(0.05, 0.2), rng.uniform(0.02, 0.1)
        places = [(0.8, one.x_m, one.y_m, sigma_m), (0.2, two.x_m, two.y_m, sigma_m)]
        belief = belief_at(places, [(1.0, one.theta_rad, sigma_rad)], lost)
        pose = belief.sample(1, rng)[0]
        if rng.random() < lost:
            pose[:2] = rng.uniform(0.0, [WIDTH_M, DEPTH_M])
        if rng.random() < lost:
            pose[2] = rng.uniform(-np.pi, np.pi)
        beliefs.append(belief)
        poses.append(pose)
    return beliefs, np.array(poses)


def changed(belief: Belief, by_m: float, by_rad: float, lost: float) -> Belief:
    places, headings = belief.places.copy(), belief.headings.copy()
    places[:, 3] *= by_m
    headings[:, 2] *= by_rad
    return replace(belief, places=places, headings=headings, lost=lost)


def test_widths_and_floor_that_were_made_wrong_are_found_again() -> None:
    beliefs, poses = drawn(1500, 0.08, seed=0)
    wrong = [changed(belief, 0.5, 2.0, 0.0) for belief in beliefs]
    found = fit_calibration(wrong, poses)
    assert found.scale_m == pytest.approx(2.0, rel=0.06)
    assert found.scale_rad == pytest.approx(0.5, rel=0.06)
    assert found.lost == pytest.approx(0.08, abs=0.02)
    assert found.exponent == 1.0


def test_the_fit_is_likelier_than_its_neighbours_and_than_no_calibration() -> None:
    beliefs, poses = drawn(300, 0.1, seed=1)
    wrong = [changed(belief, 0.6, 0.6, 0.02) for belief in beliefs]
    found = fit_calibration(wrong, poses)

    def misfit(calibration: Calibration) -> float:
        return mean_misfit([calibration.applied(belief) for belief in wrong], poses)

    best = misfit(found)
    assert best < mean_misfit(wrong, poses) - 0.1
    for change in (
        {"lost": 1.3 * found.lost},
        {"lost": 0.7 * found.lost},
        {"scale_m": 1.1 * found.scale_m},
        {"scale_m": 0.9 * found.scale_m},
        {"scale_rad": 1.1 * found.scale_rad},
        {"scale_rad": 0.9 * found.scale_rad},
    ):
        assert best < misfit(replace(found, **change))


def test_the_exponent_is_taken_as_given() -> None:
    beliefs, poses = drawn(1500, 0.05, seed=2)
    sharpened = [replace(b, places=np.column_stack([b.places[:, 0] ** 2, b.places[:, 1:]])) for b in beliefs]
    for belief in sharpened:
        belief.places[:, 0] /= belief.places[:, 0].sum()
    flat, plain = fit_calibration(sharpened, poses, 0.5), fit_calibration(sharpened, poses)
    assert flat.exponent == 0.5

    def misfit(calibration: Calibration) -> float:
        return mean_misfit([calibration.applied(belief) for belief in sharpened], poses)

    assert misfit(flat) < misfit(plain) - 0.01


def test_without_a_single_far_error_there_is_still_a_floor() -> None:
    beliefs, poses = drawn(300, 0.0, seed=3)
    assert LOST[0] <= fit_calibration(beliefs, poses).lost < 0.01


def test_poses_of_single_precision_are_good_enough() -> None:
    beliefs, poses = drawn(100, 0.05, seed=4)
    assert fit_calibration(beliefs, poses.astype(np.float32)).scale_m == pytest.approx(
        fit_calibration(beliefs, poses).scale_m, rel=0.01
    )


def test_every_belief_needs_a_true_pose() -> None:
    beliefs, poses = drawn(3, 0.05, seed=5)
    with pytest.raises(TwonavError, match="3 beliefs and 2 true poses"):
        fit_calibration(beliefs, poses[:2])
    with pytest.raises(TwonavError, match="0 beliefs"):
        mean_misfit([], poses[:0])
