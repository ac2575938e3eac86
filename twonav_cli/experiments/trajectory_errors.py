"""How good a trajectory is beside a reference: relations, pairs, and the error after one rigid alignment.

The measures are those of Kuemmerle et al. 2009 ("On measuring the accuracy of SLAM algorithms"), Eq. 2 to 4: errors of
relative poses, so that one wrong turn at the beginning does not count at every later pose. Poses are paired by their
stamps and never interpolated. N poses, K relations.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, wrap_angles

STAMP_TOLERANCE_S = 1e-3
NEAR_M = 2.0
"""Pairs of reference poses farther apart than this are not compared."""

FEWEST_POSES = 3


class RelationErrors(NamedTuple):
    """Mean errors of relative poses."""

    translation_m: float
    rotation_deg: float
    used: int


class AlignedErrors(NamedTuple):
    """Errors beside a reference trajectory."""

    position_rms_m: float
    """After the best rigid alignment of the positions (ATE)."""
    pairs_m: float
    """Mean translation error of every pair of reference poses at most NEAR_M apart; NaN where there is none."""
    pairs_deg: float
    used: int


def relative_poses(origins: FloatArray, targets: FloatArray) -> FloatArray:
    """Return targets [N, 3] as seen from origins [N, 3]."""
    dx, dy = targets[:, 0] - origins[:, 0], targets[:, 1] - origins[:, 1]
    cos, sin = np.cos(origins[:, 2]), np.sin(origins[:, 2])
    turned = wrap_angles(targets[:, 2] - origins[:, 2])
    return np.column_stack([cos * dx + sin * dy, cos * dy - sin * dx, turned])


def relation_errors(trajectory: FloatArray, relations: FloatArray) -> RelationErrors:
    """Return the mean error of a trajectory's relations whose both stamps it has (Eq. 2-4).

    Args:
        trajectory: [N, 4] stamp, x, y, theta.
        relations: [K, 5] two stamps, then x, y, theta of the second pose as seen from the first.

    Raises:
        TwonavError: It has no such pair of stamps.
    """
    first, has_first = _at(trajectory, relations[:, 0])
    second, has_second = _at(trajectory, relations[:, 1])
    used = has_first & has_second
    if not used.any():
        raise TwonavError("no relation has both stamps in the trajectory: score a trajectory of the same log")
    return _mean_errors(relations[used, 2:], relative_poses(first[used], second[used]))


def aligned_errors(trajectory: FloatArray, reference: FloatArray) -> AlignedErrors:
    """Return the errors of a trajectory [N, 4] beside a reference [M, 4], at common stamps.

    Raises:
        TwonavError: They have fewer than three stamps in common.
    """
    poses, has = _at(trajectory, reference[:, 0])
    ours, theirs = poses[has], reference[has, 1:]
    if len(ours) < FEWEST_POSES:
        raise TwonavError(f"only {len(ours)} stamps are in both trajectories: score a trajectory of the same log")
    off_m = np.hypot(*(_aligned(ours[:, :2], theirs[:, :2]) - theirs[:, :2]).T)
    i, j = np.triu_indices(len(theirs), 1)
    near = np.hypot(*(theirs[i, :2] - theirs[j, :2]).T) <= NEAR_M
    i, j = i[near], j[near]
    pairs = _mean_errors(relative_poses(theirs[i], theirs[j]), relative_poses(ours[i], ours[j]))
    return AlignedErrors(float(np.sqrt((off_m**2).mean())), pairs.translation_m, pairs.rotation_deg, len(ours))


def _mean_errors(truth: FloatArray, found: FloatArray) -> RelationErrors:
    """Return the mean size of what is left between relations [K, 3] and those found."""
    if not len(truth):
        return RelationErrors(np.nan, np.nan, 0)
    left = relative_poses(truth, found)
    off_m, off_rad = np.hypot(left[:, 0], left[:, 1]), np.abs(left[:, 2])
    return RelationErrors(float(off_m.mean()), float(np.degrees(off_rad.mean())), len(left))


def _at(trajectory: FloatArray, stamps_s: FloatArray) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Return the poses [K, 3] at stamps [K], and which stamps the trajectory has."""
    if not len(trajectory):
        raise TwonavError("the trajectory is empty: score a trajectory of the same log")
    known = trajectory[np.argsort(trajectory[:, 0], kind="stable")]
    after = np.minimum(np.searchsorted(known[:, 0], stamps_s), len(known) - 1)
    before = np.maximum(after - 1, 0)
    before_is_nearer = np.abs(known[before, 0] - stamps_s) <= np.abs(known[after, 0] - stamps_s)
    nearest = np.where(before_is_nearer, before, after)
    return known[nearest, 1:], np.abs(known[nearest, 0] - stamps_s) <= STAMP_TOLERANCE_S


def _aligned(points: FloatArray, onto: FloatArray) -> FloatArray:
    """Return points [N, 2] after the turn and shift that bring them nearest to others (least squares)."""
    middle, middle_onto = points.mean(axis=0), onto.mean(axis=0)
    a, b = points - middle, onto - middle_onto
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    cos, sin = np.cos(angle), np.sin(angle)
    return np.asarray(a @ np.array([[cos, sin], [-sin, cos]]) + middle_onto)
