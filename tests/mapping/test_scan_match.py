import numpy as np
import pytest
from walls_seen import LOOSE, RULE, TRUE, Scene, by, corner, corridor, scene_of
from whole_map import WholeMap

from twonav_cli.config import MappingConfig
from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cells import TileStore
from twonav_cli.mapping.scan_match import (
    ALONG,
    FITTING,
    LIMIT,
    best_pose,
    climb,
    fit_at,
    likelihood_at,
    log_prior,
    matching_rule,
)

NOWHERE = np.zeros((1, 2))
CELL_M = 0.05


def slow_beams(scene: Scene, pose: FloatArray, reach: int) -> list[tuple[FloatArray, FloatArray, FloatArray] | None]:
    """Return end, normal and way to the nearest mean of every beam, map directions; None where none is in reach."""
    map_ = WholeMap(scene.store)
    cells = map_.wall_cells()
    means = np.array([map_.mean(*cell) for cell in cells])
    turn = np.array([[np.cos(pose[2]), -np.sin(pose[2])], [np.sin(pose[2]), np.cos(pose[2])]])
    beams: list[tuple[FloatArray, FloatArray, FloatArray] | None] = []
    for point, normal in zip(scene.points, scene.normals, strict=True):
        end = pose[:2] + turn @ point
        near = (np.abs(np.array(cells) - np.floor(end[::-1])) <= reach).all(axis=1)
        away = means[near] - end
        nearest = away[np.argmin(np.hypot(*away.T))] if len(away) else None
        beams.append(None if nearest is None else (turn @ point, turn @ normal, nearest))
    return beams


def metric(normal: FloatArray) -> FloatArray:
    """Return how a way [2] is measured: less along a surface than across it."""
    return ALONG * np.eye(2) + (1 - ALONG) * np.outer(normal, normal) if normal.any() else np.eye(2)


def slow_likelihood(scene: Scene, pose: FloatArray, sigma: float, reach: int) -> tuple[float, int]:
    total, fitting = 0.0, 0
    for beam in slow_beams(scene, pose, reach):
        squared = np.inf if beam is None else float(beam[2] @ metric(beam[1]) @ beam[2]) / sigma**2
        total -= LIMIT / 2 if beam is None else 0.5 * squared * LIMIT / (LIMIT + squared)
        fitting += squared < FITTING
    return total, fitting


def poses_around(count: int) -> FloatArray:
    return TRUE + np.random.default_rng(9).uniform(-1, 1, (count, 3)) * [1.5, 1.5, 0.05]


def partly_flat() -> Scene:
    """Return the corner with every fourth beam not on a surface."""
    scene = corner()
    scene.normals[::4] = 0.0
    return scene


@pytest.mark.parametrize("reach", [1, 3])
def test_the_likelihood_is_that_of_a_slow_search_for_the_nearest_means(reach: int) -> None:
    scene, sigma = partly_flat(), float(RULE[1])
    for pose in poses_around(4):
        expected, fitting = slow_likelihood(scene, pose, sigma, reach)
        value, matched = likelihood_at(scene.grid, scene.points, scene.normals, pose, sigma, reach, 1)
        assert value == pytest.approx(expected)
        assert matched == fitting
        assert fitting > 0


def test_a_mean_beyond_the_border_of_a_tile_is_seen_and_one_out_of_reach_is_not() -> None:
    store = TileStore(1)
    carve_scan(store, 0, np.array([31.6, -32.4, 0.0]), NOWHERE)
    ends = {(31.2, -32.9): 1, (32.8, -31.1): 1, (32.8, -32.4): 1, (31.6, -31.1): 1, (33.1, -32.4): 2, (31.6, -30.9): 2}
    for (x, y), reach in ends.items():
        for tried in (1, 3):
            squared = ((x - 31.6) ** 2 + (y + 32.4) ** 2) / RULE[1] ** 2
            value, _ = likelihood_at(store.map_of(0), NOWHERE, NOWHERE, np.array([x, y, 0.0]), RULE[1], tried, 1)
            expected = -0.5 * squared * LIMIT / (LIMIT + squared) if reach <= tried else -0.5 * LIMIT
            assert value == pytest.approx(expected, rel=1e-3)


def test_a_beam_costs_no_more_than_one_that_fits_nothing() -> None:
    scene = corner()
    for x, y in ((1000.0, 0.0), (-1e5, 1e5), (14.0, 0.0)):
        pose = np.array([x, y, 0.0])
        value, matched = likelihood_at(scene.grid, scene.points, scene.normals, pose, RULE[2], 1, 1)
        assert -0.5 * LIMIT * len(scene.points) <= value < -0.45 * LIMIT * len(scene.points)
        assert matched < 0.1 * len(scene.points)


