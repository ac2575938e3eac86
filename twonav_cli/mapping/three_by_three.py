"""Linear algebra on three rows, inlined into the hot loops: general routines cost more to call and to compile."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import inlined

Floats = NDArray[np.float64]


@inlined
def times(matrix: Floats, vector: Floats) -> Floats:
    """Return the product [3] of a matrix [3, 3] and a vector [3]."""
    return np.array(
        [
            matrix[0, 0] * vector[0] + matrix[0, 1] * vector[1] + matrix[0, 2] * vector[2],
            matrix[1, 0] * vector[0] + matrix[1, 1] * vector[1] + matrix[1, 2] * vector[2],
            matrix[2, 0] * vector[0] + matrix[2, 1] * vector[1] + matrix[2, 2] * vector[2],
        ]
    )


@inlined
def solved(matrix: Floats, vector: Floats) -> Floats:
    """Return x [3] with matrix @ x = vector, for a symmetric positive matrix [3, 3]."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    low_10, low_20 = b / a, c / a
    middle = matrix[1, 1] - low_10 * b
    low_21 = (matrix[1, 2] - low_20 * b) / middle
    last = matrix[2, 2] - low_20 * c - low_21 * low_21 * middle
    y_1 = vector[1] - low_10 * vector[0]
    y_2 = vector[2] - low_20 * vector[0] - low_21 * y_1
    x_2 = y_2 / last
    x_1 = y_1 / middle - low_21 * x_2
    return np.array([vector[0] / a - low_10 * x_1 - low_20 * x_2, x_1, x_2])


@inlined
def root(matrix: Floats) -> Floats:
    """Return the lower triangular L [3, 3] with L @ L.T = matrix, for a symmetric positive matrix (Cholesky)."""
    lower = np.zeros((3, 3))
    lower[0, 0] = math.sqrt(matrix[0, 0])
    lower[1, 0], lower[2, 0] = matrix[1, 0] / lower[0, 0], matrix[2, 0] / lower[0, 0]
    lower[1, 1] = math.sqrt(matrix[1, 1] - lower[1, 0] ** 2)
    lower[2, 1] = (matrix[2, 1] - lower[2, 0] * lower[1, 0]) / lower[1, 1]
    lower[2, 2] = math.sqrt(matrix[2, 2] - lower[2, 0] ** 2 - lower[2, 1] ** 2)
    return lower


@inlined
def root_of_inverse(matrix: Floats) -> Floats:
    """Return the upper triangular U [3, 3] with U @ U.T = inverse of a symmetric positive matrix."""
    lower = root(matrix)
    upper = np.zeros((3, 3))
    for k in range(3):
        upper[k, k] = 1.0 / lower[k, k]
    upper[0, 1] = -lower[1, 0] * upper[0, 0] * upper[1, 1]
    upper[1, 2] = -lower[2, 1] * upper[1, 1] * upper[2, 2]
    upper[0, 2] = (lower[1, 0] * lower[2, 1] * upper[1, 1] - lower[2, 0]) * upper[0, 0] * upper[2, 2]
    return upper
