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


def systematic(weights: FloatArray, rng: np.random.Generator, count: int | None = None) -> NDArray[np.int64]:
    """Return the particle [count] that each place goes on with: one draw, then even steps through the weights [P].

    Args:
        weights: They add up to 1.
        rng: One number is drawn.
        count: How many places there are; None for as many as particles.
    """
    places = len(weights) if count is None else count
    marks = (np.arange(places) + rng.random()) / places
    return np.minimum(np.searchsorted(np.cumsum(weights), marks), len(weights) - 1)
