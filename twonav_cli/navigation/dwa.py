"""The dynamic window approach: roll out what can be reached, drop what would touch, take the cheapest (§3.1.3).

N candidates, T poses of a roll-out (rollout.py). A candidate is admissible when the robot can brake before the first
pose that touches something (Fox et al., 1997).
"""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import DriveConfig
from twonav_cli.geometry import Pose, Twist
from twonav_cli.navigation.costmap import CostMap
from twonav_cli.navigation.dwa_costs import (
    DwaWeights,
    Weights,
    heading_cost,
    path_cost,
    speed_cost,
    target_cost,
)
from twonav_cli.navigation.footprint import FloatArray, Footprint, WindowGrid, overlap, robot_footprint, touches
from twonav_cli.navigation.rollout import Rollout, braking_time_s, displacement, freeing_cost, obstacle_cost, turned
from twonav_cli.navigation.velocity_window import (
    DIFFERENTIAL_SAMPLES,
    OMNI_SAMPLES,
    Limits,
    differential_window,
    omni_window,
)

SEARCHED = 24
"""Candidates that are found one by one before the others are sorted: mostly fewer are looked at (ours)."""


class Leg(NamedTuple):
    """One straight drive: from, to, and the heading to take on the way."""

    start_x_m: float
    start_y_m: float
    target_x_m: float
    target_y_m: float
    heading_rad: float


@compiled
def stopping_cost(
    pose: Pose,
    candidate: FloatArray,
    move_s: float,
    turn_s: float,
    leg: Leg,
    curved: bool,
    forward_mps: float,
    weights: Weights,
) -> float:
    """Return the weighted sum of the cost terms that need no obstacles, at a candidate's stopping point."""
    vx, vy, turn = candidate[0], candidate[1], candidate[2]
    length = max(math.hypot(leg.target_x_m - leg.start_x_m, leg.target_y_m - leg.start_y_m), 1e-9)
    dir_x, dir_y = (leg.target_x_m - leg.start_x_m) / length, (leg.target_y_m - leg.start_y_m) / length
    dx, dy = displacement(vx, vy, turn, move_s, curved)
    x, y = pose[0] + dx, pose[1] + dy
    cost = weights.target * target_cost(x, y, leg.target_x_m, leg.target_y_m)
    cost += weights.heading * heading_cost(pose[2] + turn * turn_s, leg.heading_rad)
    cost += weights.path * path_cost(x, y, leg.start_x_m, leg.start_y_m, dir_x, dir_y)
    return cost + weights.speed * speed_cost(math.hypot(vx, vy), forward_mps)


@compiled
def fill_stopping_costs(
    candidates: FloatArray, pose: Pose, leg: Leg, curved: bool, limits: Limits, weights: Weights, costs: FloatArray
) -> FloatArray:
    """Write the stopping costs [N] of candidates [N, 3]; return the times [N] at constant speed they need to stop."""
    stop_s = np.empty(candidates.shape[0])
    for i in range(candidates.shape[0]):
        speed = math.hypot(candidates[i, 0], candidates[i, 1])
        move_s = braking_time_s(speed, limits.acceleration_mps2, limits.tick_s)
        turn_s = braking_time_s(candidates[i, 2], limits.turn_acceleration_radps2, limits.tick_s)
        stop_s[i] = max(move_s, turn_s)
        costs[i] = stopping_cost(pose, candidates[i], move_s, turn_s, leg, curved, limits.forward_mps, weights)
    return stop_s


