"""The dynamic window: the velocities that can be reached within one control period (§3.1.3).

A candidate [3] is a velocity (x_mps, y_mps) along the map's axes at the robot's present heading, and a turn in rad/s.
N candidates. The omnidirectional base is sampled along and across the direction to the target: what it will drive
most is then always among the samples.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled

FloatArray = NDArray[np.float64]

OMNI_SAMPLES = (9, 7, 9)
"""Samples along the direction to the target, across it, and of the turn (ours)."""

DIFFERENTIAL_SAMPLES = (11, 21)
"""Samples of the forward speed and of the turn (ours)."""

MAX_REVERSE_MPS = 0.2
"""How fast the differential base may back out of a place (ours)."""


class Limits(NamedTuple):
    """What the base can do."""

    forward_mps: float
    sideways_mps: float
    turn_radps: float
    acceleration_mps2: float
    turn_acceleration_radps2: float
    tick_s: float


@compiled
def sample_into(low: float, high: float, samples: FloatArray) -> None:
    """Fill samples [n] evenly from low to high; the one nearest to zero becomes zero where zero is reachable."""
    n = samples.shape[0]
    for i in range(n):
        samples[i] = low + (high - low) * i / max(n - 1, 1)
    if low <= 0.0 <= high:
        samples[np.argmin(np.abs(samples))] = 0.0


@compiled
def omni_window(
    vx_mps: float,
    vy_mps: float,
    turn_radps: float,
    theta_rad: float,
    dir_x: float,
    dir_y: float,
    turn_cap_radps: float,
    limits: Limits,
    candidates: FloatArray,
) -> int:
    """Fill candidates [N, 3] of the omnidirectional base around its velocity along the map's axes; return how many.

    The turn is kept within the cap as well, as far as braking allows.
    """
    reach = limits.acceleration_mps2 * limits.tick_s
    along0, across0 = vx_mps * dir_x + vy_mps * dir_y, -vx_mps * dir_y + vy_mps * dir_x
    along, across, turn = np.empty(OMNI_SAMPLES[0]), np.empty(OMNI_SAMPLES[1]), np.empty(OMNI_SAMPLES[2])
    sample_into(along0 - reach, along0 + reach, along)
    sample_into(across0 - reach, across0 + reach, across)
    turn_reach = limits.turn_acceleration_radps2 * limits.tick_s
    cap = min(turn_cap_radps, limits.turn_radps)
    low, high = turn_radps - turn_reach, turn_radps + turn_reach
    sample_into(min(max(low, -cap), high), max(min(high, cap), low), turn)
    cos, sin = math.cos(theta_rad), math.sin(theta_rad)
    n = 0
    for a in along:
        for c in across:
            if (a - along0) ** 2 + (c - across0) ** 2 > 1.001 * reach * reach:
                continue
            x, y = a * dir_x - c * dir_y, a * dir_y + c * dir_x
            share = math.hypot((cos * x + sin * y) / limits.forward_mps, (-sin * x + cos * y) / limits.sideways_mps)
            scale = 1.0 / max(share, 1.0)
            for w in turn:
                candidates[n, 0], candidates[n, 1], candidates[n, 2] = x * scale, y * scale, w
                n += 1
    return n


@compiled
def differential_window(
    forward_mps: float,
    turn_radps: float,
    theta_rad: float,
    on_the_spot: bool,
    limits: Limits,
    candidates: FloatArray,
) -> int:
    """Fill candidates [N, 3] of the differential base around its velocity; return how many.

    On the spot, the forward speed is braked as hard as possible and only the turn is sampled.
    """
    reach = limits.acceleration_mps2 * limits.tick_s
    low, high = max(forward_mps - reach, -MAX_REVERSE_MPS), min(forward_mps + reach, limits.forward_mps)
    low, high = min(low, forward_mps + reach), max(high, forward_mps - reach)
    forward = np.empty(1 if on_the_spot else DIFFERENTIAL_SAMPLES[0])
    if on_the_spot:
        forward[0] = min(max(0.0, low), high)
    else:
        sample_into(low, high, forward)
    turn_reach = limits.turn_acceleration_radps2 * limits.tick_s
    cap = limits.turn_radps
    turn = np.empty(DIFFERENTIAL_SAMPLES[1])
    sample_into(max(turn_radps - turn_reach, -cap), min(turn_radps + turn_reach, cap), turn)
    cos, sin = math.cos(theta_rad), math.sin(theta_rad)
    n = 0
    for v in forward:
        for w in turn:
            candidates[n, 0], candidates[n, 1], candidates[n, 2] = v * cos, v * sin, w
            n += 1
    return n
