import numpy as np
import pytest
from walls_seen import LOOSE, RULE, TRUE, Scene, by, corner

from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.cells import TileStore
from twonav_cli.mapping.proposal import (
    COLUMNS,
    CUBE,
    LOG_WEIGHT,
    POSE,
    SAMPLE_LOG_WEIGHTS,
    SHARE,
    SPREAD,
    gaussian_around,
    propose,
)
from twonav_cli.mapping.scan_match import best_pose, likelihood_at, log_prior
from twonav_cli.mapping.three_by_three import root_of_inverse

PRIOR = TRUE + by(0.8, -0.5, 0.03)
COVARIANCE = np.linalg.inv(LOOSE)


def proposed(
    scene: Scene, *, prior: FloatArray = PRIOR, covariance: FloatArray = COVARIANCE, least: float = 0.3,
    draw: bool = True, draws: FloatArray | None = None,
) -> FloatArray:  # fmt: skip
    """Return [P, COLUMNS] of particles that all believe the same, with draws [P, 3] of their own."""
    store, out = scene.store, np.zeros((len(scene.store.tables), COLUMNS))
    alike = (len(out), 1, 1)
    if draws is None:
        draws = np.random.default_rng(0).standard_normal((len(out), 3))
    priors = np.tile(prior, (len(out), 1))
    propose(
        (store.cells, store.walls, store.tables, store.first_row, store.first_col), scene.points, scene.normals,
        priors, priors, np.tile(np.linalg.inv(covariance), alike), np.tile(np.linalg.cholesky(covariance), alike),
        draws, RULE, least, draw, out,
    )  # fmt: skip
    return out


def log_posterior(scene: Scene, pose: FloatArray) -> float:
    value, _ = likelihood_at(scene.grid, scene.points, scene.normals, pose, RULE[2], 1, 1)
    return float(RULE[0] * value + log_prior(pose, PRIOR, LOOSE))


def maximum(scene: Scene) -> tuple[FloatArray, FloatArray]:
    """Return the pose [3] of the maximum and the axes [3, 3] of the posterior there."""
    pose, _, _, precision = best_pose(scene.grid, scene.points, scene.normals, PRIOR, PRIOR, LOOSE, RULE)
    return pose, root_of_inverse(precision)


def integrated(scene: Scene) -> tuple[FloatArray, FloatArray, float]:
    """Return mean, covariance and log integral of the posterior, from a fine grid of poses about its maximum."""
    pose, axes = maximum(scene)
    line = np.linspace(-4.5, 4.5, 19)
    offsets = np.stack(np.meshgrid(line, line, line), axis=-1).reshape(-1, 3) @ axes.T
    values = np.array([log_posterior(scene, pose + offset) for offset in offsets])
    weights = np.exp(values - values.max())
    mean = weights @ offsets / weights.sum()
    away = offsets - mean
    covariance = (weights[:, None] * away).T @ away / weights.sum()
    volume = (line[1] - line[0]) ** 3 * abs(np.linalg.det(axes))
    return pose + mean, covariance, float(values.max() + np.log(weights.sum() * volume))


@pytest.fixture(scope="module")
def scene() -> Scene:
    return corner()


def test_the_samples_are_the_middle_the_faces_and_the_corners_of_a_cube() -> None:
    assert CUBE.shape == (15, 3)
    assert len(np.unique(CUBE, axis=0)) == 15
    assert np.sort(np.abs(CUBE).sum(axis=1)).tolist() == [0.0] + [1.0] * 6 + [3.0] * 8
    assert not CUBE.sum(axis=0).any()


def test_the_samples_integrate_a_normal_density_times_a_quintic_polynomial_exactly() -> None:
    at = SPREAD * CUBE
    weights = np.exp(SAMPLE_LOG_WEIGHTS - 0.5 * (at**2).sum(axis=1))
    x, y, t = at.T
    assert weights.sum() == pytest.approx(1.0)
    assert [weights @ (x * x), weights @ x**4, weights @ (y * y * t * t)] == pytest.approx([1.0, 3.0, 1.0])
    assert [weights @ (x * y), weights @ (x**3 * t * t), weights @ t**5] == pytest.approx([0.0, 0.0, 0.0], abs=1e-12)


def test_the_gaussian_lies_where_the_posterior_does(scene: Scene) -> None:
    pose, axes = maximum(scene)
    mean, spread, _ = gaussian_around(scene.grid, scene.points, scene.normals, pose, axes, PRIOR, LOOSE, RULE)
    true_mean, true_covariance, _ = integrated(scene)
    whiten = np.linalg.inv(np.linalg.cholesky(true_covariance))
    assert np.abs(whiten @ (mean - true_mean)).max() < 0.35  # a sample counts every third beam only
    variances = np.linalg.eigvalsh(whiten @ spread @ spread.T @ whiten.T)
    assert variances == pytest.approx(np.ones(3), abs=0.15)