@compiled
def best_candidate(
    candidates: FloatArray,
    pose: Pose,
    leg: Leg,
    allowed_overlap: int,
    distance_m: FloatArray,
    grid: WindowGrid,
    robot: Footprint,
    rollout: Rollout,
    limits: Limits,
    weights: Weights,
    prune: bool,
    costs: FloatArray,
) -> int:
    """Return the index of the cheapest candidate [N, 3], -1 when none is admissible; write the costs [N].

    `allowed_overlap` is 0, or how many outline points may lie on marks when the robot stands in some already. With
    `prune`, the footprint of what cannot win any more is skipped and its cost is a lower bound; the winner is the same.
    """
    stop_s = fill_stopping_costs(candidates, pose, leg, rollout.curved, limits, weights, costs)
    left_m = math.hypot(leg.target_x_m - pose[0], leg.target_y_m - pose[1])
    best, best_cost = -1, np.inf
    # Cheapest first: obstacles only add, so what begins above the best found cannot win. Spares nine tenths.
    order, left = np.empty(0, dtype=np.int64), costs.copy()
    for turn in range(costs.shape[0]):
        if turn < SEARCHED:
            i = int(np.argmin(left))
            left[i] = np.inf
        else:
            if turn == SEARCHED:
                order = np.argsort(left, kind="mergesort")
            i = int(order[turn - SEARCHED])
        if prune and costs[i] >= best_cost:
            break
        if allowed_overlap > 0:
            costs[i] += weights.overlap * freeing_cost(
                pose, candidates[i], stop_s[i], allowed_overlap, distance_m, grid, robot, rollout.curved
            )
        else:
            speed = math.hypot(candidates[i, 0], candidates[i, 1])
            end_s = max(stop_s[i], min(rollout.horizon_s, left_m / max(speed, 1e-6)))
            costs[i] += weights.clearance * obstacle_cost(
                pose, candidates[i], stop_s[i], end_s, distance_m, grid, robot, rollout
            )
        if costs[i] < best_cost:
            best, best_cost = i, costs[i]
    return best


class Planner(NamedTuple):
    """A base and how its candidates are weighed."""

    omni: bool
    robot: Footprint
    limits: Limits
    rollout: Rollout
    weights: Weights


class Choices(NamedTuple):
    """Candidates [N, 3] and their costs [N], written in place."""

    candidates: FloatArray
    costs: FloatArray


def new_choices(omni: bool) -> Choices:
    """Return room for every candidate of a base."""
    samples = math.prod(OMNI_SAMPLES) if omni else math.prod(DIFFERENTIAL_SAMPLES)
    return Choices(np.zeros((samples, 3)), np.zeros(samples))


