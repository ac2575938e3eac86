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
from twonav_cli.navigation.rollout import Rollout, braking_time_s, displacement, freeing_cost, obstacle_cost
from twonav_cli.navigation.velocity_window import (
    DIFFERENTIAL_SAMPLES,
    OMNI_SAMPLES,
    Limits,
    differential_window,
    omni_window,
)


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
    for i in np.argsort(costs, kind="mergesort"):
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


class DynamicWindow:
    """Plans one control period after another for one base."""

    def __init__(self, config: DriveConfig, base: str, weights: DwaWeights | None = None) -> None:
        self.omni = base == "omni"
        self.robot = robot_footprint()
        self.limits = Limits(
            config.max_forward_mps,
            config.max_sideways_mps,
            config.max_turn_radps,
            config.acceleration_mps2,
            config.turn_acceleration_radps2,
            config.tick_s,
        )
        self.rollout = Rollout(config.horizon_s, config.rollout_poses, config.inflation_m, not self.omni)
        self._weights = Weights(*astuple(weights or DwaWeights()))
        samples = math.prod(OMNI_SAMPLES) if self.omni else math.prod(DIFFERENTIAL_SAMPLES)
        self._candidates = np.zeros((samples, 3))
        self._costs = np.zeros(samples)

    def overlap_at(self, window: CostMap, pose: Pose) -> int:
        """Return how many outline points lie on marks at a pose."""
        cos, sin = math.cos(pose.theta_rad), math.sin(pose.theta_rad)
        if not touches(window.distance_m, window.grid, self.robot, pose.x_m, pose.y_m, cos, sin):
            return 0
        found = overlap(window.distance_m, window.grid, self.robot, pose.x_m, pose.y_m, cos, sin)
        return max(int(found), 1)

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
        n = self._sample(pose, twist, leg, on_the_spot)
        candidates, costs = self._candidates[:n], self._costs[:n]
        best = best_candidate(
            candidates,
            pose,
            leg,
            allowed_overlap,
            window.distance_m,
            window.grid,
            self.robot,
            self.rollout,
            self.limits,
            self._weights,
            not whole,
            costs,
        )
        chosen = Twist(0.0, 0.0, 0.0) if best < 0 else self._command(pose, candidates[best])
        return Plan(chosen, int(best), candidates, costs)

    def _sample(self, pose: Pose, twist: Twist, leg: Leg, on_the_spot: bool) -> int:
        """Fill the candidates and return how many there are."""
        theta = pose.theta_rad
        if not self.omni:
            return int(
                differential_window(
                    twist.forward_mps, twist.turn_radps, theta, on_the_spot, self.limits, self._candidates
                )
            )
        # While turning, a twist's velocity over the last period is the one half a turn ago (see _command).
        before = theta - 0.5 * twist.turn_radps * self.limits.tick_s
        cos, sin = math.cos(before), math.sin(before)
        vx, vy = cos * twist.forward_mps - sin * twist.left_mps, sin * twist.forward_mps + cos * twist.left_mps
        dx, dy = leg.target_x_m - pose.x_m, leg.target_y_m - pose.y_m
        left_m = math.hypot(dx, dy)
        if left_m < 1e-6:
            dx, dy, left_m = cos, sin, 1.0
        cap = self._turn_cap(left_m, math.hypot(vx, vy))
        return int(
            omni_window(vx, vy, twist.turn_radps, theta, dx / left_m, dy / left_m, cap, self.limits, self._candidates)
        )

    def _turn_cap(self, left_m: float, speed_mps: float) -> float:
        """Return the fastest turn that can be braked by the time the target is reached."""
        limits = self.limits
        braking_s = speed_mps / limits.acceleration_mps2
        arrival_s = max(left_m - 0.5 * speed_mps * braking_s, 0.0) / limits.forward_mps + braking_s
        return limits.turn_acceleration_radps2 * arrival_s

    def _command(self, pose: Pose, candidate: FloatArray) -> Twist:
        """Return the twist that drives a candidate for one period.

        An omnidirectional base turns away under its velocity: half the turn is taken back, so the chord is right.
        """
        vx, vy, turn = (float(v) for v in candidate)
        theta = pose.theta_rad + (0.5 * turn * self.limits.tick_s if self.omni else 0.0)
        cos, sin = math.cos(theta), math.sin(theta)
        return Twist(cos * vx + sin * vy, -sin * vx + cos * vy if self.omni else 0.0, turn)

    def rolled_out(self, pose: Pose, candidates: FloatArray) -> NDArray[np.float32]:
        """Return the positions [N, T, 2] of candidates [N, 3] over the horizon, in the map frame."""
        times = np.arange(1, self.rollout.poses + 1) * (self.rollout.horizon_s / self.rollout.poses)
        half = 0.5 * candidates[:, 2:3] * times if self.rollout.curved else np.zeros((len(candidates), len(times)))
        chord = times * np.sinc(half / np.pi)
        vx, vy = candidates[:, 0:1], candidates[:, 1:2]
        x = pose.x_m + (np.cos(half) * vx - np.sin(half) * vy) * chord
        y = pose.y_m + (np.sin(half) * vx + np.cos(half) * vy) * chord
        return np.stack([x, y], axis=-1).astype(np.float32)
