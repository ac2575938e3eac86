"""Exact Euclidean distance to the nearest marked cell, in one compiled pass per axis.

Meijster, Roerdink and Hesselink, "A general algorithm for computing distance transforms in linear time" (2000).
A local window of 64 x 64 takes some 40 us.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled


@compiled
def _column_distances(marks: NDArray[np.uint8]) -> NDArray[np.int64]:
    """Return the number of rows to the nearest mark of the same column [h, w]; h + w where there is none."""
    rows, cols = marks.shape
    far = rows + cols
    gap = np.empty((rows, cols), dtype=np.int64)
    for col in range(cols):
        gap[0, col] = 0 if marks[0, col] else far
    for row in range(1, rows):
        for col in range(cols):
            gap[row, col] = 0 if marks[row, col] else min(gap[row - 1, col] + 1, far)
    for row in range(rows - 2, -1, -1):
        for col in range(cols):
            gap[row, col] = min(gap[row, col], gap[row + 1, col] + 1)
    return gap


@compiled
def fill_distances(marks: NDArray[np.uint8], resolution_m: float, distance_m: NDArray[np.float64]) -> None:
    """Write the distance [h, w] from each cell's centre to the nearest marked cell's centre.

    Args:
        marks: [h, w], not zero where something is.
        resolution_m: Edge of a cell.
        distance_m: [h, w], written; 0 on marks, at least (h + w) cells where there are no marks at all.
    """
    rows, cols = marks.shape
    gap = _column_distances(marks)
    site = np.empty(cols, dtype=np.int64)
    begin = np.empty(cols, dtype=np.int64)
    for row in range(rows):
        g = gap[row]
        last = 0
        site[0] = 0
        begin[0] = 0
        for u in range(1, cols):
            squared = g[u] * g[u]
            while last >= 0:
                s, t = site[last], begin[last]
                if (t - s) ** 2 + g[s] * g[s] <= (t - u) ** 2 + squared:
                    break
                last -= 1
            if last < 0:
                last = 0
                site[0] = u
            else:
                s = site[last]
                from_col = 1 + (u * u - s * s + squared - g[s] * g[s]) // (2 * (u - s))
                if from_col < cols:
                    last += 1
                    site[last] = u
                    begin[last] = from_col
        for u in range(cols - 1, -1, -1):
            s = site[last]
            distance_m[row, u] = resolution_m * np.sqrt((u - s) ** 2 + g[s] * g[s])
            if u == begin[last]:
                last -= 1


def distances_m(occupied: NDArray[np.bool_], resolution_m: float) -> NDArray[np.float64]:
    """Return the distance [rows, cols] from each cell's centre to the nearest occupied cell's centre."""
    found = np.empty(occupied.shape, dtype=np.float64)
    fill_distances(np.ascontiguousarray(occupied).view(np.uint8), resolution_m, found)
    return found
