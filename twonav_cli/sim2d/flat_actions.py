"""A whole action of the 2D simulator in one compiled call: the driver's commands, the robot, its range finder."""

from __future__ import annotations

import math

import numpy as np

from twonav_cli.compiled import compiled
from twonav_cli.geometry import FloatArray, Pose, Twist
from twonav_cli.motion import NoiseRates
from twonav_cli.navigation.costmap import SAME_THING_M
from twonav_cli.navigation.drive_periods import (
    DONE,
    Board,
    DriveState,
    Setup,
    begin_drive,
    next_command,
)
from twonav_cli.sim2d.flat_body import BodyState, advance, ask_odometry, wrapped
from twonav_cli.sim2d.flat_laser import fill_scan
from twonav_cli.sim2d.flat_world import FlatWorld


@compiled
def moved_on(pose: Pose, x_m: float, y_m: float, turn_rad: float) -> Pose:
    """Return a pose after a motion that is given in its frame."""
    cos, sin = math.cos(pose.theta_rad), math.sin(pose.theta_rad)
    x, y = pose.x_m + cos * x_m - sin * y_m, pose.y_m + sin * x_m + cos * y_m
    return Pose(x, y, wrapped(pose.theta_rad + turn_rad))


@compiled
def decide(
    setup: Setup,
    board: Board,
    drives: DriveState,
    world: FlatWorld,
    bodies: BodyState,
    scan_m: FloatArray,
    believed: Pose,
    max_m: float,
    prune: bool,
) -> tuple[float, float, float]:
    """Look and return the twist of the next control period; the phase says when the action is done.

    Args:
        setup: The base and the map that the robot knows.
        board: Written.
        drives: The action's state [1], changed.
        world: The map as it is.
        bodies: The robot's state [1].
        scan_m: [180] written.
        believed: Where the robot believes to be.
        max_m: How far the range finder looks; for driving 0.7 m are enough.
        prune: Whether candidates that cannot win may be left unfinished.
    """
    body = bodies[0]
    # Also while it brakes: the period in which it stands may be the first on its way back.
    pose = (body.x_m, body.y_m, body.theta_rad)
    fill_scan(world.occupied, world.distance_m, world.grid, pose, max_m, scan_m)
    twist = Twist(body.forward_mps, body.left_mps, body.turn_radps)
    return next_command(setup, board, drives, believed, twist, scan_m, prune)


@compiled
def carry_out(
    world: FlatWorld,
    bodies: BodyState,
    rates: NoiseRates,
    errors: np.random.Generator,
    believed: Pose,
    command: tuple[float, float, float],
    duration_s: float,
) -> Pose:
    """Drive a twist for a control period; return where the robot believes to be then, by its odometry."""
    advance(world, bodies, command[0], command[1], command[2], duration_s)
    x, y, turned = ask_odometry(bodies, rates, errors)
    return moved_on(believed, x, y, turned)


@compiled
def drive_action(
    setup: Setup,
    board: Board,
    drives: DriveState,
    world: FlatWorld,
    bodies: BodyState,
    rates: NoiseRates,
    errors: np.random.Generator,
    scan_m: FloatArray,
    start: Pose,
    target_x_m: float,
    target_y_m: float,
) -> Pose:
    """Drive to a neighbouring cell's centre as `CellDriver.drive_to` does; return where the robot believes to be.

    Args:
        setup: The base and the map that the robot knows.
        board: Written.
        drives: The action's state [1]; its outcome is there in the end.
        world: The map as it is.
        bodies: The robot's state [1], moved.
        rates: Of odometry's errors.
        errors: Draws them.
        scan_m: [180] written.
        start: Where the robot believes to be.
        target_x_m, target_y_m: Where it is to go, map frame.
    """
    ask_odometry(bodies, rates, errors)
    begin_drive(setup, board, drives, start, target_x_m, target_y_m)
    believed, cut_m = start, setup.limits.range_cut_m + SAME_THING_M
    while True:
        command = decide(setup, board, drives, world, bodies, scan_m, believed, cut_m, True)
        if drives[0].phase == DONE:
            return believed
        believed = carry_out(world, bodies, rates, errors, believed, command, setup.limits.tick_s)
