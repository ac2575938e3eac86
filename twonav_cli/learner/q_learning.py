"""The equations of Q-learning, one pure function each.

A actions, G goals. Values are float64.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]


def updated_q(q: float, reward: float, next_values: FloatArray, learning_rate: float, discount: float) -> float:
    """Return the new value of the action taken, for one goal (Eq. 1).

    Args:
        q: Q_k(s_t, a_t).
        reward: r_t.
        next_values: [A] values in the next state; zeros where the episode has ended.
        learning_rate: alpha.
        discount: gamma.
    """
    # Q(s_t,a_t) + alpha (r_t + gamma max_a Q(s_t+1,a) - Q(s_t,a_t))
    return float(q + learning_rate * (reward + discount * np.max(next_values) - q))


def td_targets(rewards: FloatArray, next_values: FloatArray, arrived: BoolArray, discount: float) -> FloatArray:
    """Return r^g + gamma max_a Q^g(s_t+1, a) for every goal [G], the target inside Eq. 2 and Eq. 3.

    Args:
        rewards: [G] r^g_t.
        next_values: [A, G] values in the next state.
        arrived: [G] True where the next state is the goal: the episode of that goal has ended and the next value is 0.
        discount: gamma.
    """
    best = np.where(arrived, 0.0, next_values.max(axis=0))  # (A, G) -> (G,)
    return np.asarray(rewards + discount * best, dtype=np.float64)


def updated_q_of_goals(q: FloatArray, targets: FloatArray, learning_rate: float) -> FloatArray:
    """Return the new values of the action taken, for every goal at once [G] (Eq. 2).

    Args:
        q: [G] Q^g_k(s_t, a_t).
        targets: [G] from `td_targets`.
        learning_rate: alpha.
    """
    # Q^g(s_t,a_t) + alpha (target^g - Q^g(s_t,a_t))
    return np.asarray(q + learning_rate * (targets - q), dtype=np.float64)


def squared_td_errors(q: FloatArray, targets: FloatArray) -> FloatArray:
    """Return the squared temporal-difference error of every goal [G] (Eq. 3).

    Args:
        q: [G] Q^g(s_t, a_t) before the update.
        targets: [G] from `td_targets`.
    """
    return np.asarray((targets - q) ** 2, dtype=np.float64)
