"""What beliefs promise and what is true, where both are known because the truth is drawn from the belief."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.calibration import FAR_M, area_under_roc, calibration_report
from twonav_cli.grid import GridFrame

FRAME = GridFrame(0.0, 0.0, 1.0, 9, 14)
WIDTH_M, DEPTH_M = 14.0, 9.0


def beliefs_of(count: int, rng: np.random.Generator, lost: float = 0.1) -> list[Belief]:
    """Return beliefs in one or two places, of different widths."""
    found = []
    for index in range(count):
        (x, y), (u, v) = rng.uniform(1.0, [WIDTH_M - 1, DEPTH_M - 1], size=(2, 2))
        sigma = rng.uniform(0.05, 0.3)
        places = [(0.6, x, y, sigma), (0.4, u, v, sigma)] if index % 3 == 0 else [(1.0, x, y, sigma)]
        headings = [(1.0, rng.uniform(-np.pi, np.pi), rng.uniform(0.02, 0.2))]
        grid = np.zeros(FRAME.shape, dtype=np.float32)
        found.append(Belief(np.array(places), np.array(headings), lost, WIDTH_M * DEPTH_M, grid, FRAME))
    return found


def truths_of(beliefs: list[Belief], rng: np.random.Generator) -> np.ndarray:
    """Return a pose [N, 3] drawn from each belief, its even floor included, place and heading each for itself."""
    drawn = np.concatenate([belief.sample(1, rng) for belief in beliefs])
    for row, belief in zip(drawn, beliefs, strict=True):
        if rng.random() < belief.lost:
            row[:2] = rng.uniform(0.0, [WIDTH_M, DEPTH_M])
        if rng.random() < belief.lost:
            row[2] = rng.uniform(-np.pi, np.pi)
    return drawn


def test_when_the_truth_is_drawn_from_the_belief_promises_are_kept() -> None:
    rng = np.random.default_rng(0)
    beliefs = beliefs_of(600, rng, lost=0.05)
    report = calibration_report(beliefs, truths_of(beliefs, rng), rng)
    assert report["n"] == 600
    assert report["places_50"] == pytest.approx(0.5, abs=0.06)
    assert report["places_90"] == pytest.approx(0.9, abs=0.04)
    assert report["headings_50"] == pytest.approx(0.5, abs=0.06)
    assert report["headings_90"] == pytest.approx(0.9, abs=0.04)


def test_beliefs_that_are_too_narrow_keep_less_than_they_promise() -> None:
    rng = np.random.default_rng(1)
    beliefs = beliefs_of(300, rng, lost=0.02)
    truths = truths_of(beliefs, rng)
    for belief in beliefs:
        belief.places[:, 3] *= 0.5
    report = calibration_report(beliefs, truths, rng)
    assert report["places_90"] < 0.75
    assert report["headings_90"] > 0.85


def test_a_truth_in_the_middle_of_the_bell_is_inside_and_one_far_away_is_not() -> None:
    rng = np.random.default_rng(2)
    belief = beliefs_of(2, rng, lost=0.05)[1]
    middle = np.array([[*belief.places[0, 1:3], belief.headings[0, 1]]])
    inside = calibration_report([belief], middle, rng)
    away = middle + np.array([0.0, 4.0 * belief.places[0, 3], 0.0])
    outside = calibration_report([belief], away, rng)
    assert (inside["places_50"], inside["places_90"], inside["headings_50"]) == (1.0, 1.0, 1.0)
    assert (outside["places_50"], outside["places_90"], outside["headings_50"]) == (0.0, 0.0, 1.0)


def test_errors_above_half_a_metre_are_far() -> None:
    rng = np.random.default_rng(3)
    beliefs = [belief for belief in beliefs_of(30, rng) if len(belief.places) == 1]
    truths = np.array([belief.pose for belief in beliefs])
    truths[:5, 0] += FAR_M + 0.01
    truths[5:9, 0] += FAR_M - 0.01
    assert calibration_report(beliefs, truths, rng)["far"] == pytest.approx(5 / len(beliefs))


def test_confidence_warns_of_far_errors_when_it_is_low_there() -> None:
    rng = np.random.default_rng(4)
    beliefs = beliefs_of(60, rng)  # every third one names two places, and is less confident
    truths = np.array([belief.pose for belief in beliefs])
    assert calibration_report(beliefs, truths, rng)["auroc"] is None
    truths[::3, 0] += 2.0
    assert calibration_report(beliefs, truths, rng)["auroc"] == 1.0
    truths[::3, 0] -= 2.0
    truths[1::3, 0] += 2.0
    assert calibration_report(beliefs, truths, rng)["auroc"] < 0.5


def test_the_area_under_the_curve_by_hand() -> None:
    scores = np.array([0.1, 0.4, 0.35, 0.8])
    assert area_under_roc(scores, np.array([False, False, True, True])) == pytest.approx(0.75)
    assert area_under_roc(np.array([1.0, 1.0, 1.0]), np.array([True, False, False])) == pytest.approx(0.5)
    assert area_under_roc(np.array([2.0, 1.0, 1.0]), np.array([True, True, False])) == pytest.approx(0.75)
    assert area_under_roc(scores, np.zeros(4, dtype=bool)) is None


def test_the_area_is_the_share_of_pairs_in_the_right_order() -> None:
    rng = np.random.default_rng(5)
    scores, positive = rng.integers(0, 8, size=60).astype(float), rng.random(60) < 0.3
    pairs = [(p > n) + 0.5 * (p == n) for p in scores[positive] for n in scores[~positive]]
    assert area_under_roc(scores, positive) == pytest.approx(np.mean(pairs))


def test_the_misfit_is_the_mean_of_minus_log_density() -> None:
    rng = np.random.default_rng(6)
    beliefs = beliefs_of(4, rng)
    truths = truths_of(beliefs, rng)
    expected = -np.mean([np.log(belief.density(pose[None])[0]) for belief, pose in zip(beliefs, truths, strict=True)])
    assert calibration_report(beliefs, truths, rng)["misfit"] == pytest.approx(expected)


def test_every_belief_needs_a_true_pose() -> None:
    rng = np.random.default_rng(7)
    with pytest.raises(TwonavError, match="3 beliefs and 2 true poses"):
        calibration_report(beliefs_of(3, rng), np.zeros((2, 3)), rng)
    with pytest.raises(TwonavError, match="0 beliefs"):
        calibration_report([], np.zeros((0, 3)), rng)
