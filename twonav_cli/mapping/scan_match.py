"""How well a scan fits a map, and the pose at which it fits best.

A beam fits by the distance from its end to the nearest mean of hits around it, across the surface that the scan
itself shows there; along the surface it counts less, for the means of a wall lie a cell apart.

N beams that hit something. Lengths are in cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled, inlined
from twonav_cli.config import MappingConfig
from twonav_cli.mapping.cells import MEAN_STEPS, MEAN_X, MEAN_Y, TILE, TILE_BITS, TILE_MASK, CellMap
from twonav_cli.mapping.three_by_three import solved, times

ALONG = 0.15
"""Weight of the squared distance along a surface (ours)."""

LIMIT = 6.0
"""Twice what a beam that fits nothing costs (Geman and McClure's bounded error; value ours: e^-3, or 5 %)."""

FITTING = 2.5
"""A beam fits when its squared distance is below this many squared deviations (ours)."""

SURE_MATCH = 0.8
"""Share of fitting beams from which a match is taken without looking further (ours)."""

FAR = 1e9

WIDE_REACH, WIDE_STRIDE = 3, 3
NARROW_REACH = 1
"""Cells around an end that are looked at, and every how many beams one counts: first wide, then narrow (ours)."""

CLIMB_STEPS = 12
LEAST_DAMPING = 0.1
LONGEST_STEP, LONGEST_TURN_RAD = 3.0, 0.1
"""A step of the climb is no longer than this many cells and radians together (ours)."""

GAIN_ENOUGH = 0.01
"""Gain in log density at which a climb ends (ours)."""

Floats = NDArray[np.float64]


def matching_rule(config: MappingConfig) -> Floats:
    """Return what the scan matcher needs of the settings: evidence, then the wide and the narrow deviation in cells."""
    wide, narrow = config.wide_sigma_m / config.resolution_m, config.sigma_m / config.resolution_m
    return np.array([config.evidence, wide, narrow])


@inlined
def nearest_mean(grid: CellMap, x: float, y: float, reach: int) -> tuple[float, float, float]:
    """Return (dx, dy, squared distance) from a point to the nearest mean of an occupied cell within `reach` cells.

    The point is in cells from where the table begins; the distance is FAR where there is none. The walls' bits tell
    where it is worth looking.
    """
    col, row = int(np.floor(x)) - reach, int(np.floor(y)) - reach
    width = 2 * reach + 1
    left, shift, window = col >> TILE_BITS, col & TILE_MASK, (1 << width) - 1
    best, best_dx, best_dy = FAR, 0.0, 0.0
    rows, cols = grid.table.shape
    if row < 0 or col < 0 or (row + width) >> TILE_BITS >= rows or (col + width) >> TILE_BITS >= cols:
        return best_dx, best_dy, best
    for r in range(row, row + width):
        down, inside = r >> TILE_BITS, r & TILE_MASK
        tile = grid.table[down, left]
        word = np.int64(grid.walls[tile, inside]) >> shift if tile >= 0 else np.int64(0)
        if shift + width > TILE and grid.table[down, left + 1] >= 0:
            word |= np.int64(grid.walls[grid.table[down, left + 1], inside]) << (TILE - shift)
        word &= window
        c = col
        while word != 0:
            if word & 1:
                tile, at = grid.table[down, c >> TILE_BITS], (inside << TILE_BITS) | (c & TILE_MASK)
                dx = c + grid.cells[tile, at, MEAN_X] / MEAN_STEPS - x
                dy = r + grid.cells[tile, at, MEAN_Y] / MEAN_STEPS - y
                squared = dx * dx + dy * dy
                if squared < best:
                    best, best_dx, best_dy = squared, dx, dy
            word >>= 1
            c += 1
    return best_dx, best_dy, best


@inlined
def _misfit(grid: CellMap, x: float, y: float, nx: float, ny: float, reach: int) -> tuple[float, float, float, float]:
    """Return (dx, dy) to the nearest mean, what counts along the surface, and the squared distance that counts.

    The last is FAR where no mean is within reach; (nx, ny) is (0, 0) where the scan shows no surface.
    """
    dx, dy, away = nearest_mean(grid, x, y, reach)
    along = ALONG if nx != 0.0 or ny != 0.0 else 1.0
    across = dx * nx + dy * ny
    return dx, dy, along, along * away + (1.0 - along) * across * across if away != FAR else FAR


@compiled
def likelihood_at(
    grid: CellMap, points: Floats, normals: Floats, pose: Floats, sigma: float, reach: int, stride: int
) -> tuple[float, int]:
    """Return log-likelihood and number of fitting beams as `fit_at` does, without the rest."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    from_x, from_y = pose[0] - grid.first_col, pose[1] - grid.first_row
    total, matched, precision = 0.0, 0, 1.0 / (sigma * sigma)
    for i in range(0, len(points), stride):
        rx, ry = cos * points[i, 0] - sin * points[i, 1], sin * points[i, 0] + cos * points[i, 1]
        nx, ny = cos * normals[i, 0] - sin * normals[i, 1], sin * normals[i, 0] + cos * normals[i, 1]
        _, _, _, squared = _misfit(grid, from_x + rx, from_y + ry, nx, ny, reach)
        if squared == FAR:
            total -= 0.5 * LIMIT
            continue
        squared *= precision
        total -= 0.5 * squared * LIMIT / (LIMIT + squared)
        matched += squared < FITTING
    return total, matched


@compiled
def fit_at(
    grid: CellMap, points: Floats, normals: Floats, pose: Floats, sigma: float, reach: int, stride: int,
    hessian: Floats, gradient: Floats,
) -> tuple[float, int]:  # fmt: skip
    """Return log-likelihood and number of fitting beams at a pose; fill the Gauss-Newton matrix and vector.

    A beam's log-likelihood is -s/2 near the map (s: squared distance over squared sigma) and -LIMIT/2 far from it.

    Args:
        grid: Map of one particle.
        points: [N, 2] ends in the frame of the pose.
        normals: [N, 2] across the surfaces, in the frame of the pose.
        pose: [3] x, y, theta.
        sigma: Deviation of a distance.
        reach: How many cells around an end are looked at.
        stride: Every how many beams one counts.
        hessian: [3, 3] written: of the negative log-likelihood.
        gradient: [3] written: of the log-likelihood.
    """
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    from_x, from_y = pose[0] - grid.first_col, pose[1] - grid.first_row
    hessian[:] = 0.0
    gradient[:] = 0.0
    total, matched, precision = 0.0, 0, 1.0 / (sigma * sigma)
    for i in range(0, len(points), stride):
        rx, ry = cos * points[i, 0] - sin * points[i, 1], sin * points[i, 0] + cos * points[i, 1]
        nx, ny = cos * normals[i, 0] - sin * normals[i, 1], sin * normals[i, 0] + cos * normals[i, 1]
        dx, dy, along, squared = _misfit(grid, from_x + rx, from_y + ry, nx, ny, reach)
        if squared == FAR:
            total -= 0.5 * LIMIT
            continue
        squared *= precision
        share = LIMIT / (LIMIT + squared)
        total -= 0.5 * squared * share
        matched += squared < FITTING
        _add_beam(hessian, gradient, share * share * precision, along, nx, ny, dx, dy, rx, ry)
    hessian[1, 0], hessian[2, 0], hessian[2, 1] = hessian[0, 1], hessian[0, 2], hessian[1, 2]
    return total, matched


@inlined
def _add_beam(
    hessian: Floats, gradient: Floats, weight: float, along: float, nx: float, ny: float, dx: float, dy: float,
    rx: float, ry: float,
) -> None:  # fmt: skip
    """Add what one beam pulls: its metric is along * 1 + (1 - along) n n^T, and a turn moves its end across r."""
    rest = 1.0 - along
    mxx, mxy, myy = weight * (along + rest * nx * nx), weight * rest * nx * ny, weight * (along + rest * ny * ny)
    gx, gy = mxx * dx + mxy * dy, mxy * dx + myy * dy
    tx, ty = rx * mxy - ry * mxx, rx * myy - ry * mxy
    gradient[0] += gx
    gradient[1] += gy
    gradient[2] += rx * gy - ry * gx
    hessian[0, 0] += mxx
    hessian[0, 1] += mxy
    hessian[1, 1] += myy
    hessian[0, 2] += tx
    hessian[1, 2] += ty
    hessian[2, 2] += rx * ty - ry * tx


@compiled
def climb(
    grid: CellMap, points: Floats, normals: Floats, start: Floats, prior: Floats, information: Floats,
    evidence: float, sigma: float, reach: int, stride: int,
) -> tuple[Floats, float, float, Floats]:  # fmt: skip
    """Climb from a start to the pose that scan and odometry make most likely (damped Gauss-Newton).

    What is climbed is evidence * log p(z | m, x) + log p(x | u).

    Args:
        grid: Map of one particle.
        points: [N, 2] ends in the robot's frame.
        normals: [N, 2] across the surfaces.
        start: [3] where to begin.
        prior: [3] mean of p(x | u).
        information: [3, 3] inverse covariance of p(x | u).
        evidence: Exponent of the scan's likelihood.
        sigma: Deviation of a distance.
        reach: How many cells around an end are looked at.
        stride: Every how many beams one counts.

    Returns:
        Pose [3]; log-likelihood there; share of the beams that fit; inverse covariance [3, 3] of the posterior there.
    """
    pose, moved = start.copy(), start.copy()
    hessian, gradient = np.zeros((3, 3)), np.zeros(3)
    moved_hessian, moved_gradient = np.zeros((3, 3)), np.zeros(3)
    scale, damping = evidence * stride, 1.0
    value, likelihood, matched = -np.inf, 0.0, 0
    for _ in range(CLIMB_STEPS):
        found, count = fit_at(grid, points, normals, moved, sigma, reach, stride, moved_hessian, moved_gradient)
        new = scale * found + log_prior(moved, prior, information)
        if new > value:
            gained = new - value
            pose[:] = moved
            value, likelihood, matched, damping = new, found, count, 1.0
            hessian, moved_hessian = moved_hessian, hessian
            gradient, moved_gradient = moved_gradient, gradient
            if gained < GAIN_ENOUGH:
                break
        else:
            damping *= 0.4
            if damping < LEAST_DAMPING:
                break
        step = solved(scale * hessian + information, scale * gradient + times(information, prior - pose))
        longest = max(abs(step[0]), abs(step[1])) / LONGEST_STEP + abs(step[2]) / LONGEST_TURN_RAD
        moved = pose + step * (damping / max(1.0, longest))
    return pose, likelihood, matched * stride / max(1, len(points)), scale * hessian + information


@compiled
def best_pose(
    grid: CellMap, points: Floats, normals: Floats, start: Floats, prior: Floats, information: Floats, rule: Floats
) -> tuple[Floats, float, float, Floats]:
    """Climb on all beams with a narrow kernel; where few fit at the start, first on a third of them with a wide one.

    Args:
        grid: Map of one particle.
        points: [N, 2] ends in the robot's frame.
        normals: [N, 2] across the surfaces.
        start: [3] where to begin.
        prior: [3] mean of p(x | u).
        information: [3, 3] inverse covariance of p(x | u).
        rule: [3] as `matching_rule` gives it.

    Returns:
        As `climb`.
    """
    _, matched = likelihood_at(grid, points, normals, start, rule[2], NARROW_REACH, WIDE_STRIDE)
    sure = WIDE_STRIDE * matched >= SURE_MATCH * len(points)
    found = start, 0.0, 0.0, information
    for phase in range(1 if sure else 0, 2):
        sigma, reach, stride = (rule[1], WIDE_REACH, WIDE_STRIDE) if phase == 0 else (rule[2], NARROW_REACH, 1)
        found = climb(grid, points, normals, found[0], prior, information, rule[0], sigma, reach, stride)
    return found


@inlined
def log_prior(pose: Floats, prior: Floats, information: Floats) -> float:
    """Return the log density of a Gaussian at a pose [3], without its constant."""
    away = pose - prior
    pulled = times(information, away)
    squared: float = away[0] * pulled[0] + away[1] * pulled[1] + away[2] * pulled[2]
    return -0.5 * squared
