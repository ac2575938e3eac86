"""Candidates rolled out into poses: where they lead, and what they would touch on the way (§3.1.3).

A differential candidate rolls out along an arc. An omnidirectional one keeps its direction in the map while its heading
turns: the next control periods would command it so.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from twonav_cli.compiled import compiled
from twonav_cli.geometry import Pose
from twonav_cli.navigation.dwa_costs import clearance_cost
from twonav_cli.navigation.footprint import FloatArray, Footprint, WindowGrid, distance_at, overlap, touches


class Rollout(NamedTuple):
    """How candidates are rolled out and judged."""

    horizon_s: float
    poses: int
    inflation_m: float
    curved: bool
    """Whether the path bends with the heading (differential) or not (omnidirectional)."""


@compiled
def braking_time_s(speed: float, deceleration: float, tick_s: float) -> float:
    """Return the time at constant speed that covers one period and the braking after it: tick + v / 2a."""
    return tick_s + 0.5 * abs(speed) / deceleration


@compiled
def displacement(vx: float, vy: float, turn: float, time_s: float, curved: bool) -> tuple[float, float]:
    """Return where (dx_m, dy_m) a candidate leads in some time: along its arc's chord, or straight."""
    if not curved:
        return vx * time_s, vy * time_s
    half = 0.5 * turn * time_s
    chord = time_s * (1.0 - half * half / 6.0 if abs(half) < 1e-3 else math.sin(half) / half)
    cos, sin = math.cos(half), math.sin(half)
    return (cos * vx - sin * vy) * chord, (sin * vx + cos * vy) * chord


@compiled
def turned(x: float, y: float, angle_rad: float) -> tuple[float, float]:
    """Return a vector turned counter-clockwise."""
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return cos * x - sin * y, sin * x + cos * y


@compiled
def swept_cost(
    pose: tuple[float, float, float],
    velocity: tuple[float, float, float],
    dt: float,
    poses: int,
    distance_m: FloatArray,
    grid: WindowGrid,
    robot: Footprint,
    rollout: Rollout,
) -> float:
    """Return the largest clearance cost of the next poses, `dt` apart; inf when the footprint touches at one."""
    x, y = pose[0], pose[1]
    step_x, step_y = displacement(velocity[0], velocity[1], velocity[2], dt, rollout.curved)
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    cos_w, sin_w = math.cos(velocity[2] * dt), math.sin(velocity[2] * dt)
    worst = 0.0
    for _ in range(poses):
        x, y = x + step_x, y + step_y
        cos, sin = cos * cos_w - sin * sin_w, sin * cos_w + cos * sin_w
        if rollout.curved:
            step_x, step_y = step_x * cos_w - step_y * sin_w, step_x * sin_w + step_y * cos_w
        if touches(distance_m, grid, robot, x, y, cos, sin):
            return np.inf
        d = distance_at(distance_m, grid, x, y)
        worst = max(worst, clearance_cost(d, robot.inscribed_m, rollout.inflation_m))
    return worst


@compiled
def obstacle_cost(
    pose: Pose,
    candidate: FloatArray,
    stop_s: float,
    end_s: float,
    distance_m: FloatArray,
    grid: WindowGrid,
    robot: Footprint,
    rollout: Rollout,
) -> float:
    """Return the clearance cost along a candidate's roll-out; inf when it cannot stop before touching something.

    Two thirds of the poses lie up to just behind the stopping point and count by their distance; a touch further on,
    before the target, counts in full.
    """
    near = max(2, 2 * rollout.poses // 3)
    far = max(rollout.poses - near, 1)
    dt = stop_s / (near - 1)
    vx, vy, turn = candidate[0], candidate[1], candidate[2]
    dx, dy = displacement(vx, vy, turn, near * dt, rollout.curved)
    x, y, theta = pose[0] + dx, pose[1] + dy, pose[2] + turn * near * dt
    # The last of the near poses first: what is going to touch mostly does so there.
    if touches(distance_m, grid, robot, x, y, math.cos(theta), math.sin(theta)):
        return np.inf
    start = (pose[0], pose[1], pose[2])
    worst = swept_cost(start, (vx, vy, turn), dt, near, distance_m, grid, robot, rollout)
    left_s = end_s - near * dt
    if left_s <= 0.0 or worst == np.inf:
        return worst
    vx, vy = turned(vx, vy, turn * near * dt if rollout.curved else 0.0)
    beyond = swept_cost((x, y, theta), (vx, vy, turn), left_s / far, far, distance_m, grid, robot, rollout)
    return 1.0 if beyond == np.inf else worst


@compiled
def freeing_cost(
    pose: Pose,
    candidate: FloatArray,
    stop_s: float,
    allowed: int,
    distance_m: FloatArray,
    grid: WindowGrid,
    robot: Footprint,
    curved: bool,
) -> float:
    """Return how many outline points stay on marks after a candidate; inf when there are more than allowed.

    For a robot that seems to stand in something: it may do what does not lead deeper.
    """
    left = 0
    for share in (0.25, 0.5, 0.75, 1.0):
        time_s = share * stop_s
        dx, dy = displacement(candidate[0], candidate[1], candidate[2], time_s, curved)
        theta = pose[2] + candidate[2] * time_s
        left = overlap(distance_m, grid, robot, pose[0] + dx, pose[1] + dy, math.cos(theta), math.sin(theta))
        if left > allowed:
            return np.inf
    return float(left)
