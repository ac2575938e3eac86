"""Clusters of particles: each is found whole, with its own mean."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.localizer.particle_clusters import BIN_M, clusters_of


def cloud(x_m: float, y_m: float, theta_rad: float, count: int, seed: int = 0) -> np.ndarray:
    drawn = np.random.default_rng(seed).normal(size=(count, 3)) * [0.03, 0.03, 0.02]
    return np.asarray(drawn + np.array([x_m, y_m, theta_rad]))


def test_one_cloud_is_one_cluster_with_its_mean_and_spread() -> None:
    particles = cloud(3.0, 2.0, 0.5, 2000)
    (only,) = clusters_of(particles, np.full(2000, 0.9 / 2000))
    assert only.weight == pytest.approx(0.9)
    assert only.pose == pytest.approx((3.0, 2.0, 0.5), abs=0.005)
    assert only.spread_m == pytest.approx(0.03 * np.sqrt(2), rel=0.05)
    assert only.spread_rad == pytest.approx(0.02, rel=0.05)


def test_a_cloud_on_the_corner_of_four_bins_is_found_whole() -> None:
    corner, rival = cloud(1.0 + BIN_M, 1.0 + BIN_M, 0.0, 700), cloud(6.0, 6.0, 0.0, 300)
    particles = np.concatenate([[[1.0, 1.0, 0.0]], corner, rival])  # the first one sets where the bins begin
    best, second, *_ = clusters_of(particles, np.full(1001, 1 / 1001))
    assert best.weight == pytest.approx(0.7, abs=0.01)
    assert second.weight == pytest.approx(0.3, abs=0.01)


def test_a_cloud_that_looks_backwards_is_not_cut_at_half_a_turn() -> None:
    particles = cloud(3.0, 2.0, np.pi, 500)
    particles[:, 2] = (particles[:, 2] + np.pi) % (2 * np.pi) - np.pi
    (only,) = clusters_of(particles, np.full(500, 1 / 500))
    assert only.weight == pytest.approx(1.0)
    assert abs(abs(only.pose.theta_rad) - np.pi) < 0.01


def test_two_headings_at_one_place_are_two_clusters() -> None:
    particles = np.concatenate([cloud(3.0, 2.0, 0.0, 600), cloud(3.0, 2.0, 2.0, 400)])
    best, second = clusters_of(particles, np.full(1000, 1 / 1000))
    assert best.pose.theta_rad == pytest.approx(0.0, abs=0.01)
    assert second.pose.theta_rad == pytest.approx(2.0, abs=0.01)
    assert (best.weight, second.weight) == pytest.approx((0.6, 0.4))


def test_weights_and_not_numbers_of_particles_decide() -> None:
    particles = np.concatenate([cloud(1.0, 1.0, 0.0, 900), cloud(6.0, 6.0, 0.0, 100)])
    weights = np.concatenate([np.full(900, 0.2 / 900), np.full(100, 0.8 / 100)])
    best, second = clusters_of(particles, weights)
    assert best.pose.x_m == pytest.approx(6.0, abs=0.02)
    assert (best.weight, second.weight) == pytest.approx((0.8, 0.2))


def test_what_weighs_next_to_nothing_is_no_cluster() -> None:
    particles = np.concatenate([cloud(1.0, 1.0, 0.0, 900), cloud(6.0, 6.0, 0.0, 5)])
    assert len(clusters_of(particles, np.full(905, 1 / 905))) == 1


def test_particles_strewn_everywhere_still_have_a_heaviest_cluster() -> None:
    particles = np.random.default_rng(0).uniform(-3, 3, size=(300, 3)) * [3.0, 3.0, 1.0]
    clusters = clusters_of(particles, np.full(300, 1 / 300))
    weights = [cluster.weight for cluster in clusters]
    assert 1 <= len(clusters) <= 6
    assert weights == sorted(weights, reverse=True)
