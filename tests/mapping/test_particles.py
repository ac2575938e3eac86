from dataclasses import replace

import numpy as np
import pytest
from furnished_room import CONFIG, SENSOR, ranges_at
from whole_map import WholeMap

from twonav_cli.config import MappingConfig
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose, relative_pose
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cell_units import CellUnits, composed
from twonav_cli.mapping.cells import NO_TILE
from twonav_cli.mapping.motion_model import motion_covariance
from twonav_cli.mapping.particles import Particles
from twonav_cli.mapping.scan import points_of
from twonav_cli.mapping.surface_normals import surface_normals

UNITS = CellUnits(CONFIG.resolution_m)
BEGIN, END = Pose(-1.7, -1.2, 0.2), Pose(-1.25, -1.05, 0.35)
MOTION = UNITS.of_motion(relative_pose(BEGIN, END))
MOUNT = UNITS.of_motion(SENSOR.mount)


def scan_at(pose: Pose) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return the ends of the beams [N, 2] and normals in the robot's frame, and the ends in the sensor's, cells."""
    ranges_m, origin = ranges_at(pose), Pose(0.0, 0.0, 0.0)
    points_m = points_of(SENSOR, ranges_m, origin)
    from_sensor_m = points_of(SENSOR, ranges_m, relative_pose(SENSOR.mount, origin))
    return points_m / CONFIG.resolution_m, surface_normals(points_m), from_sensor_m / CONFIG.resolution_m


def begun(config: MappingConfig = CONFIG, seed: int = 0) -> Particles:
    particles = Particles(config, UNITS.of_pose(BEGIN), np.random.default_rng(seed))
    particles.begin(10.0, MOUNT, scan_at(BEGIN)[2])
    return particles


def moved(particles: Particles, pose: Pose = END, motion: FloatArray = MOTION) -> int:
    """Move every particle to a pose by odometry that tells how far it is; return how many did not fit."""
    points, normals, _ = scan_at(pose)
    driven = UNITS.pose(motion)
    covariances = np.stack([motion_covariance(CONFIG, driven, theta) for theta in particles.poses[:, 2].tolist()])
    return particles.move(points, normals, motion, motion, covariances)


def spoil(particles: Particles, particle: int) -> None:
    """Give one particle a map of the first scan with 5 cm of noise."""
    from_sensor = scan_at(BEGIN)[2]
    particles.store.tables[particle] = NO_TILE
    sensor = composed(particles.poses, MOUNT)[particle]
    carve_scan(particles.store, particle, sensor, from_sensor + np.random.default_rng(0).normal(size=from_sensor.shape))


def test_all_particles_begin_at_the_start_with_one_map_that_they_share() -> None:
    particles = begun()
    assert particles.poses == pytest.approx(np.tile(UNITS.of_pose(BEGIN), (CONFIG.particles, 1)))
    assert (particles.store.tables == particles.store.tables[0]).all()
    used = particles.store.tables[0] != NO_TILE
    assert used.sum() == particles.store.tiles_used
    assert (particles.store.references[particles.store.tables[0][used]] == CONFIG.particles).all()
    assert WholeMap(particles.store).hits.sum() == len(SENSOR.angles_rad)
    assert particles.weights == pytest.approx(1 / CONFIG.particles)
    assert not particles.few


def test_every_particle_goes_to_where_the_scan_fits_with_its_own_scatter() -> None:
    particles = begun()
    assert moved(particles, motion=MOTION + np.array([1.5, 1.0, 0.05])) == 0
    off = particles.poses - UNITS.of_pose(END)
    assert np.abs(off[:, :2]).max() < 0.4  # 2 cm
    assert np.abs(off[:, 2]).max() < 0.01
    assert len(np.unique(particles.poses[:, 0])) == CONFIG.particles
    assert particles.weights.sum() == pytest.approx(1.0)


def test_one_particle_that_takes_the_maximum_is_not_scattered() -> None:
    config = replace(CONFIG, particles=1, proposal="maximum")
    first, second = begun(config, 1), begun(config, 2)
    assert moved(first) == moved(second) == 0
    assert first.poses.tolist() == second.poses.tolist()
    assert first.weights.tolist() == [1.0]
    assert not first.few


def test_a_scan_that_fits_no_map_is_counted_and_odometry_is_kept() -> None:
    particles = begun(replace(CONFIG, particles=100))
    away = np.array([400.0, 0.0, 0.0])
    assert moved(particles, motion=away) == 100
    expected = composed(UNITS.of_pose(BEGIN)[None], away)[0]
    deviation = np.sqrt(np.diag(motion_covariance(CONFIG, UNITS.pose(away), BEGIN.theta_rad)))
    assert np.abs((np.median(particles.poses, axis=0) - expected) / deviation).max() < 0.4
    assert np.ptp(particles.poses[:, 0]) > deviation[0]


def test_headings_stay_within_half_a_turn() -> None:
    particles = begun(replace(CONFIG, least_match=2.0))  # nothing fits: odometry turns on
    for _ in range(8):
        moved(particles, motion=np.array([0.0, 0.0, 1.0]))
    assert (np.abs(particles.poses[:, 2]) <= np.pi).all()


def test_a_particle_whose_map_fits_worse_weighs_less_and_is_not_the_best() -> None:
    particles = begun(replace(CONFIG, weight_gain=1.0))
    spoil(particles, 2)
    moved(particles)
    assert particles.best != 2
    assert particles.weights[2] < 0.5 * np.delete(particles.weights, 2).max()
    assert 1.0 <= particles.effective < CONFIG.particles
    assert particles.effective == pytest.approx(1 / (particles.weights**2).sum())


def test_a_scan_goes_into_every_map_from_where_its_particle_is() -> None:
    particles = begun()
    particles.poses[:] = np.array([[3.0 * k, -2.0 * k, 0.01 * k] for k in range(CONFIG.particles)])
    before = [WholeMap(particles.store, k) for k in range(CONFIG.particles)]
    particles.map_scan(11.0, MOUNT, np.array([[20.25, 0.0]]))
    for k, sensor in enumerate(composed(particles.poses, MOUNT)):
        after = WholeMap(particles.store, k)
        assert after.hits.sum() == before[k].hits.sum() + 1
        end = composed(sensor[None], np.array([20.25, 0.0, 0.0]))[0]
        cell = int(np.floor(end[1])), int(np.floor(end[0]))
        assert after.counts(*cell)[0] == before[k].counts(*cell)[0] + 1


def test_particles_drawn_again_take_pose_map_and_path_with_them() -> None:
    particles = begun(replace(CONFIG, particles=3, weight_gain=1.0))
    spoil(particles, 0)
    moved(particles)
    particles.map_scan(11.0, MOUNT, scan_at(END)[2])
    poses, weights = particles.poses.copy(), particles.weights
    maps = [WholeMap(particles.store, k).visits for k in range(3)]
    paths = [particles.paths.path_of(k)[1] for k in range(3)]
    best = particles.best
    particles.draw_again()
    parents = [int(np.flatnonzero((poses == pose).all(axis=1))[0]) for pose in particles.poses]
    copies = np.bincount(parents, minlength=3)
    assert (np.abs(copies - 3 * weights) < 1).all()
    assert 0 not in parents
    for k, parent in enumerate(parents):
        assert np.array_equal(WholeMap(particles.store, k).visits, maps[parent])
        assert np.array_equal(particles.paths.path_of(k)[1], paths[parent])
    assert particles.weights == pytest.approx(1 / 3)
    assert best in parents
    assert parents[particles.best] == best


def test_few_is_asked_by_the_share_of_particles() -> None:
    # They saw the same from the same place, so they weigh the same.
    for share, few in ((0.99, False), (1.01, True)):
        particles = begun(replace(CONFIG, weight_gain=1.0, resample_share=share))
        moved(particles)
        assert particles.effective == pytest.approx(CONFIG.particles)
        assert particles.few is few


def test_an_unknown_proposal_is_answered_with_the_right_ones() -> None:
    with pytest.raises(TwonavError, match="unknown proposal 'maximun'; did you mean 'maximum'"):
        Particles(MappingConfig(proposal="maximun"), np.zeros(3), np.random.default_rng(0))
