"""How well a scan fits a map, and the pose at which it fits best.

A beam fits by the distance from its end to the nearest mean of hits around it, across the surface that the scan
itself shows there; along the surface it counts less, for the means of a wall lie a cell apart.

N beams that hit something. Lengths are in cells.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled, inlined
from twonav_cli.mapping.cells import HITS, MEAN_STEPS, MEAN_X, MEAN_Y, TILE_BITS, TILE_MASK, VISITS, log_odds

ALONG = 0.15
"""Weight of the squared distance along a surface (ours)."""

OUTLIER = 0.05
"""Likelihood of a beam that fits nothing, beside 1 of one that fits exactly (ours)."""

NEIGHBOUR_BEAMS = 3
"""Beams on each side from which the direction of a surface is taken (ours)."""

NEIGHBOUR_M = 0.4
"""Ends farther apart belong to different surfaces, metres (ours)."""

SURE_MATCH = 0.8
"""Share of fitting beams from which a match is taken without looking further (ours)."""

SEARCH_STEP_RAD = 0.04
SEARCH_STEPS = 12
"""Headings tried on each side of the guess: to 27 degrees, as far as real odometry was seen to err in a step (ours)."""

SEARCH_BEAMS = 90
"""Beams that are enough to tell headings apart (ours)."""

Floats = NDArray[np.float64]


class Fit(NamedTuple):
    """A pose, in cells and radians, and how well the scan fits there."""

    x: float
    y: float
    theta: float
    log_likelihood: float
    matched: float
    """Share of the beams that fit something."""


def surface_normals(points: Floats) -> Floats:
    """Return the direction [N, 2] across the surface at each end of a beam; (0, 0) where the scan shows none.

    Args:
        points: [N, 2] ends in the order of the beams, metres.
    """
    normals = np.zeros_like(points)
    _fill_normals(points, normals)
    return normals


@compiled
def _fill_normals(points: Floats, normals: Floats) -> None:
    for i in range(len(points)):
        count, mean_x, mean_y, xx, xy, yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(max(0, i - NEIGHBOUR_BEAMS), min(len(points), i + NEIGHBOUR_BEAMS + 1)):
            x, y = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            if x * x + y * y < NEIGHBOUR_M * NEIGHBOUR_M:
                count += 1
                mean_x += x
                mean_y += y
                xx += x * x
                xy += x * y
                yy += y * y
        if count < 4:
            continue
        xx, xy, yy = xx - mean_x * mean_x / count, xy - mean_x * mean_y / count, yy - mean_y * mean_y / count
        half, root = (xx + yy) / 2, np.sqrt(((xx - yy) / 2) ** 2 + xy * xy)
        if root < 0.6 * half:  # as wide as long: no surface
            continue
        angle = 0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2
        normals[i, 0], normals[i, 1] = np.cos(angle), np.sin(angle)


@inlined
def nearest_mean(cells, table, first_row, first_col, x, y, reach):  # type: ignore[no-untyped-def]
    """Return (dx, dy, found): from a point to the nearest mean of an occupied cell within `reach` cells."""
    col, row = int(np.floor(x)) - first_col, int(np.floor(y)) - first_row
    best, best_dx, best_dy = 1e9, 0.0, 0.0
    high_row, high_col = table.shape[0] << TILE_BITS, table.shape[1] << TILE_BITS
    if row < reach or col < reach or row >= high_row - reach or col >= high_col - reach:
        return 0.0, 0.0, False
    for r in range(row - reach, row + reach + 1):
        for c in range(col - reach, col + reach + 1):
            tile = table[r >> TILE_BITS, c >> TILE_BITS]
            if tile < 0:
                continue
            at = ((r & TILE_MASK) << TILE_BITS) | (c & TILE_MASK)
            hits = cells[tile, at, HITS]
            if hits == 0 or log_odds(hits, cells[tile, at, VISITS]) <= 0.0:
                continue
            dx = c + first_col + cells[tile, at, MEAN_X] / MEAN_STEPS - x
            dy = r + first_row + cells[tile, at, MEAN_Y] / MEAN_STEPS - y
            squared = dx * dx + dy * dy
            if squared < best:
                best, best_dx, best_dy = squared, dx, dy
    return best_dx, best_dy, best < 1e9


@compiled
def fit_at(cells, table, first_row, first_col, points, normals, pose, sigma, reach, stride, hessian, gradient):  # type: ignore[no-untyped-def]
    """Return log-likelihood and number of fitting beams at a pose; fill the Gauss-Newton matrix and vector.

    A beam's likelihood is that of a Gaussian over the distance, and OUTLIER for what fits nothing.

    Args:
        cells: [T, TILE * TILE, 4].
        table: [TR, TC] of one particle.
        first_row: Cell row at which the table begins.
        first_col: Cell column at which the table begins.
        points: [N, 2] ends in the frame of the pose, cells.
        normals: [N, 2] in the frame of the pose.
        pose: [3] x, y in cells, theta.
        sigma: Deviation of a distance, cells.
        reach: How many cells around an end are looked at.
        stride: Every how many beams one counts.
        hessian: [3, 3] written: of the negative log-likelihood.
        gradient: [3] written: of the log-likelihood.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    hessian[:] = 0.0
    gradient[:] = 0.0
    total, matched = 0.0, 0
    precision = 1.0 / (sigma * sigma)
    for i in range(0, len(points), stride):
        rx, ry = cos * points[i, 0] - sin * points[i, 1], sin * points[i, 0] + cos * points[i, 1]
        dx, dy, found = nearest_mean(cells, table, first_row, first_col, pose[0] + rx, pose[1] + ry, reach)
        if not found:
            total += np.log(OUTLIER)
            continue
        nx, ny = cos * normals[i, 0] - sin * normals[i, 1], sin * normals[i, 0] + cos * normals[i, 1]
        flat = nx != 0.0 or ny != 0.0
        along = ALONG if flat else 1.0
        across = dx * nx + dy * ny
        squared = along * (dx * dx + dy * dy) + (1.0 - along) * across * across
        good = np.exp(-0.5 * squared * precision)
        total += np.log(good + OUTLIER)
        weight = good / (good + OUTLIER) * precision
        matched += good > 0.3
        # the metric M = along * 1 + (1 - along) n n^T; J = [1, r_perp]
        mxx = weight * (along + (1.0 - along) * nx * nx)
        mxy = weight * (1.0 - along) * nx * ny
        myy = weight * (along + (1.0 - along) * ny * ny)
        gx, gy = mxx * dx + mxy * dy, mxy * dx + myy * dy
        gradient[0] += gx
        gradient[1] += gy
        gradient[2] += -ry * gx + rx * gy
        tx, ty = -ry * mxx + rx * mxy, -ry * mxy + rx * myy
        hessian[0, 0] += mxx
        hessian[0, 1] += mxy
        hessian[1, 1] += myy
        hessian[0, 2] += tx
        hessian[1, 2] += ty
        hessian[2, 2] += -ry * tx + rx * ty
    hessian[1, 0], hessian[2, 0], hessian[2, 1] = hessian[0, 1], hessian[0, 2], hessian[1, 2]
    return total, matched


