"""The direction across the surface that a scan shows at the end of each beam.

N beams that hit something. Lengths are in metres.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled

NEIGHBOUR_BEAMS = 3
"""Beams on each side from which the direction of a surface is taken (ours)."""

NEIGHBOUR_M = 0.4
"""Ends farther apart belong to different surfaces, metres (ours)."""

LEAST_ENDS = 4
"""Fewer ends show no surface (ours)."""

FLATNESS = 0.6
"""Of the ends' variance, how much more must lie along the surface than across it (ours)."""

Floats = NDArray[np.float64]


def surface_normals(points: Floats) -> Floats:
    """Return the direction [N, 2] across the surface at each end of a beam; (0, 0) where the scan shows none.

    Args:
        points: [N, 2] ends in the order of the beams.
    """
    normals = np.zeros_like(points)
    _fill_normals(points, normals)
    return normals


@compiled
def _fill_normals(points: Floats, normals: Floats) -> None:
    """Write the smaller principal direction [N, 2] of the ends around each end."""
    for i in range(len(points)):
        count, sum_x, sum_y, xx, xy, yy = 0, 0.0, 0.0, 0.0, 0.0, 0.0
        for j in range(max(0, i - NEIGHBOUR_BEAMS), min(len(points), i + NEIGHBOUR_BEAMS + 1)):
            x, y = points[j, 0] - points[i, 0], points[j, 1] - points[i, 1]
            if x * x + y * y < NEIGHBOUR_M * NEIGHBOUR_M:
                count += 1
                sum_x += x
                sum_y += y
                xx += x * x
                xy += x * y
                yy += y * y
        if count < LEAST_ENDS:
            continue
        xx, xy, yy = xx - sum_x * sum_x / count, xy - sum_x * sum_y / count, yy - sum_y * sum_y / count
        mean, half_gap = (xx + yy) / 2, np.sqrt(((xx - yy) / 2) ** 2 + xy * xy)
        if half_gap < FLATNESS * mean:
            continue
        angle = 0.5 * np.arctan2(2 * xy, xx - yy) + np.pi / 2
        normals[i, 0], normals[i, 1] = np.cos(angle), np.sin(angle)
