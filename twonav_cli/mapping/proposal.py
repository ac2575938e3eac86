"""The improved proposal: where each particle goes, and what that does to its weight (Grisetti et al. 2007, §III-B).

P particles, N beams that hit something, S samples. Lengths are in cells.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.mapping.cells import CellMap, Cells, Table, Walls
from twonav_cli.mapping.scan_match import NARROW_REACH, best_pose, likelihood_at, log_prior
from twonav_cli.mapping.three_by_three import root, root_of_inverse, times

DRAWN, MAXIMUM = "gaussian", "maximum"
PROPOSALS = (DRAWN, MAXIMUM)
"""Draw each particle from a Gaussian around the maximum (the paper), or take the maximum (the well-known program)."""

SPREAD = math.sqrt(3.0)
"""Deviations at which the samples lie on each side of the maximum: those of the rule below."""

SAMPLE_STRIDE = 3
"""Every how many beams one counts for a sample (ours)."""

CUBE = np.array(
    [[0.0, 0.0, 0.0]]
    + [[float(sign * (axis == k)) for axis in range(3)] for k in range(3) for sign in (-1, 1)]
    + [[float(x), float(y), float(t)] for x in (-1, 1) for y in (-1, 1) for t in (-1, 1)]
)
"""[S, 3] middle, faces and corners of a cube."""

SAMPLE_LOG_WEIGHTS = np.log([2 / 9] + [1 / 9] * 6 + [1 / 72] * 8) + 0.5 * SPREAD**2 * (CUBE**2).sum(axis=1)
"""[S] The first factor makes the samples integrate a normal density times any quintic polynomial exactly; over
that density (the second) they weigh samples of another one. Ours: the paper only takes samples around the maximum."""

TINY = 1e-9
"""Variance that keeps a covariance positive when one sample has all the weight, squared cells and radians."""

POSE, LOG_WEIGHT, SHARE = slice(0, 3), 3, 4
"""Columns of what `propose` writes."""

COLUMNS = 5

Floats = NDArray[np.float64]
Maps = tuple[Cells, Walls, Table, int, int]
"""Cells, walls, tables [P, TR, TC], first row and first column of all particles."""


@compiled
def propose(
    maps: Maps, points: Floats, normals: Floats, starts: Floats, priors: Floats, informations: Floats, roots: Floats,
    draws: Floats, rule: Floats, least: float, draw: bool, out: Floats,
) -> None:  # fmt: skip
    """Move every particle by the improved proposal.

    Args:
        maps: Of all particles.
        points: [N, 2] ends of the beams in the robot's frame.
        normals: [N, 2] across the surfaces.
        starts: [P, 3] where scan matching begins.
        priors: [P, 3] means of the motion model.
        informations: [P, 3, 3] inverse covariances of the motion model.
        roots: [P, 3, 3] square roots of its covariances.
        draws: [P, 3] standard normal numbers.
        rule: As `best_pose` takes it.
        least: Share of the beams that must fit; where fewer do, the pose is drawn from odometry (§4.1).
        draw: Whether to draw around the maximum; else it is taken.
        out: [P, COLUMNS] written: pose, logarithm of the weight's factor, share of fitting beams (-1: too few).
    """
    cells, walls, tables, first_row, first_col = maps
    for p in range(len(tables)):
        grid = CellMap(cells, walls, tables[p], first_row, first_col)
        prior, information = priors[p], informations[p]
        pose, likelihood, share, precision = best_pose(grid, points, normals, starts[p], prior, information, rule)
        out[p, SHARE] = share if share >= least else -1.0
        if share < least:
            pose = prior + times(roots[p], draws[p])
            likelihood, _ = likelihood_at(grid, points, normals, pose, rule[2], NARROW_REACH, 1)
            out[p, LOG_WEIGHT] = rule[0] * likelihood
        elif draw:
            axes = root_of_inverse(precision)
            mean, spread, weight = gaussian_around(grid, points, normals, pose, axes, prior, information, rule)
            pose = mean + times(spread, draws[p])
            out[p, LOG_WEIGHT] = weight
        else:
            out[p, LOG_WEIGHT] = rule[0] * likelihood + log_prior(pose, prior, information)
        out[p, :3] = pose


@compiled
def gaussian_around(
    grid: CellMap, points: Floats, normals: Floats, pose: Floats, axes: Floats, prior: Floats, information: Floats,
    rule: Floats,
) -> tuple[Floats, Floats, float]:  # fmt: skip
    """Return mean, root of the covariance and log weight of the proposal from samples about the maximum (Eq. 16-19).

    The samples are the maximum, and the faces and corners of a cube along the axes of the posterior there.

    Args:
        grid: Map of the particle.
        points: [N, 2] ends of the beams in the robot's frame.
        normals: [N, 2] across the surfaces.
        pose: [3] the maximum.
        axes: [3, 3] root of the covariance of the posterior as the climb to the maximum leaves it.
        prior: [3] mean of the motion model.
        information: [3, 3] inverse covariance of the motion model.
        rule: As `best_pose` takes it.
    """
    count = len(CUBE)
    offsets, values = np.zeros((count, 3)), np.zeros(count)
    for j in range(count):
        offsets[j] = times(axes, CUBE[j]) * SPREAD
        at = pose + offsets[j]
        likelihood, _ = likelihood_at(grid, points, normals, at, rule[2], NARROW_REACH, SAMPLE_STRIDE)
        values[j] = rule[0] * SAMPLE_STRIDE * likelihood + log_prior(at, prior, information) + SAMPLE_LOG_WEIGHTS[j]
    top = values.max()
    tau = np.exp(values - top)
    total = tau.sum()
    mean, covariance = np.zeros(3), np.zeros((3, 3))
    for j in range(count):
        mean += tau[j] / total * offsets[j]
    for j in range(count):
        away = offsets[j] - mean
        for k in range(3):
            covariance[k] += tau[j] / total * away[k] * away
    for k in range(3):
        covariance[k, k] += TINY
    volume = np.log(np.abs(axes[0, 0] * axes[1, 1] * axes[2, 2]))
    return pose + mean, root(covariance), float(top + np.log(total) + volume)
