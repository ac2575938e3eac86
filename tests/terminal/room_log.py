"""A made-up CARMEN log: a robot drives around in a rectangular room and scans its walls."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np

from twonav_cli.geometry import FloatArray, Pose, compose, relative_pose, wrap_angle

HALF_WIDTH_M, HALF_HEIGHT_M = 3.0, 2.0
"""Of the room, whose middle is (0, 0)."""
START = Pose(1.0, -0.8, 0.3)
FIRST_S = 1134864629.895182
BETWEEN_S = 0.2
NOTHING_M = 81.91


def angles_of(beams: int) -> FloatArray:
    """Return the directions [B] as CARMEN means them."""
    return -math.pi / 2 + np.arange(beams) * math.pi / (beams - 1 if beams % 2 else beams)


def ranges_at(pose: Pose, beams: int) -> FloatArray:
    """Return what a laser at a pose in the room measures [B], metres."""
    directions = angles_of(beams) + pose.theta_rad
    with np.errstate(divide="ignore"):
        to_side = (np.copysign(HALF_WIDTH_M, np.cos(directions)) - pose.x_m) / np.cos(directions)
        to_end = (np.copysign(HALF_HEIGHT_M, np.sin(directions)) - pose.y_m) / np.sin(directions)
    return np.minimum(to_side, to_end)


def way(scans: int) -> list[Pose]:
    """Return poses on a circle of 1.2 m to the left, 6 cm apart."""
    poses = [START]
    for _ in range(scans - 1):
        poses.append(compose(poses[-1], Pose(0.06, 0.0, 0.05)))
    return poses


def drifting(poses: list[Pose], turn_rad: float) -> list[Pose]:
    """Return what odometry makes of a way that begins at 0, when every step turns too far."""
    odometry = [Pose(0.0, 0.0, 0.0)]
    for before, after in pairwise(poses):
        moved = relative_pose(before, after)
        moved = moved._replace(theta_rad=wrap_angle(moved.theta_rad + turn_rad))
        odometry.append(compose(odometry[-1], moved))
    return odometry


def words(values: Iterable[float], digits: int) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)


def flaser(stamp_s: float, ranges_m: Iterable[float], odom: Pose, laser: Pose | None = None) -> str:
    """Return one scan as a line."""
    ranges_m = list(ranges_m)
    poses = f"{words(odom if laser is None else laser, 6)} {words(odom, 6)}"
    return f"FLASER {len(ranges_m)} {words(ranges_m, 2)} {poses} {stamp_s:.6f} robot {stamp_s - FIRST_S:.6f}"


def odom(stamp_s: float, pose: Pose) -> str:
    """Return one pose of odometry as a line."""
    return f"ODOM {words(pose, 6)} 0.3 0.0 0.0 {stamp_s:.6f} robot {stamp_s - FIRST_S:.6f}"


def room_lines(scans: int = 60, beams: int = 181, turn_rad: float = 0.0) -> list[str]:
    """Return the lines of a log of a drive through the room."""
    poses = way(scans)
    stamps = [FIRST_S + BETWEEN_S * index for index in range(scans)]
    return [
        flaser(stamp_s, ranges_at(pose, beams), odometry)
        for stamp_s, pose, odometry in zip(stamps, poses, drifting(poses, turn_rad), strict=True)
    ]
