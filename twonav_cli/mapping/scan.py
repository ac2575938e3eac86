"""A range scan with the odometry it was taken at, and the range finder that took it.

B beams.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twonav_cli.geometry import FloatArray, Pose, compose


@dataclass(frozen=True)
class RangeSensor:
    """A planar range finder on a robot.

    Attributes:
        angles_rad: [B] direction of each beam in the sensor's own frame.
        mount: Pose of the sensor in the robot's frame.
        max_m: A reading of this or more hit nothing.
        clear_m: How far the way of a beam that hit nothing is free for sure; 0 where it may have been lost, as a real
            laser's is on glass or on black.
    """

    angles_rad: FloatArray
    mount: Pose
    max_m: float
    clear_m: float = 0.0


@dataclass(frozen=True)
class Reading:
    """One scan of a log or of a survey.

    Attributes:
        stamp_s: Time as the log gives it.
        pose_odom: Where odometry believes the robot to be, in a frame of its own.
        ranges_m: [B] measured distances; what is not a positive number was not measured.
    """

    stamp_s: float
    pose_odom: Pose
    ranges_m: FloatArray


@dataclass(frozen=True)
class StampedPose:
    """A pose of a trajectory."""

    stamp_s: float
    pose: Pose


def points_of(sensor: RangeSensor, ranges_m: FloatArray, pose: Pose, limit_m: float | None = None) -> FloatArray:
    """Return where the beams that hit something end [N, 2], map frame, metres.

    Args:
        sensor: What measured.
        ranges_m: [B].
        pose: Of the robot.
        limit_m: Leave out what is farther; default: the sensor's own limit.
    """
    hit = usable(ranges_m, sensor.max_m if limit_m is None else min(limit_m, sensor.max_m))
    at = compose(pose, sensor.mount)
    angles_rad = sensor.angles_rad[hit] + at.theta_rad
    return np.stack([at.x_m + np.cos(angles_rad) * ranges_m[hit], at.y_m + np.sin(angles_rad) * ranges_m[hit]], axis=1)


def usable(ranges_m: FloatArray, limit_m: float) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return which readings [B] are of something: a positive number below the limit."""
    with np.errstate(invalid="ignore"):
        return np.asarray((ranges_m > 0.0) & (ranges_m < limit_m))  # a comparison with NaN is False


def clear_points(sensor: RangeSensor, ranges_m: FloatArray, limit_m: float) -> FloatArray:
    """Return how far the other beams are free [N, 2], in the sensor's own frame, metres.

    A beam that hit something beyond the limit is free up to it, one that hit nothing up to the sensor's `clear_m`.
    """
    with np.errstate(invalid="ignore"):
        beyond, nothing = (ranges_m >= limit_m) & (ranges_m < sensor.max_m), ranges_m >= sensor.max_m
    free_m = np.where(beyond, limit_m, np.where(nothing, min(sensor.clear_m, limit_m), 0.0))
    some = free_m > 0.0
    angles_rad = sensor.angles_rad[some]
    return np.asarray(free_m[some, None] * np.stack([np.cos(angles_rad), np.sin(angles_rad)], axis=1))
