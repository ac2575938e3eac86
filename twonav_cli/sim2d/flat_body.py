"""The robot of the 2D simulator: it moves as it is told, until its outline would enter an occupied pixel (§3.1.3)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import FloatArray, Pose, Twist
from twonav_cli.motion import NoiseRates, noise_rates, reported_motion
from twonav_cli.navigation.footprint import touches
from twonav_cli.sim2d.flat_laser import BEAMS, fill_scan
from twonav_cli.sim2d.flat_world import FlatWorld

STEP_S = 0.02
"""Time between two places at which the outline is checked: 1.2 cm at full speed (ours)."""

SCAN_MAX_M = 8.0
"""Range of the range finder for those who watch; for driving it is cut (Fig. 5)."""

BODY = np.dtype(
    [
        ("x_m", np.float64), ("y_m", np.float64), ("theta_rad", np.float64),
        ("forward_mps", np.float64), ("left_mps", np.float64), ("turn_radps", np.float64),
        ("told_x_m", np.float64), ("told_y_m", np.float64), ("told_theta_rad", np.float64),
        ("time_s", np.float64), ("collisions", np.int64),
    ]
)  # fmt: skip
"""Where the robot is, how it moves in its own frame, where it was when odometry was asked last, the time, and in how
many control periods it ran into something."""

BodyState = NDArray[Any]
"""[1] of BODY."""

reported = compiled(reported_motion)
"""What odometry reports, compiled from the formula that the 3D simulator uses as it is."""


def new_body() -> BodyState:
    """Return a robot at the origin, at rest."""
    return np.zeros(1, dtype=BODY)


@compiled
def wrapped(angle_rad: float) -> float:
    """Return the same angle in [-pi, pi)."""
    return (angle_rad + math.pi) % (2.0 * math.pi) - math.pi


@compiled
def put(bodies: BodyState, x_m: float, y_m: float, theta_rad: float) -> None:
    """Put the robot somewhere, at rest; odometry knows nothing of it."""
    body = bodies[0]
    body.x_m, body.y_m, body.theta_rad = x_m, y_m, wrapped(theta_rad)
    body.forward_mps = body.left_mps = body.turn_radps = 0.0
    body.told_x_m, body.told_y_m, body.told_theta_rad = body.x_m, body.y_m, body.theta_rad


@compiled
def fits(world: FlatWorld, x_m: float, y_m: float, theta_rad: float) -> bool:
    """Whether the outline at a pose is free of occupied pixels."""
    cos, sin = math.cos(theta_rad), math.sin(theta_rad)
    return not touches(world.distance_m, world.grid, world.robot, x_m, y_m, cos, sin)


@compiled
def advance(world: FlatWorld, bodies: BodyState, forward: float, left: float, turn: float, duration_s: float) -> None:
    """Drive a twist for a time; a robot that would run into something stops dead before it."""
    body = bodies[0]
    body.forward_mps, body.left_mps, body.turn_radps = forward, left if world.omni else 0.0, turn
    body.time_s += duration_s
    half = 0.5 * turn * STEP_S
    chord = STEP_S * (1.0 - half * half / 6.0 if abs(half) < 1e-3 else math.sin(half) / half)
    for _ in range(round(duration_s / STEP_S)):
        cos, sin = math.cos(body.theta_rad + half), math.sin(body.theta_rad + half)
        x = body.x_m + chord * (cos * body.forward_mps - sin * body.left_mps)
        y = body.y_m + chord * (sin * body.forward_mps + cos * body.left_mps)
        theta = wrapped(body.theta_rad + 2.0 * half)
        if not fits(world, x, y, theta):
            body.forward_mps = body.left_mps = body.turn_radps = 0.0
            body.collisions += 1
            return
        body.x_m, body.y_m, body.theta_rad = x, y, theta


@compiled
def ask_odometry(bodies: BodyState, rates: NoiseRates, errors: np.random.Generator) -> tuple[float, float, float]:
    """Return the motion since the last call as the wheels report it, in the frame of then (§3.1.3)."""
    body = bodies[0]
    dx, dy = body.x_m - body.told_x_m, body.y_m - body.told_y_m
    cos, sin = math.cos(body.told_theta_rad), math.sin(body.told_theta_rad)
    turn = wrapped(body.theta_rad - body.told_theta_rad)
    body.told_x_m, body.told_y_m, body.told_theta_rad = body.x_m, body.y_m, body.theta_rad
    drawn = errors.standard_normal(6)
    return reported(cos * dx + sin * dy, -sin * dx + cos * dy, turn, rates, drawn)


class FlatBody:
    """The same robot as the cell driver sees it, period by period, for those who watch."""

    def __init__(self, world: FlatWorld, noise: OdometryNoise, errors: np.random.Generator) -> None:
        self.world = world
        self.state = new_body()
        self.rates = noise_rates(noise)
        self.errors = errors

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Drive a twist for some time."""
        advance(self.world, self.state, *twist, duration_s)

    def odometry(self) -> Pose:
        """Return the motion since the last call as the wheels report it."""
        return Pose(*ask_odometry(self.state, self.rates, self.errors))

    def scan(self) -> FloatArray:
        """Return ranges [180] from the right (-90 degrees) to the left (+90), in metres."""
        scan_m = np.empty(BEAMS)
        fill_scan(self.world.occupied, self.world.distance_m, self.world.grid, self.pose(), SCAN_MAX_M, scan_m)
        return scan_m

    def twist(self) -> Twist:
        """Return how it moves now."""
        state = self.state[0]
        return Twist(float(state["forward_mps"]), float(state["left_mps"]), float(state["turn_radps"]))

    def pose(self) -> Pose:
        """Return where it is."""
        state = self.state[0]
        return Pose(float(state["x_m"]), float(state["y_m"]), float(state["theta_rad"]))