def test_every_third_beam_is_what_a_stride_of_three_counts() -> None:
    scene = partly_flat()
    third = Scene(scene.store, scene.points[::3].copy(), scene.normals[::3].copy())
    value, matched = likelihood_at(scene.grid, scene.points, scene.normals, TRUE + 0.2, RULE[1], 3, 3)
    assert (value, matched) == likelihood_at(third.grid, third.points, third.normals, TRUE + 0.2, RULE[1], 3, 1)


def test_fit_and_likelihood_agree() -> None:
    scene, hessian, gradient = partly_flat(), np.zeros((3, 3)), np.zeros(3)
    for pose in poses_around(10):
        arguments = (scene.grid, scene.points, scene.normals, pose, RULE[2], 1, 1)
        assert fit_at(*arguments, hessian, gradient) == pytest.approx(likelihood_at(*arguments))


@pytest.mark.parametrize("surfaces", [True, False])
def test_the_gradient_is_the_derivative_of_the_likelihood(surfaces: bool) -> None:
    scene, hessian, gradient = corner(), np.zeros((3, 3)), np.zeros(3)
    normals = scene.normals if surfaces else np.zeros_like(scene.normals)
    step = np.array([1e-5, 1e-5, 1e-7])  # so small that no beam changes its nearest mean
    for pose in poses_around(6):
        fit_at(scene.grid, scene.points, normals, pose, RULE[1], 3, 1, hessian, gradient)
        for k in range(3):
            away = step * (np.arange(3) == k)
            ahead, _ = likelihood_at(scene.grid, scene.points, normals, pose + away, RULE[1], 3, 1)
            behind, _ = likelihood_at(scene.grid, scene.points, normals, pose - away, RULE[1], 3, 1)
            derivative = (ahead - behind) / (2 * step[k])
            # Gauss-Newton takes a surface not to turn with the scan: that changes a turn's pull a little.
            turns = surfaces and k == 2
            assert gradient[k] == pytest.approx(derivative, rel=0.05 if turns else 1e-4, abs=8.0 if turns else 1e-3)


def test_the_matrix_is_that_of_gauss_newton() -> None:
    scene, hessian, gradient = partly_flat(), np.zeros((3, 3)), np.zeros(3)
    pose, sigma = TRUE + by(0.4, -0.7, 0.02), float(RULE[1])
    expected, pull = np.zeros((3, 3)), np.zeros(3)
    for beam in slow_beams(scene, pose, 3):
        if beam is None:
            continue
        arm, normal, away = beam
        moves = np.array([[1.0, 0.0, -arm[1]], [0.0, 1.0, arm[0]]])  # of the end with the pose
        measure = metric(normal) / sigma**2
        weight = (LIMIT / (LIMIT + away @ measure @ away)) ** 2
        expected += weight * moves.T @ measure @ moves
        pull += weight * moves.T @ measure @ away
    fit_at(scene.grid, scene.points, scene.normals, pose, sigma, 3, 1, hessian, gradient)
    assert hessian == pytest.approx(expected)
    assert gradient == pytest.approx(pull)


def test_the_prior_is_a_gaussian_without_its_constant() -> None:
    information = np.array([[2.0, 0.5, 0.1], [0.5, 3.0, -0.2], [0.1, -0.2, 40.0]])
    away = np.array([0.3, -0.4, 0.05])
    assert log_prior(TRUE, TRUE, information) == 0.0
    assert log_prior(TRUE + away, TRUE, information) == pytest.approx(-0.5 * away @ information @ away)


def test_a_wall_within_a_cell_is_matched_to_two_millimetres() -> None:
    scene = corner()
    for start in (TRUE + by(0.9, -0.6, 0.02), TRUE + by(-0.8, 0.9, -0.03), TRUE + by(0.3, 0.4, 0.0)):
        pose, _, share, _ = best_pose(scene.grid, scene.points, scene.normals, start, start, LOOSE, RULE)
        assert share > 0.95
        assert CELL_M * np.hypot(*(pose[:2] - TRUE[:2])) < 0.002
        assert abs(pose[2] - TRUE[2]) < 1e-3


def test_a_start_that_is_far_off_is_first_climbed_from_with_a_wide_kernel() -> None:
    scene, start = corner(), TRUE + by(3.0, -2.0, -0.08)
    narrow, *_ = climb(scene.grid, scene.points, scene.normals, start, start, LOOSE, RULE[0], RULE[2], 1, 1)
    pose, _, share, _ = best_pose(scene.grid, scene.points, scene.normals, start, start, LOOSE, RULE)
    assert share > 0.95
    assert CELL_M * np.hypot(*(pose[:2] - TRUE[:2])) < 0.002
    assert CELL_M * np.hypot(*(narrow[:2] - TRUE[:2])) > 0.1


def test_odometry_that_is_sure_keeps_the_pose() -> None:
    scene, prior = corner(), TRUE + by(0.5, 0.5, 0.0)
    pose, _, _, precision = best_pose(scene.grid, scene.points, scene.normals, prior, prior, 1e6 * LOOSE, RULE)
    assert pose == pytest.approx(prior, abs=0.01)
    assert np.diag(precision) == pytest.approx(1e6 * np.diag(LOOSE), rel=0.01)


