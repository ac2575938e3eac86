"""Driving while mapping: every control period's scan and odometry go to the mapper, and its pose comes back."""

from __future__ import annotations

import math
from typing import Protocol

from twonav_cli.config import DriveConfig
from twonav_cli.events import DriveTrace
from twonav_cli.geometry import FloatArray, Pose, Twist, wrap_angle
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

    def walls(self) -> FloatArray:
        """Return points [K, 2] on what is occupied, metres."""


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

        def on_tick(believed: Pose, scan_m: FloatArray, trace: DriveTrace | None) -> None:
            self.hear(scan_m)

        outcome, _ = driver.drive_to(self._body, self._mapper.pose(), point, on_tick)
        self.hear()
        return outcome == REACHED

    def turn_to(self, heading_rad: float) -> None:
        """Turn on the spot to a heading, the shorter way round."""
        self.turn_by(wrap_angle(heading_rad - self._mapper.pose().theta_rad))

    def turn_by(self, angle_rad: float) -> None:
        """Turn on the spot by an angle, to the left if positive, as odometry reports it."""
        tick_s = self._config.tick_s
        self._body.odometry()
        left_rad = angle_rad
        for _ in range(math.ceil(abs(angle_rad) / (TURN_RADPS * tick_s)) + SPARE_PERIODS):
            if abs(left_rad) < TURNED_RAD:
                break
            speed_radps = math.copysign(min(TURN_RADPS, 0.5 * abs(left_rad) / tick_s), left_rad)
            left_rad -= self._driven(Twist(0.0, 0.0, speed_radps), tick_s)
        self._driven(Twist(0.0, 0.0, 0.0), 2 * tick_s)

    def _driven(self, twist: Twist, duration_s: float) -> float:
        """Hold a velocity for a while, let the mapper hear, and return the angle turned."""
        self._body.drive(twist, duration_s)
        turned_rad = self._body.odometry().theta_rad
        self.hear()
        return turned_rad
