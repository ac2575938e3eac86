"""How far odometry can be trusted: the Gaussian p(x | u) of the filter."""

from __future__ import annotations

import math

import numpy as np

from twonav_cli.config import MappingConfig
from twonav_cli.geometry import FloatArray, Pose


def motion_covariance(config: MappingConfig, motion: Pose, theta_rad: float) -> FloatArray:
    """Return the covariance [3, 3] of where a motion by odometry ends, in the map's directions, cells and radians.

    Args:
        config: Settings.
        motion: In the robot's frame before it.
        theta_rad: Heading before it.
    """
    driven_m, turned_rad = math.hypot(motion.x_m, motion.y_m), abs(motion.theta_rad)
    place_m = math.hypot(config.error_m_per_m * driven_m, config.error_m_per_rad * turned_rad, config.error_m)
    turn_rad = math.hypot(config.error_rad_per_m * driven_m, config.error_rad_per_rad * turned_rad, config.error_rad)
    place = place_m / config.resolution_m
    # A turn that is wrong at the beginning carries the end of the motion aside.
    aside = 0.5 * driven_m / config.resolution_m
    direction = theta_rad + math.atan2(motion.y_m, motion.x_m)
    lever = np.array([-math.sin(direction) * aside, math.cos(direction) * aside, 1.0])
    return np.diag([place**2, place**2, 1e-10]) + turn_rad**2 * np.outer(lever, lever)
