"""The improved proposal: where each particle goes, and what that does to its weight (Grisetti et al. 2007, §III-B)."""

from __future__ import annotations

import numpy as np

from twonav_cli.compiled import compiled
from twonav_cli.mapping.scan_match import best_pose, fit_at, log_prior

SPREAD = 1.3
"""Deviations at which the proposal's samples lie on each side of the maximum (ours)."""


@compiled
def propose(cells, tables, first_row, first_col, points, normals, starts, priors, informations, factors, draws, rule, out):  # type: ignore[no-untyped-def]
    """Move every particle by the improved proposal.

    Args:
        tables: [P, TR, TC].
        starts: [P, 3] where scan matching begins (cells, radians).
        priors: [P, 3] means of the motion model.
        informations: [P, 3, 3] inverse covariances of the motion model.
        factors: [P, 3, 3] square roots of its covariances.
        draws: [P, 3] standard normal numbers.
        rule: [evidence, wide sigma, narrow sigma, least share of fitting beams, 1 to draw or 0 to take the maximum].
        out: [P, 5] written: pose, logarithm of the weight's factor, share of fitting beams (negative: failed).
    """
    hessian, gradient = np.zeros((3, 3)), np.zeros(3)
    for p in range(len(tables)):
        table = tables[p]
        pose, likelihood, share, covariance = best_pose(
            cells, table, first_row, first_col, points, normals, starts[p], priors[p], informations[p], rule
        )
        if share < rule[3]:
            moved = priors[p] + factors[p] @ draws[p]
            found, _ = fit_at(
                cells, table, first_row, first_col, points, normals, moved, rule[2], 1, 1, hessian, gradient
            )
            out[p, :3] = moved
            out[p, 3] = rule[0] * found
            out[p, 4] = -share - 1e-9
            continue
        out[p, 4] = share
        if rule[4] == 0.0:
            out[p, :3] = pose
            out[p, 3] = rule[0] * likelihood + log_prior(pose, priors[p], informations[p])
            continue
        mean, root, weight = gaussian_around(
            cells, table, first_row, first_col, points, normals, pose, covariance, priors[p], informations[p], rule
        )
        out[p, :3] = mean + root @ draws[p]
        out[p, 3] = weight


@compiled
def gaussian_around(cells, table, first_row, first_col, points, normals, pose, covariance, prior, information, rule):  # type: ignore[no-untyped-def]
    """Return mean, root of the covariance and log weight of the proposal from samples about the maximum (Eq. 16-19).

    The samples are the 27 points of a grid along the axes of the posterior at the maximum.
    """
    hessian, gradient = np.zeros((3, 3)), np.zeros(3)
    root = np.linalg.cholesky(covariance)
    offsets, values = np.zeros((27, 3)), np.zeros(27)
    for j in range(27):
        unit = np.array([j % 3 - 1.0, j // 3 % 3 - 1.0, j // 9 - 1.0]) * SPREAD
        offsets[j] = root @ unit
        at = pose + offsets[j]
        found, _ = fit_at(cells, table, first_row, first_col, points, normals, at, rule[2], 1, 1, hessian, gradient)
        values[j] = rule[0] * found + log_prior(at, prior, information)
    top = values.max()
    tau = np.exp(values - top)
    total = tau.sum()
    mean = np.zeros(3)
    for j in range(27):
        mean += tau[j] / total * offsets[j]
    spread = np.zeros((3, 3))
    for j in range(27):
        away = offsets[j] - mean
        spread += tau[j] / total * np.outer(away, away)
    for k in range(3):
        spread[k, k] += 1e-12
    volume = np.log(np.abs(root[0, 0] * root[1, 1] * root[2, 2]))
    return pose + mean, np.linalg.cholesky(spread), top + np.log(total) + volume
