"""Odometry: what the wheels report of a motion, with the paper's five error terms (§3.1.3)."""

from __future__ import annotations

import math
from dataclasses import astuple
from typing import NamedTuple

import numpy as np

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import FloatArray, Pose


class NoiseRates(NamedTuple):
    """OdometryNoise as a compiled loop takes it."""

    forward_per_m: float
    sideways_per_m: float
    turn_per_rad: float
    turn_per_m: float
    shift_per_rad: float


def noise_rates(noise: OdometryNoise) -> NoiseRates:
    """Return the five deviations of odometry's errors."""
    return NoiseRates(*astuple(noise))


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
    drawn = rng.standard_normal(6)
    return Pose(*reported_motion(relative.x_m, relative.y_m, relative.theta_rad, noise_rates(noise), drawn))


def reported_motion(
    x_m: float, y_m: float, turn_rad: float, rates: NoiseRates, drawn: FloatArray
) -> tuple[float, float, float]:
    """Return a motion with the five errors of odometry (§3.1.3), x_m, y_m and turn_rad.

    Args:
        x_m, y_m, turn_rad: The true motion, in the robot's frame before it.
        rates: Deviations after one metre or one radian.
        drawn: [6] standard normal numbers.
    """
    driven_m = math.hypot(x_m, y_m)
    direction_rad = math.atan2(y_m, x_m)
    root_m, root_rad = math.sqrt(driven_m), math.sqrt(abs(turn_rad))
    along_m = driven_m + rates.forward_per_m * root_m * drawn[0]
    across_m = rates.sideways_per_m * root_m * drawn[1]
    shift_m = rates.shift_per_rad * root_rad
    cos, sin = math.cos(direction_rad), math.sin(direction_rad)
    turned_rad = turn_rad + rates.turn_per_rad * root_rad * drawn[2] + rates.turn_per_m * root_m * drawn[3]
    return (
        cos * along_m - sin * across_m + shift_m * drawn[4],
        sin * along_m + cos * across_m + shift_m * drawn[5],
        (turned_rad + math.pi) % (2.0 * math.pi) - math.pi,
    )
