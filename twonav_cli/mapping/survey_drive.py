"""Driving while mapping: every control period's scan and odometry go to the mapper, and its pose comes back."""

from __future__ import annotations

import math
from typing import Protocol

from twonav_cli.config import ROBOT_CIRCUMSCRIBED_M, DriveConfig
from twonav_cli.geometry import FloatArray, Pose, Twist, compose, wrap_angle
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.near_views import NearViews
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.scan import Reading, StampedPose
from twonav_cli.mapping.survey_body import SurveyBody
from twonav_cli.navigation.cell_driver import CellDriver
from twonav_cli.navigation.outcomes import REACHED

TURN_RADPS = 1.0
"""How fast the robot turns on the spot: a scan every 6 degrees (ours)."""

TURNED_RAD = 0.1
"""Nearer than this to a heading the robot has turned far enough (ours)."""

SPARE_PERIODS = 20
"""Control periods more than a turn needs, after which it is given up (ours)."""


class Mapper(Protocol):
    """What makes the map; `GridMapper` does."""

    def add(self, reading: Reading, pose_true: Pose | None = None) -> bool:
        """Take a reading."""

    def pose(self) -> Pose:
        """Return where the robot is believed to be."""

    def occupancy(self, frame: GridFrame | None = None) -> OccupancyMap:
        """Return the map."""

    def trajectory(self) -> list[StampedPose]:
        """Return the way so far."""


class SurveyDrive:
    """Moves the robot and lets the mapper hear everything.

    Attributes:
        truth: The simulator's pose at every reading, for the measurement of errors only.
    """

    def __init__(self, body: SurveyBody, mapper: Mapper, near: NearViews, config: DriveConfig, base: str) -> None:
        self.truth: list[StampedPose] = []
        self._body = body
        self._mapper = mapper
        self._near = near
        self._config = config
        self._base = base

    def hear(self, ranges_m: FloatArray | None = None) -> Pose:
        """Hand a scan [B], by default one of now, to the mapper; return where it believes the robot to be."""
        reading = self._body.reading(self._body.scan() if ranges_m is None else ranges_m)
        self.truth.append(StampedPose(reading.stamp_s, self._body.pose_true))
        self._mapper.add(reading, self._body.pose_true)
        pose = self._mapper.pose()
        self._near.add(pose, reading.ranges_m)
        return pose

    def go(self, point: tuple[float, float], map_: OccupancyMap) -> bool:
        """Drive to a point near by with the dynamic window; return whether it was reached."""
        driver = CellDriver(self._config, self._base, map_.occupied, map_.frame)
        outcome, _ = driver.drive_to(self._body, self._mapper.pose(), point, lambda _pose, scan, _trace: self._heard(scan))
        self.hear()
        return outcome == REACHED

    def _heard(self, scan_m: FloatArray) -> None:
        self.hear(scan_m)

    def turn_to(self, heading_rad: float, room_m: float) -> None:
        """Turn on the spot as far as a heading, if there is room for the robot's outline to do so."""
        if room_m < ROBOT_CIRCUMSCRIBED_M:
            return
        left_rad = wrap_angle(heading_rad - self._mapper.pose().theta_rad)
        self.turn_by(left_rad)

    def turn_by(self, angle_rad: float) -> None:
        """Turn on the spot by an angle, left if positive, as odometry says."""
        self._body.odometry()
        turned = Pose(0.0, 0.0, 0.0)
        sum_rad, tick_s = 0.0, self._config.tick_s
        periods = math.ceil(abs(angle_rad) / (TURN_RADPS * tick_s)) + SPARE_PERIODS
        while abs(angle_rad - sum_rad) > TURNED_RAD and periods > 0:
            left_rad = angle_rad - sum_rad
            speed = math.copysign(min(TURN_RADPS, abs(left_rad) / (2 * tick_s)), left_rad)
            self._body.drive(Twist(0.0, 0.0, speed), tick_s)
            moved = self._body.odometry()
            turned = compose(turned, moved)
            sum_rad += moved.theta_rad
            self.hear()
            periods -= 1
        self._body.drive(Twist(0.0, 0.0, 0.0), 2 * tick_s)
        self._body.odometry()
        self.hear()