@compiled
def overlap_at(distance_m: FloatArray, grid: WindowGrid, robot: Footprint, pose: Pose) -> int:
    """Return how many outline points lie on marks at a pose; at least 1 where the robot touches anything."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    if not touches(distance_m, grid, robot, pose[0], pose[1], cos, sin):
        return 0
    return max(overlap(distance_m, grid, robot, pose[0], pose[1], cos, sin), 1)


@compiled
def _turn_cap(limits: Limits, left_m: float, speed_mps: float) -> float:
    """Return the fastest turn that can be braked by the time the target is reached."""
    braking_s = speed_mps / limits.acceleration_mps2
    arrival_s = max(left_m - 0.5 * speed_mps * braking_s, 0.0) / limits.forward_mps + braking_s
    return limits.turn_acceleration_radps2 * arrival_s


@compiled
def sample_candidates(
    planner: Planner, pose: Pose, twist: Twist, leg: Leg, on_the_spot: bool, candidates: FloatArray
) -> int:
    """Fill candidates [N, 3] that can be reached from a twist, and return how many there are."""
    theta = pose[2]
    if not planner.omni:
        return differential_window(twist[0], twist[2], theta, on_the_spot, planner.limits, candidates)
    # While turning, a twist's velocity over the last period is the one half a turn ago (see command_of).
    vx, vy = turned(twist[0], twist[1], theta - 0.5 * twist[2] * planner.limits.tick_s)
    dx, dy = leg.target_x_m - pose[0], leg.target_y_m - pose[1]
    left_m = math.hypot(dx, dy)
    if left_m < 1e-6:
        dx, dy = turned(1.0, 0.0, theta - 0.5 * twist[2] * planner.limits.tick_s)
        left_m = 1.0
    cap = _turn_cap(planner.limits, left_m, math.hypot(vx, vy))
    return omni_window(vx, vy, twist[2], theta, dx / left_m, dy / left_m, cap, planner.limits, candidates)


@compiled
def command_of(planner: Planner, pose: Pose, candidate: FloatArray) -> tuple[float, float, float]:
    """Return the twist that drives a candidate for one period.

    An omnidirectional base turns away under its velocity: half the turn is taken back, so the chord is right.
    """
    vx, vy, turn = candidate[0], candidate[1], candidate[2]
    theta = pose[2] + (0.5 * turn * planner.limits.tick_s if planner.omni else 0.0)
    forward, left = turned(vx, vy, -theta)
    return forward, left if planner.omni else 0.0, turn


@compiled
def plan_period(
    planner: Planner,
    distance_m: FloatArray,
    grid: WindowGrid,
    pose: Pose,
    twist: Twist,
    leg: Leg,
    allowed_overlap: int,
    on_the_spot: bool,
    prune: bool,
    choices: Choices,
) -> tuple[int, int]:
    """Weigh what can be reached within one control period.

    Args:
        planner: The base.
        distance_m: [h, w] of the window.
        grid: Where the window lies.
        pose: Where the robot believes to be.
        twist: How it moves now.
        leg: Where it is to go.
        allowed_overlap: 0, or how many outline points may stay on marks (`overlap_at`).
        on_the_spot: Whether a differential base is to turn only.
        prune: Whether what cannot win may be left unfinished; the choice is the same.
        choices: Written.

    Returns:
        The index of the chosen candidate, -1 when none is admissible; and how many candidates there are.
    """
    count = sample_candidates(planner, pose, twist, leg, on_the_spot, choices.candidates)
    best = best_candidate(
        choices.candidates[:count], pose, leg, allowed_overlap, distance_m, grid, planner.robot, planner.rollout,
        planner.limits, planner.weights, prune, choices.costs[:count],
    )  # fmt: skip
    return best, count


class Plan(NamedTuple):
    """What one control period decided."""

    twist: Twist
    """What to command; standing still when nothing is admissible."""
    best: int
    """Index of the chosen candidate, -1 when none was admissible."""
    candidates: NDArray[np.float64]
    """[N, 3] a view that the next plan overwrites."""
    costs: NDArray[np.float64]
    """[N] likewise."""


def planner_for(config: DriveConfig, base: str, weights: DwaWeights | None = None) -> Planner:
    """Return how the candidates of a base ("omni" or "differential") are weighed."""
    limits = Limits(
        config.max_forward_mps,
        config.max_sideways_mps,
        config.max_turn_radps,
        config.acceleration_mps2,
        config.turn_acceleration_radps2,
        config.tick_s,
    )
    omni = base == "omni"
    rollout = Rollout(config.horizon_s, config.rollout_poses, config.inflation_m, not omni)
    return Planner(omni, robot_footprint(), limits, rollout, Weights(*astuple(weights or DwaWeights())))


class DynamicWindow:
    """Plans one control period after another for one base."""

    def __init__(self, config: DriveConfig, base: str, weights: DwaWeights | None = None) -> None:
        self.planner = planner_for(config, base, weights)
        self._choices = new_choices(self.planner.omni)

    def overlap_at(self, window: CostMap, pose: Pose) -> int:
        """Return how many outline points lie on marks at a pose."""
        return int(overlap_at(window.distance_m, window.grid, self.planner.robot, pose))

    def plan(
        self,
        window: CostMap,
        pose: Pose,
        twist: Twist,
        leg: Leg,
        allowed_overlap: int = 0,
        on_the_spot: bool = False,
        whole: bool = False,
    ) -> Plan:
        """Choose the twist of the next control period.

        Args:
            window: What stands around the robot.
            pose: Where the robot believes to be.
            twist: How it moves now.
            leg: Where it is to go.
            allowed_overlap: 0, or how many outline points may stay on marks (`overlap_at`).
            on_the_spot: Whether a differential base is to turn only.
            whole: Whether every cost must be complete, for recording; the choice is the same.
        """
        best, count = plan_period(
            self.planner, window.distance_m, window.grid, pose, twist, leg, allowed_overlap, on_the_spot, not whole,
            self._choices,
        )  # fmt: skip
        candidates, costs = self._choices.candidates[:count], self._choices.costs[:count]
        command = (0.0, 0.0, 0.0) if best < 0 else command_of(self.planner, pose, candidates[best])
        return Plan(Twist(*command), int(best), candidates, costs)


def rolled_out(planner: Planner, pose: Pose, candidates: FloatArray) -> NDArray[np.float32]:
    """Return the positions [N, T, 2] of candidates [N, 3] over the horizon, in the map frame."""
    rollout = planner.rollout
    times = np.arange(1, rollout.poses + 1) * (rollout.horizon_s / rollout.poses)
    half = 0.5 * candidates[:, 2:3] * times if rollout.curved else np.zeros((len(candidates), len(times)))
    chord = times * np.sinc(half / np.pi)
    vx, vy = candidates[:, 0:1], candidates[:, 1:2]
    x = pose.x_m + (np.cos(half) * vx - np.sin(half) * vy) * chord
    y = pose.y_m + (np.sin(half) * vx + np.cos(half) * vy) * chord
    return np.stack([x, y], axis=-1).astype(np.float32)
