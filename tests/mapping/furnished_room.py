"""A made-up room with corners and furniture, a laser in it, and a drive whose odometry drifts."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from twonav_cli.config import MappingConfig
from twonav_cli.geometry import FloatArray, Pose, compose, relative_pose, wrap_angle
from twonav_cli.mapping.mapper import GridMapper
from twonav_cli.mapping.scan import RangeSensor, Reading

START = Pose(-1.7, -1.2, 0.2)
CONFIG = MappingConfig(particles=6)
SENSOR = RangeSensor(np.linspace(-np.pi, np.pi, 180, endpoint=False), Pose(0.12, 0.0, 0.0), 8.0)
NOISE_M = 0.005
FIRST_S = 1134864629.9
BETWEEN_S = 0.2


def box(x_min_m: float, y_min_m: float, x_max_m: float, y_max_m: float) -> FloatArray:
    """Return the four sides [4, 2, 2] of a box: from, to."""
    corners = np.array([[x_min_m, y_min_m], [x_max_m, y_min_m], [x_max_m, y_max_m], [x_min_m, y_max_m]])
    return np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)


ROOM = np.concatenate(
    [
        box(-3.03, -2.21, 3.18, 2.34),
        box(-3.03, 0.87, -1.94, 2.34),
        box(-0.37, -0.28, 0.46, 0.33),
        box(2.41, -0.92, 3.18, 0.58),
        box(0.83, 1.93, 1.64, 2.34),
        box(-0.92, -2.21, -0.31, -1.86),
    ]
)
"""[W, 2, 2] walls: a room of 6.2 m x 4.6 m less one corner, a table in the middle, three cupboards."""


def ranges_at(pose: Pose, sensor: RangeSensor = SENSOR, walls: FloatArray = ROOM) -> FloatArray:
    """Return what a perfect laser of a robot at a pose measures [B], metres; infinite where there is no wall."""
    at = compose(pose, sensor.mount)
    directions = sensor.angles_rad + at.theta_rad
    beam = np.stack([np.cos(directions), np.sin(directions)], axis=1)[:, None]  # [B, 1, 2]
    begin, along = walls[None, :, 0] - (at.x_m, at.y_m), walls[None, :, 1] - walls[None, :, 0]  # [1, W, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = beam[..., 0] * along[..., 1] - beam[..., 1] * along[..., 0]
        range_m = (begin[..., 0] * along[..., 1] - begin[..., 1] * along[..., 0]) / turn
        share = (begin[..., 0] * beam[..., 1] - begin[..., 1] * beam[..., 0]) / turn
        met = (range_m > 0) & (share >= 0) & (share <= 1)
    return np.asarray(np.where(met, range_m, np.inf).min(axis=1))


def noisy(ranges_m: FloatArray, rng: np.random.Generator) -> FloatArray:
    return np.asarray(ranges_m + NOISE_M * rng.standard_normal(len(ranges_m)))


def way(steps: int) -> list[Pose]:
    """Return poses 8 cm apart on a rounded way about the table, to the left."""
    poses = [START]
    for step in range(steps):
        at = poses[-1]
        ahead = np.arctan2(at.y_m / 1.3, at.x_m / 1.8) + 0.25
        goal = Pose(1.8 * float(np.cos(ahead)), 1.3 * float(np.sin(ahead)), 0.0)
        bearing = wrap_angle(float(np.arctan2(goal.y_m - at.y_m, goal.x_m - at.x_m)) - at.theta_rad)
        sway = 0.02 * float(np.sin(step / 3))
        poses.append(compose(at, Pose(0.08, 0.0, float(np.clip(bearing, -0.2, 0.2)) + sway)))
    return poses


def odometry_of(poses: list[Pose], turn_rad: float = 0.006, stretch: float = 1.03) -> list[Pose]:
    """Return what odometry makes of a way, in a frame of its own: every step turns and drives too far."""
    odometry = [Pose(5.0, -7.0, 1.0)]
    for before, after in pairwise(poses):
        moved = relative_pose(before, after)
        moved = Pose(stretch * moved.x_m, stretch * moved.y_m, wrap_angle(moved.theta_rad + turn_rad))
        odometry.append(compose(odometry[-1], moved))
    return odometry


def readings_of(poses: list[Pose], odometry: list[Pose], seed: int = 0) -> list[Reading]:
    rng = np.random.default_rng(seed)
    return [
        Reading(FIRST_S + BETWEEN_S * k, odom, noisy(ranges_at(pose), rng))
        for k, (pose, odom) in enumerate(zip(poses, odometry, strict=True))
    ]


def mapped(readings: list[Reading], config: MappingConfig = CONFIG, seed: int = 0) -> GridMapper:
    """Return a mapper that was given every reading of a drive."""
    mapper = GridMapper(config, SENSOR, seed, START)
    for reading in readings:
        mapper.add(reading)
    return mapper
