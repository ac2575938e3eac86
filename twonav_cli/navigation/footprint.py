"""The robot's outline as points, and whether it touches marked cells at a pose (§3.1.3).

N points of a ring, h x w cells of the local window. A ring's points lie at most a spacing apart, so a point that
is `d` from the nearest mark clears the next `d / spacing` points of its ring without looking at them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import ROBOT_FOOTPRINT_M

FloatArray = NDArray[np.float64]

OUTLINE_SPACING_M = 0.01
"""Points of the outline lie at most this far apart; a mark's corner can reach half of it between two (ours)."""

INNER_SPACING_M = 0.02
"""Points of the rings inside: less than a cell of the window (ours)."""

OUTLINE_MARGIN_M = 0.005
"""The controller's outline is grown a little because of the spacing (ours)."""

RING_DEPTHS_M = (0.0, 0.04, 0.08)
"""The rings inside the outline find a lone map pixel of 5 cm that no point of the outline is on (ours)."""


class WindowGrid(NamedTuple):
    """Where the local window lies: lower left corner in the map frame, and the edge of a cell."""

    x_min_m: float
    y_min_m: float
    resolution_m: float


class Footprint(NamedTuple):
    """Three rings of points [N, 2] in the robot's frame, the outline first, and two radii about its axis."""

    rings: tuple[FloatArray, FloatArray, FloatArray]
    inscribed_m: float
    circumscribed_m: float


def grown_outline(outline_m: FloatArray, margin_m: float) -> FloatArray:
    """Return a convex counter-clockwise polygon [N, 2] with every edge moved outwards by a margin (inwards if < 0)."""
    edges = np.roll(outline_m, -1, axis=0) - outline_m
    normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.linalg.norm(edges, axis=1, keepdims=True)
    offsets = np.sum(normals * outline_m, axis=1) + margin_m
    corners = [
        np.linalg.solve(np.stack([normals[i - 1], normals[i]]), np.array([offsets[i - 1], offsets[i]]))
        for i in range(len(outline_m))
    ]
    return np.asarray(corners, dtype=np.float64)


def ring_points(outline_m: FloatArray, spacing_m: float) -> FloatArray:
    """Return points [N, 2] along a closed polygon, its corners among them, at most `spacing_m` apart."""
    parts = []
    for a, b in zip(outline_m, np.roll(outline_m, -1, axis=0), strict=True):
        steps = max(1, math.ceil(float(np.linalg.norm(b - a)) / spacing_m))
        parts.append(a + (b - a) * (np.arange(steps) / steps)[:, None])
    return np.concatenate(parts).astype(np.float64)


def robot_footprint(grown_m: float = OUTLINE_MARGIN_M) -> Footprint:
    """Return the rings of the robot (config.ROBOT_FOOTPRINT_M), its outline grown by a margin."""
    outline = np.array(ROBOT_FOOTPRINT_M)
    outer, inner, innermost = (
        ring_points(grown_outline(outline, grown_m - depth_m), INNER_SPACING_M if depth_m else OUTLINE_SPACING_M)
        for depth_m in RING_DEPTHS_M
    )
    radii = np.linalg.norm(outer, axis=1)
    return Footprint((outer, inner, innermost), float(radii.min()), float(radii.max()))


@compiled
def distance_at(distance_m: FloatArray, grid: WindowGrid, x_m: float, y_m: float) -> float:
    """Return the distance of the cell that holds a point; far away outside the window."""
    u = (x_m - grid.x_min_m) / grid.resolution_m
    v = (y_m - grid.y_min_m) / grid.resolution_m
    rows, cols = distance_m.shape
    if u < 0.0 or v < 0.0 or u >= cols or v >= rows:
        return 1e3
    return float(distance_m[rows - 1 - int(v), int(u)])


@compiled
def marked_points(
    distance_m: FloatArray,
    grid: WindowGrid,
    robot: Footprint,
    x_m: float,
    y_m: float,
    cos: float,
    sin: float,
    enough: int,
) -> int:
    """Return how many points of the rings lie on marks, up to `enough`; far from marks most points are skipped."""
    # Both the point and the mark may lie half a diagonal from their cells' centres.
    slack_m = grid.resolution_m * 1.4143
    found = 0
    for k in range(len(robot.rings)):
        ring = robot.rings[k]
        spacing_m = OUTLINE_SPACING_M if k == 0 else INNER_SPACING_M
        i = 0
        while i < ring.shape[0]:
            px, py = ring[i, 0], ring[i, 1]
            d = distance_at(distance_m, grid, x_m + cos * px - sin * py, y_m + sin * px + cos * py)
            if d == 0.0:
                found += 1
                if found >= enough:
                    return found
            i += max(1, int((d - slack_m) / spacing_m))
    return found


@compiled
def touches(
    distance_m: FloatArray, grid: WindowGrid, robot: Footprint, x_m: float, y_m: float, cos: float, sin: float
) -> bool:
    """Whether the footprint at a pose touches a mark (§3.1.3)."""
    half_m = grid.resolution_m * 0.70711
    d = distance_at(distance_m, grid, x_m, y_m)
    if d - 2.0 * half_m > robot.circumscribed_m:
        return False
    if d + half_m < robot.inscribed_m:
        return True
    return marked_points(distance_m, grid, robot, x_m, y_m, cos, sin, 1) > 0


@compiled
def overlap(
    distance_m: FloatArray, grid: WindowGrid, robot: Footprint, x_m: float, y_m: float, cos: float, sin: float
) -> int:
    """Return how many points of the rings lie on marks: how deep the robot seems to stand in something."""
    if distance_at(distance_m, grid, x_m, y_m) - grid.resolution_m * 1.4143 > robot.circumscribed_m:
        return 0
    return marked_points(distance_m, grid, robot, x_m, y_m, cos, sin, 100_000)
