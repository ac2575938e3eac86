"""How an action is drawn from the values of one goal in one cell.

A actions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import unknown_name

FloatArray = NDArray[np.float64]

EXPLORATIONS = ("boltzmann", "epsilon-greedy")
"""Names of the exploration rules (§4.3)."""

COOLINGS = ("per-goal", "once")
"""What the temperature does when a goal is learned: it starts anew, or it goes on falling (ours)."""

COLDEST = 1e-6
"""Temperature at which the decay ends (ours): the softmax is greedy long before, and at zero it would not exist."""


def boltzmann_probabilities(values: FloatArray, temperature: float) -> FloatArray:
    """Return the probability of every action [A] at a temperature (Eq. 6).

    The largest value is taken off first: that changes no probability and keeps the exponentials finite.
    """
    weights = np.exp((values - values.max()) / temperature)  # exp(Q(s,a)/T), up to a factor
    return np.asarray(weights / weights.sum(), dtype=np.float64)


def greedy_action(values: FloatArray, rng: np.random.Generator) -> int:
    """Return an action of largest value, ties broken at random."""
    return int(rng.choice(np.flatnonzero(values == values.max())))


def epsilon_greedy_action(values: FloatArray, epsilon: float, rng: np.random.Generator) -> int:
    """Return any action with probability epsilon, else a greedy one (§4.3)."""
    if rng.random() < epsilon:
        return int(rng.integers(len(values)))
    return greedy_action(values, rng)


def boltzmann_action(values: FloatArray, temperature: float, rng: np.random.Generator) -> int:
    """Return an action drawn from the Boltzmann probabilities (Eq. 6)."""
    cumulated = np.cumsum(boltzmann_probabilities(values, temperature))
    return min(int(np.searchsorted(cumulated, rng.random(), side="right")), len(values) - 1)


def explored_action(rule: str, values: FloatArray, temperature: float, epsilon: float, rng: np.random.Generator) -> int:
    """Return an action drawn by the named exploration rule.

    Raises:
        TwonavError: There is no such rule.
    """
    if rule == "boltzmann":
        return boltzmann_action(values, temperature, rng)
    if rule == "epsilon-greedy":
        return epsilon_greedy_action(values, epsilon, rng)
    raise unknown_name("exploration", rule, EXPLORATIONS)