@compiled
def best_pose(cells, table, first_row, first_col, points, normals, start, prior, information, rule):  # type: ignore[no-untyped-def]
    """Climb from a start to the pose that scan and odometry make most likely.

    Damped Gauss-Newton on rule.evidence * log p(z | m, x) + log p(x | u), first with a wide kernel and few beams,
    then with a narrow one and all.

    Args:
        start: [3] where to begin.
        prior: [3] mean of p(x | u).
        information: [3, 3] inverse covariance of p(x | u).
        rule: [evidence, wide sigma, narrow sigma], sigmas in cells.

    Returns:
        Pose [3]; log-likelihood there; share of the beams that fit; covariance [3, 3] of the posterior there.
    """
    pose = start.copy()
    hessian, gradient = np.zeros((3, 3)), np.zeros(3)
    trial_hessian, trial_gradient = np.zeros((3, 3)), np.zeros(3)
    likelihood, matched = 0.0, 0
    evidence = rule[0]
    for phase in range(2):
        sigma, reach, stride = (rule[1], 3, 3) if phase == 0 else (rule[2], 1, 1)
        likelihood, matched = fit_at(
            cells, table, first_row, first_col, points, normals, pose, sigma, reach, stride, hessian, gradient
        )
        scale = evidence * stride
        value = scale * likelihood + log_prior(pose, prior, information)
        damping = 1.0
        for _ in range(10):
            matrix = scale * hessian + information
            for k in range(3):
                matrix[k, k] += 1e-6 + 1e-3 * matrix[k, k]
            step = np.linalg.solve(matrix, scale * gradient + information @ (prior - pose)) * damping
            longest = max(abs(step[0]), abs(step[1])) / 3.0 + abs(step[2]) / 0.1
            if longest > 1.0:
                step /= longest
            moved = pose + step
            found, count = fit_at(
                cells, table, first_row, first_col, points, normals, moved, sigma, reach, stride,
                trial_hessian, trial_gradient,
            )  # fmt: skip
            new = scale * found + log_prior(moved, prior, information)
            if new > value:
                gained = new - value
                pose, value, likelihood, matched = moved, new, found, count
                hessian[:] = trial_hessian
                gradient[:] = trial_gradient
                damping = 1.0
                if gained < 1e-3:
                    break
            else:
                damping *= 0.4
                if damping < 0.05:
                    break
    covariance = np.linalg.inv(evidence * hessian + information)
    return pose, likelihood, matched / max(1, len(points)), covariance