@pytest.mark.parametrize("along", [-2.0, -1.0, 0.0, 1.0, 2.0])
def test_a_corridor_leaves_the_way_along_it_to_odometry(along: float) -> None:
    scene = corridor()
    prior, information = TRUE + by(along, 0.6, 0.02), np.diag([0.5, 0.5, 100.0])
    pose, _, share, precision = best_pose(scene.grid, scene.points, scene.normals, prior, prior, information, RULE)
    assert share > 0.9
    assert pose[0] == pytest.approx(prior[0], abs=0.4)
    assert pose[1:] == pytest.approx(TRUE[1:], abs=0.02)
    assert precision[1, 1] > 4 * precision[0, 0]


def test_a_climb_ends_where_the_posterior_is_highest_wherever_it_begins() -> None:
    scene, sigma = corner(), float(RULE[1])
    prior, information = TRUE + by(0.4, -0.3, 0.02), np.diag([800.0, 800.0, 2e6])  # about as much as the scan knows

    def height(pose: FloatArray) -> float:
        value, _ = likelihood_at(scene.grid, scene.points, scene.normals, pose, sigma, 3, 1)
        return float(RULE[0] * value + log_prior(pose, prior, information))

    for start in (TRUE, prior, prior + by(0.2, 0.4, -0.01)):
        pose, _, share, _ = climb(
            scene.grid, scene.points, scene.normals, start, prior, information, RULE[0], sigma, 3, 1
        )
        assert share > 0.95
        assert np.abs(pose - TRUE).max() > 0.05
        for k, step in enumerate((0.05, 0.05, 1e-3)):
            for sign in (-1, 1):
                assert height(pose) > height(pose + sign * step * np.eye(3)[k])


def test_a_climb_never_ends_lower_than_it_began_and_tells_what_it_found() -> None:
    scene = partly_flat()
    for start in poses_around(20):
        prior = start + by(0.2, 0.1, 0.01)
        arguments = (RULE[0], RULE[1], 3, 1)
        pose, likelihood, share, precision = climb(
            scene.grid, scene.points, scene.normals, start, prior, LOOSE, *arguments
        )
        before, _ = likelihood_at(scene.grid, scene.points, scene.normals, start, RULE[1], 3, 1)
        value, matched = likelihood_at(scene.grid, scene.points, scene.normals, pose, RULE[1], 3, 1)
        assert RULE[0] * value + log_prior(pose, prior, LOOSE) >= RULE[0] * before + log_prior(start, prior, LOOSE)
        assert likelihood == pytest.approx(value)
        assert share == pytest.approx(matched / len(scene.points))
        assert np.linalg.eigvalsh(precision - LOOSE).min() > 0


def test_a_scan_without_a_beam_leaves_the_pose_to_odometry() -> None:
    scene = corner()
    none = np.zeros((0, 2))
    pose, likelihood, share, precision = best_pose(scene.grid, none, none, TRUE, TRUE, LOOSE, RULE)
    assert pose.tolist() == TRUE.tolist()
    assert (likelihood, share) == (0.0, 0.0)
    assert precision == pytest.approx(LOOSE)


def test_an_empty_map_fits_nothing_and_moves_nothing() -> None:
    scene = corner()
    empty = TileStore(1).map_of(0)
    pose, likelihood, share, _ = best_pose(empty, scene.points, scene.normals, TRUE, TRUE, LOOSE, RULE)
    assert pose.tolist() == TRUE.tolist()
    assert likelihood == pytest.approx(-0.5 * LIMIT * len(scene.points))
    assert share == 0.0


def test_sixty_beams_of_something_new_do_not_push_a_match_away() -> None:
    scene, rng = corner(), np.random.default_rng(3)
    new = rng.uniform(-25, 25, (60, 2))
    points = np.concatenate([scene.points, new])
    normals = np.concatenate([scene.normals, np.zeros((60, 2))])
    start = TRUE + by(0.8, 0.5, -0.02)
    pose, _, share, _ = best_pose(scene.grid, points, normals, start, start, LOOSE, RULE)
    assert CELL_M * np.hypot(*(pose[:2] - TRUE[:2])) < 0.005
    assert share < 0.75


def test_the_rule_is_in_cells() -> None:
    rule = matching_rule(MappingConfig(resolution_m=0.1, wide_sigma_m=0.3, sigma_m=0.05, evidence=7.0))
    assert rule == pytest.approx([7.0, 3.0, 0.5])


def test_a_scene_of_one_point_is_where_it_was_put() -> None:
    scene = scene_of([np.array([[31.37, -0.63], [32.9, -0.63]])])
    assert WholeMap(scene.store).mean(-1, 31) == pytest.approx((31.37, -0.63), abs=1e-4)
