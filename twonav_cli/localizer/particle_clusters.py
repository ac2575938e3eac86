"""Clusters of weighted particles: where a cloud is densest, and its mean there.

A mean over two clusters is a place where the robot certainly is not. P particles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.geometry import FloatArray, Pose, wrap_angles

BIN_M, BIN_RAD = 0.4, np.pi / 4
"""Bins in which the densest place is looked for (ours)."""

RADIUS_M, RADIUS_RAD = 0.45, 0.7
"""What lies this near to a cluster's middle belongs to it (ours; the distance of Fox, Burgard, Thrun 1999)."""

SHIFTS = 3
"""Times that a cluster's middle moves to the mean of what is near it (ours; it hardly moves after two)."""

LEAST_WEIGHT = 0.01
"""Share of the particles' weight from which on what is left counts as a cluster (ours)."""

CLUSTERS_AT_MOST = 6


class Cluster(NamedTuple):
    """Particles near each other."""

    weight: float
    """Sum of their weights."""
    pose: Pose
    """Their mean."""
    spread_m: float
    """Root of the mean squared distance to it."""
    spread_rad: float


def clusters_of(particles: FloatArray, weights: FloatArray) -> list[Cluster]:
    """Return the clusters of particles [P, 3] with weights [P], the heaviest first; at least one."""
    bins = _bins_of(particles)
    left = weights.copy()
    found: list[Cluster] = []
    while len(found) < CLUSTERS_AT_MOST:
        densest = int(np.bincount(bins, left).argmax())
        start = np.flatnonzero((bins == densest) & (left > 0))
        members, cluster = _gathered(particles, left, start)
        found.append(cluster)
        left[members] = 0.0
        if left.sum() < LEAST_WEIGHT * weights.sum():
            break
    heavy = [cluster for cluster in found if cluster.weight >= LEAST_WEIGHT * weights.sum()]
    return sorted(heavy or found[:1], key=lambda cluster: -cluster.weight)


def _bins_of(particles: FloatArray) -> NDArray[np.int64]:
    """Return the number [P] of the bin that holds each particle; only bins that hold one are counted."""
    col, row = np.floor((particles[:, :2] - particles[:, :2].min(axis=0)) / BIN_M).astype(np.int64).T
    turn = np.floor((particles[:, 2] + np.pi) / BIN_RAD).astype(np.int64)
    turns = round(2 * np.pi / BIN_RAD) + 1
    return np.unique((row * (col.max() + 1) + col) * turns + turn, return_inverse=True)[1]


def _gathered(
    particles: FloatArray, weights: FloatArray, start: NDArray[np.int64]
) -> tuple[NDArray[np.int64], Cluster]:
    """Return what lies around the mean of some particles, after the mean has moved to where most lies."""
    members = start
    for _ in range(SHIFTS):
        pose = _mean(particles[members], weights[members])
        squared_m = (particles[:, 0] - pose.x_m) ** 2 + (particles[:, 1] - pose.y_m) ** 2
        away_rad = np.abs(wrap_angles(particles[:, 2] - pose.theta_rad))
        members = np.flatnonzero((squared_m < RADIUS_M**2) & (away_rad < RADIUS_RAD) & (weights > 0))
    near, weight = particles[members], weights[members]
    pose = _mean(near, weight)
    total = float(weight.sum())
    squared_m = (near[:, 0] - pose.x_m) ** 2 + (near[:, 1] - pose.y_m) ** 2
    away_rad = wrap_angles(near[:, 2] - pose.theta_rad)
    spreads = (np.sqrt(weight @ squared_m / total), np.sqrt(weight @ away_rad**2 / total))
    return members, Cluster(total, pose, *(float(spread) for spread in spreads))


def _mean(particles: FloatArray, weights: FloatArray) -> Pose:
    """Return the mean of particles [P, 3] that lie near each other."""
    x_m, y_m = (weights @ particles[:, :2] / weights.sum()).tolist()
    theta_rad = np.arctan2(weights @ np.sin(particles[:, 2]), weights @ np.cos(particles[:, 2]))
    return Pose(x_m, y_m, float(theta_rad))
