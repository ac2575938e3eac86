"""The cost terms of the dynamic window approach, one function each (§3.1.3).

Fox, Burgard and Thrun, "The dynamic window approach to collision avoidance" (1997), score heading, clearance and speed;
the deviation from the segment between the cells is the paper's "close to the designated path". Each is about a
candidate's stopping point: where the robot would stand if it drove the candidate for one control period and braked.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

from twonav_cli.compiled import compiled


@dataclass(frozen=True)
class DwaWeights:
    """What each cost term counts (values ours; they compare with one metre to the target)."""

    target: float = 1.0
    """Per metre between the stopping point and the target."""
    heading: float = 0.1
    """Per radian between the heading after braking and the direction of travel."""
    clearance: float = 0.05
    """For standing where the robot's circle touches something; falls to nothing at the inflation distance."""
    path: float = 1.0
    """Per metre off the segment from start to target."""
    speed: float = 0.01
    """For standing still; nothing at full speed."""
    overlap: float = 0.2
    """Per outline point on a mark, when the robot seems to stand in one."""


class Weights(NamedTuple):
    """DwaWeights as the compiled loop takes them."""

    target: float
    heading: float
    clearance: float
    path: float
    speed: float
    overlap: float


@compiled
def target_cost(stop_x_m: float, stop_y_m: float, target_x_m: float, target_y_m: float) -> float:
    """Return the distance in metres from the stopping point to the target."""
    return math.hypot(target_x_m - stop_x_m, target_y_m - stop_y_m)


@compiled
def heading_cost(stop_theta_rad: float, desired_rad: float) -> float:
    """Return the angle in radians between the heading after braking and the desired one."""
    return abs((stop_theta_rad - desired_rad + math.pi) % (2.0 * math.pi) - math.pi)


@compiled
def path_cost(
    stop_x_m: float, stop_y_m: float, start_x_m: float, start_y_m: float, dir_x: float, dir_y: float
) -> float:
    """Return the distance in metres from the stopping point to the line through the start along a unit vector."""
    return abs(dir_x * (stop_y_m - start_y_m) - dir_y * (stop_x_m - start_x_m))


@compiled
def speed_cost(speed_mps: float, max_mps: float) -> float:
    """Return 1 for standing still, 0 for full speed."""
    return 1.0 - min(speed_mps / max_mps, 1.0)


@compiled
def clearance_cost(distance_m: float, inscribed_m: float, inflation_m: float) -> float:
    """Return 1 where the robot's inner circle touches something, 0 from the inflation distance on."""
    return min(max((inflation_m - distance_m) / (inflation_m - inscribed_m), 0.0), 1.0)
