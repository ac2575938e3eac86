"""Random numbers and drawn actions inside compiled loops: a small generator, and the exploration rules on a table.

N cells, A = 4 actions, G goals.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled, inlined
from twonav_cli.rng import stream

FloatArray = NDArray[np.float64]
StateArray = NDArray[np.uint64]
NoiseArray = NDArray[np.float32]

ACTIONS = 4
NOISES = 2**13
"""Steps of the Gumbel noise: four numbers of 13 bits are cut out of 64 random ones."""

SHIFT_A, SHIFT_B, SHIFT_C = np.uint64(12), np.uint64(25), np.uint64(27)
MULTIPLIER = np.uint64(0x2545F4914F6CDD1D)
TO_53_BITS = np.uint64(11)
FIRST, SECOND, THIRD, FOURTH = np.uint64(12), np.uint64(25), np.uint64(38), np.uint64(51)
LOWEST = np.uint64(NOISES - 1)


def first_state(seed: int) -> int:
    """Return the first state of the loop's random numbers: 64 bits, never 0."""
    return int(stream(seed, "explore").integers(1, 2**63))


@inlined
def next_bits(state: StateArray) -> Any:
    """Return 64 random bits, unsigned, and move the generator on (xorshift64*, Vigna 2016)."""
    x = state[0]
    x ^= x >> SHIFT_A
    x ^= x << SHIFT_B
    x ^= x >> SHIFT_C
    state[0] = x
    return x * MULTIPLIER


@inlined
def uniform(state: StateArray) -> float:
    """Return a number in [0, 1)."""
    return float(np.int64(next_bits(state) >> TO_53_BITS)) * (1.0 / 9007199254740992.0)


@compiled
def greedy(q: FloatArray, cell: int, goal: int, state: StateArray) -> int:
    """Return an action of largest value, ties broken at random."""
    best, ties, action = q[cell, 0, goal], 1, 0
    for a in range(1, ACTIONS):
        value = q[cell, a, goal]
        if value > best:
            best, ties, action = value, 1, a
        elif value == best:
            ties += 1
            if uniform(state) * ties < 1.0:
                action = a
    return action


@lru_cache(maxsize=1)
def gumbel_noise() -> NoiseArray:
    """Return the quantiles of the Gumbel distribution at the middles of 8,192 equal steps of probability."""
    middles = (np.arange(NOISES) + 0.5) / NOISES
    return np.asarray(-np.log(-np.log(middles)), dtype=np.float32)


@inlined
def boltzmann(q: FloatArray, cell: int, goal: int, per_temperature: float, noise: NoiseArray, state: StateArray) -> int:
    """Return an action drawn from the Boltzmann probabilities (Eq. 6).

    The action of largest Q/T plus Gumbel noise has exactly these probabilities (Gumbel 1954; Maddison et al. 2014). The
    noise does not wait for the values as exponentials do, which makes the draw three times as fast. It comes in 8,192
    steps, so that it stays in the nearest cache: probabilities are right to 6e-5, and an action whose value lies
    12 T below the best is never drawn.
    """
    c, g, bits = np.uint64(cell), np.uint64(goal), next_bits(state)
    v0 = q[c, 0, g] * per_temperature + noise[(bits >> FIRST) & LOWEST]
    v1 = q[c, 1, g] * per_temperature + noise[(bits >> SECOND) & LOWEST]
    v2 = q[c, 2, g] * per_temperature + noise[(bits >> THIRD) & LOWEST]
    v3 = q[c, 3, g] * per_temperature + noise[bits >> FOURTH]
    upper, lower = (1 if v1 > v0 else 0), (3 if v3 > v2 else 2)
    return lower if max(v2, v3) > max(v0, v1) else upper


@compiled
def epsilon_greedy(q: FloatArray, cell: int, goal: int, epsilon: float, state: StateArray) -> int:
    """Return any action with probability epsilon, else a greedy one (§4.3.1)."""
    if uniform(state) < epsilon:
        return int(uniform(state) * ACTIONS)
    return greedy(q, cell, goal, state)