def test_the_mean_goes_to_where_the_samples_are_likelier(scene: Scene) -> None:
    pose, axes = maximum(scene)
    off = pose + axes @ [0.8, 0.0, -0.8]
    mean, _, _ = gaussian_around(scene.grid, scene.points, scene.normals, off, axes, PRIOR, LOOSE, RULE)
    back = np.linalg.solve(axes, mean - off)
    assert back[0] < -0.4
    assert back[2] > 0.4
    assert abs(back[1]) < 0.35


def test_the_weight_grows_as_the_integral_of_the_posterior_does(scene: Scene) -> None:
    weights, integrals = [], []
    sides = 1.0 - 2.0 * (np.arange(len(scene.points)) % 2)[:, None]
    for apart in (0.0, 0.2, 0.4):  # every other beam ends that far before the wall, the others behind it
        seen = Scene(scene.store, scene.points + apart * sides * scene.normals, scene.normals)
        pose, axes = maximum(seen)
        arguments = (seen.grid, seen.points, seen.normals, pose, axes, PRIOR, LOOSE, RULE)
        weights.append(gaussian_around(*arguments)[2])
        integrals.append(integrated(seen)[2])
    assert integrals[0] - integrals[2] > 10
    # Fewer beams leave more room about the maximum.
    seen = Scene(scene.store, scene.points[::4].copy(), scene.normals[::4].copy())
    pose, axes = maximum(seen)
    arguments = (seen.grid, seen.points, seen.normals, pose, axes, PRIOR, LOOSE, RULE)
    weight = gaussian_around(*arguments)[2]
    assert weight - weights[0] == pytest.approx(integrated(seen)[2] - integrals[0], abs=2.0)
    assert weight - weights[0] > 1
    assert np.array(weights) - weights[0] == pytest.approx(np.array(integrals) - integrals[0], abs=1.0)


def test_draws_scatter_as_the_gaussian_says() -> None:
    many = corner(500)
    pose, axes = maximum(many)
    mean, spread, weight = gaussian_around(many.grid, many.points, many.normals, pose, axes, PRIOR, LOOSE, RULE)
    out = proposed(many)
    whitened = np.linalg.solve(spread, (out[:, POSE] - mean).T)
    assert np.abs(whitened.mean(axis=1)).max() < 0.2
    assert np.cov(whitened) == pytest.approx(np.eye(3), abs=0.25)
    assert out[:, LOG_WEIGHT] == pytest.approx(weight)
    assert (out[:, SHARE] > 0.95).all()


def test_every_particle_uses_its_own_draw_and_its_own_map() -> None:
    scene = corner(3)
    scene.store.tables[2] = TileStore(1).tables[0]  # the third has seen nothing
    out = proposed(scene, draws=np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))
    pose, axes = maximum(scene)
    mean, spread, _ = gaussian_around(scene.grid, scene.points, scene.normals, pose, axes, PRIOR, LOOSE, RULE)
    assert out[:, POSE] == pytest.approx(np.stack([mean, mean + spread[:, 0], PRIOR]), abs=1e-9)
    assert (out[:, SHARE] >= 0).tolist() == [True, True, False]


def test_the_maximum_is_taken_as_it_is() -> None:
    scene = corner(2)
    out = proposed(scene, draw=False)
    pose, likelihood, share, _ = best_pose(scene.grid, scene.points, scene.normals, PRIOR, PRIOR, LOOSE, RULE)
    assert out[:, POSE] == pytest.approx(np.stack([pose, pose]))
    assert out[:, LOG_WEIGHT] == pytest.approx(RULE[0] * likelihood + log_prior(pose, PRIOR, LOOSE))
    assert out[:, SHARE] == pytest.approx(share)


@pytest.mark.parametrize("draw", [True, False])
def test_a_scan_that_does_not_fit_leaves_the_pose_to_odometry(draw: bool) -> None:
    scene = corner(400)
    lost = TRUE + by(300.0, 0.0, 0.0)
    out = proposed(scene, prior=lost, draw=draw)
    whitened = np.linalg.solve(np.linalg.cholesky(COVARIANCE), (out[:, POSE] - lost).T)
    assert (out[:, SHARE] == -1).all()
    assert np.abs(whitened.mean(axis=1)).max() < 0.2
    assert np.cov(whitened) == pytest.approx(np.eye(3), abs=0.25)
    assert np.ptp(out[:, LOG_WEIGHT]) < 1e-9


def test_how_many_beams_must_fit_is_asked_for() -> None:
    scene, rng = corner(1), np.random.default_rng(3)
    half = len(scene.points)
    new = rng.uniform(-25, 25, (half, 2))
    both = Scene(scene.store, np.concatenate([scene.points, new]), np.concatenate([scene.normals, np.zeros((half, 2))]))
    assert proposed(both, least=0.4)[0, SHARE] == pytest.approx(0.5, abs=0.05)
    assert proposed(both, least=0.7)[0, SHARE] == -1
