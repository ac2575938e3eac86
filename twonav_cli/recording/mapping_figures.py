"""What a keyframe of the mapper tells in numbers: how sure it is, how much it corrected odometry, how wrong it is.

P particles, K keyframes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from twonav_cli.events import KeyframeMapped
from twonav_cli.geometry import FloatArray, Pose, compose, distance_m, relative_pose, wrap_angle, wrap_angles

DIGITS = 9


@dataclass(frozen=True)
class KeyframeFigures:
    """The numbers of one keyframe; also a row of /keyframes."""

    number: int
    time_s: float
    x_m: float
    """Of the best particle, map frame."""
    y_m: float
    theta_rad: float
    particles: int
    effective: float
    resampled: bool
    unmatched: int
    spread_m: float
    """Weighted standard deviation of the particles' positions."""
    spread_deg: float
    correction_m: float
    """How far the best pose lies from where odometry alone leads from the best pose before."""
    correction_deg: float
    from_odometry_m: float
    """How far it lies from where odometry alone leads from the start."""
    from_odometry_deg: float
    error_m: float
    """How far it lies from the truth, not a number where there is none."""
    error_deg: float


def figures_of(event: KeyframeMapped, before: KeyframeMapped | None) -> KeyframeFigures:
    """Return the numbers of a keyframe, given the one before it."""
    pose, true = event.pose, event.pose_true
    spread_m, spread_rad = spread(event.poses, event.weights)
    expected = pose if before is None else compose(before.pose, relative_pose(before.pose_odom, event.pose_odom))
    return KeyframeFigures(
        number=event.clock.step,
        time_s=event.clock.time_s,
        x_m=pose.x_m,
        y_m=pose.y_m,
        theta_rad=pose.theta_rad,
        particles=len(event.weights),
        effective=float(event.effective),
        resampled=bool(event.resampled),
        unmatched=int(event.unmatched),
        spread_m=spread_m,
        spread_deg=math.degrees(spread_rad),
        correction_m=distance_m(expected, pose),
        correction_deg=_turn_deg(expected, pose),
        from_odometry_m=distance_m(event.pose_odom, pose),
        from_odometry_deg=_turn_deg(event.pose_odom, pose),
        error_m=math.nan if true is None else distance_m(true, pose),
        error_deg=math.nan if true is None else _turn_deg(true, pose),
    )


def spread(poses: FloatArray, weights: FloatArray) -> tuple[float, float]:
    """Return the weighted standard deviations of poses [P, 3]: of the position (m) and of the heading (rad)."""
    share = weights / weights.sum()
    mean = share @ poses[:, :2]
    heading_rad = math.atan2(share @ np.sin(poses[:, 2]), share @ np.cos(poses[:, 2]))
    away_m2 = ((poses[:, :2] - mean) ** 2).sum(axis=1)
    away_rad2 = wrap_angles(poses[:, 2] - heading_rad) ** 2
    # Particles that are all the same differ by rounding, which no plot should be about.
    return round(math.sqrt(share @ away_m2), DIGITS), round(math.sqrt(share @ away_rad2), DIGITS)


def moved_most(before: FloatArray, now: FloatArray) -> tuple[int, float]:
    """Return which keyframe [0, K) of a path moved most between two drawings [K, 3], and how far (m)."""
    both = min(len(before), len(now))
    if both == 0:
        return 0, 0.0
    away_m = np.hypot(*(now[:both, :2] - before[:both, :2]).T)
    most = int(away_m.argmax())
    return most, float(away_m[most])


def _turn_deg(a: Pose, b: Pose) -> float:
    return abs(math.degrees(wrap_angle(b.theta_rad - a.theta_rad)))
