"""Poses and twists in the plane.

World frame: x right, y up, metres; theta counter-clockwise from +x, radians.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class Pose(NamedTuple):
    """Position and heading in the map frame."""

    x_m: float
    y_m: float
    theta_rad: float


class Twist(NamedTuple):
    """Velocity in the robot's own frame: forward, to the left, counter-clockwise."""

    forward_mps: float
    left_mps: float
    turn_radps: float


def wrap_angle(angle_rad: float) -> float:
    """Return the same angle in [-pi, pi)."""
    return float((angle_rad + np.pi) % (2 * np.pi) - np.pi)


def wrap_angles(angles_rad: FloatArray) -> FloatArray:
    """Return the same angles in [-pi, pi), any shape."""
    return np.asarray((angles_rad + np.pi) % (2 * np.pi) - np.pi, dtype=np.float64)


def compose(origin: Pose, relative: Pose) -> Pose:
    """Return the pose that `relative` (given in the frame of `origin`) has in the frame of `origin`'s parent."""
    cos, sin = np.cos(origin.theta_rad), np.sin(origin.theta_rad)
    return Pose(
        float(origin.x_m + cos * relative.x_m - sin * relative.y_m),
        float(origin.y_m + sin * relative.x_m + cos * relative.y_m),
        wrap_angle(origin.theta_rad + relative.theta_rad),
    )


def relative_pose(origin: Pose, target: Pose) -> Pose:
    """Return `target` as seen from `origin`: the inverse of `compose`."""
    dx_m, dy_m = target.x_m - origin.x_m, target.y_m - origin.y_m
    cos, sin = np.cos(origin.theta_rad), np.sin(origin.theta_rad)
    return Pose(
        float(cos * dx_m + sin * dy_m),
        float(-sin * dx_m + cos * dy_m),
        wrap_angle(target.theta_rad - origin.theta_rad),
    )


def points_in_map(pose: Pose, points_robot: FloatArray) -> FloatArray:
    """Return points [N, 2] given in the robot's frame as points [N, 2] of the map frame."""
    cos, sin = np.cos(pose.theta_rad), np.sin(pose.theta_rad)
    rotation = np.array([[cos, sin], [-sin, cos]])
    return np.asarray(points_robot @ rotation + (pose.x_m, pose.y_m), dtype=np.float64)


def distance_m(a: Pose, b: Pose) -> float:
    """Return the distance between two poses' positions."""
    return float(np.hypot(a.x_m - b.x_m, a.y_m - b.y_m))