@inlined
def log_prior(pose, prior, information):  # type: ignore[no-untyped-def]
    """Return the log density of a Gaussian at a pose, without its constant."""
    dx, dy, dt = pose[0] - prior[0], pose[1] - prior[1], pose[2] - prior[2]
    return -0.5 * (
        information[0, 0] * dx * dx + information[1, 1] * dy * dy + information[2, 2] * dt * dt
        + 2 * (information[0, 1] * dx * dy + information[0, 2] * dx * dt + information[1, 2] * dy * dt)
    )  # fmt: skip


@compiled
def found_pose(cells, table, first_row, first_col, points, normals, start, prior, information, rule):  # type: ignore[no-untyped-def]
    """Like `best_pose`, and where too few beams fit there, look around in all headings of SEARCH_RAD and climb again."""
    best = best_pose(cells, table, first_row, first_col, points, normals, start, prior, information, rule)
    if best[2] >= SURE_MATCH:
        return best
    hessian, gradient = np.zeros((3, 3)), np.zeros(3)
    stride = max(1, len(points) // SEARCH_BEAMS)
    values, at = np.zeros(2 * SEARCH_STEPS + 1), start.copy()
    best_value = rule[0] * best[1] + log_prior(best[0], prior, information)
    for k in range(2 * SEARCH_STEPS + 1):
        at[2] = start[2] + (k - SEARCH_STEPS) * SEARCH_STEP_RAD
        found, _ = fit_at(
            cells, table, first_row, first_col, points, normals, at, rule[1], 3, stride, hessian, gradient
        )
        values[k] = rule[0] * stride * found + log_prior(at, prior, information)
    for _ in range(3):
        k = int(np.argmax(values))
        at[2] = start[2] + (k - SEARCH_STEPS) * SEARCH_STEP_RAD
        values[max(0, k - 1) : k + 2] = -np.inf
        other = best_pose(cells, table, first_row, first_col, points, normals, at, prior, information, rule)
        value = rule[0] * other[1] + log_prior(other[0], prior, information)
        if value > best_value:
            best, best_value = other, value
    return best
