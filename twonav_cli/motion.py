"""Odometry: what the wheels report of a motion, with the paper's five error terms (§3.1.3)."""

from __future__ import annotations

import math

import numpy as np

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, wrap_angle


def noisy_motion(relative: Pose, noise: OdometryNoise, rng: np.random.Generator) -> Pose:
    """Return what odometry reports of one motion (§3.1.3).

    The paper names five errors: along and across the motion, of the heading, and two that couple them (driving turns
    the robot a little, turning shifts it). A variance grows with the distance driven or the angle turned, so that a
    metre in ten control periods is as uncertain as a metre in one; the rates are the deviations after one metre and
    one radian (ours, the paper gives no law).

    Args:
        relative: True motion, in the robot's frame before it.
        noise: Deviation of each term after one metre or one radian.
        rng: Six numbers are drawn whatever the motion is, so that streams stay in step.

    Returns:
        The reported motion in the same frame; no motion is reported as none.
    """
    along, across, turning, veering, skid_x, skid_y = (float(e) for e in rng.standard_normal(6))
    driven_m = math.hypot(relative.x_m, relative.y_m)
    direction_rad = math.atan2(relative.y_m, relative.x_m)
    root_m, root_rad = math.sqrt(driven_m), math.sqrt(abs(relative.theta_rad))
    along_m = driven_m + noise.forward_per_m * root_m * along
    across_m = noise.sideways_per_m * root_m * across
    shift_m = noise.shift_per_rad * root_rad
    cos, sin = math.cos(direction_rad), math.sin(direction_rad)
    turn_error_rad = noise.turn_per_rad * root_rad * turning + noise.turn_per_m * root_m * veering
    return Pose(
        cos * along_m - sin * across_m + shift_m * skid_x,
        sin * along_m + cos * across_m + shift_m * skid_y,
        wrap_angle(relative.theta_rad + turn_error_rad),
    )
