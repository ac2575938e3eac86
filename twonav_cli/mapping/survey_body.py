"""The robot as a survey has it: noisy odometry that adds up from the start, and the ranges of a real range finder."""

from __future__ import annotations

import numpy as np

from twonav_cli.geometry import FloatArray, Pose, Twist, compose
from twonav_cli.mapping.scan import RangeSensor, Reading
from twonav_cli.navigation.costmap import LASER_X_M
from twonav_cli.scene.laser import BEAM_ANGLES_RAD, RangeFinder
from twonav_cli.scene.robot_body import RobotBody

CLEAR_SHARE = 0.98
"""A simulated beam that hits nothing is free up to this share of its range: noise may hide a wall at its end (ours)."""

LEAST_RANGE_M = 0.01
"""Noise makes no range shorter than this (ours)."""


def sensor_of(laser: RangeFinder) -> RangeSensor:
    """Return what the mapper must know of the robot's range finder."""
    return RangeSensor(BEAM_ANGLES_RAD, Pose(LASER_X_M, 0.0, 0.0), laser.max_m, CLEAR_SHARE * laser.max_m)


def noisy_ranges(ranges_m: FloatArray, max_m: float, noise_m: float, rng: np.random.Generator) -> FloatArray:
    """Return ranges [B] as a real range finder measures them; a beam that hit nothing still reads `max_m`."""
    noisy_m = ranges_m + noise_m * rng.standard_normal(len(ranges_m))
    return np.where(ranges_m >= max_m, max_m, np.clip(noisy_m, LEAST_RANGE_M, max_m))


class SurveyBody:
    """A simulated robot that keeps the sum of its odometry; what the cell driver drives.

    Attributes:
        pose_odom: Where odometry alone believes the robot to be, in a frame that begins at the start.
    """

    def __init__(self, body: RobotBody, max_m: float, range_noise_m: float, rng: np.random.Generator) -> None:
        """Begin where the robot stands.

        Args:
            body: What is driven; its odometry has the paper's noise.
            max_m: A beam that hits nothing reads this.
            range_noise_m: Deviation of a measured range.
            rng: Of that noise.
        """
        self.pose_odom = Pose(0.0, 0.0, 0.0)
        self._body = body
        self._max_m = max_m
        self._range_noise_m = range_noise_m
        self._rng = rng

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Hold a velocity for a while."""
        self._body.drive(twist, duration_s)

    def odometry(self) -> Pose:
        """Return the motion since the last call as the wheels report it, and add it up."""
        moved = self._body.odometry()
        self.pose_odom = compose(self.pose_odom, moved)
        return moved

    def scan(self) -> FloatArray:
        """Return 180 noisy ranges, metres; a beam that hit nothing reads the farthest."""
        return noisy_ranges(self._body.scan(), self._max_m, self._range_noise_m, self._rng)

    def twist(self) -> Twist:
        """Return the present velocity."""
        return self._body.twist()

    def reading(self, ranges_m: FloatArray) -> Reading:
        """Return a scan with the odometry and the time of now."""
        return Reading(self._body.world.time_s, self.pose_odom, ranges_m)

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return float(self._body.world.time_s)

    @property
    def pose_true(self) -> Pose:
        """The simulator's pose; nothing but a measurement of errors may look at it."""
        return self._body.world.pose()

    @property
    def collisions(self) -> int:
        """Control periods that ended touching something."""
        return self._body.collisions
