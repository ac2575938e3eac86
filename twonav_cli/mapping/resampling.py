"""When particles are drawn again, and which (Grisetti et al. 2007, §III-C)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.geometry import FloatArray


def normalised(log_weights: FloatArray) -> FloatArray:
    """Return weights [P] that sum to 1 from their logarithms."""
    weights = np.exp(log_weights - log_weights.max())
    return np.asarray(weights / weights.sum())


def effective_number(weights: FloatArray) -> float:
    """Return the effective number of particles, from 1 to P (Eq. 20)."""
    return float(1.0 / np.square(weights).sum())


def systematic(weights: FloatArray, rng: np.random.Generator) -> NDArray[np.int64]:
    """Return the particle [P] that each place goes on with: one draw, then even steps through the weights."""
    count = len(weights)
    marks = (np.arange(count) + rng.random()) / count
    return np.minimum(np.searchsorted(np.cumsum(weights), marks), count - 1)
