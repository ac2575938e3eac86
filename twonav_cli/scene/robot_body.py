"""The simulated robot as the cell driver sees it: commands in, noisy odometry and ranges out."""

from __future__ import annotations

import numpy as np

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import FloatArray, Pose, Twist, relative_pose
from twonav_cli.motion import noisy_motion
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.world import World


class RobotBody:
    """Drives a World and reports what its sensors would."""

    def __init__(self, world: World, laser: RangeFinder, noise: OdometryNoise, rng: np.random.Generator) -> None:
        self.world = world
        self.touched: list[str] = []
        self.collisions = 0
        """Control periods that ended touching something, since the body was made."""
        self._laser = laser
        self._noise = noise
        self._rng = rng
        self._last = world.pose()

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw odometry's errors from a stream from here on."""
        self._rng = rng

    def settle(self) -> None:
        """Forget motion that was not driven: the robot was put somewhere."""
        self._last = self.world.pose()
        self.touched = []

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Hold a velocity for a while and note what was touched."""
        self.world.drive(twist, duration_s)
        self.touched = self.world.touching()
        self.collisions += bool(self.touched)

    def odometry(self) -> Pose:
        """Return the motion since the last call as the wheels report it, in the robot's frame (§3.1.3)."""
        now = self.world.pose()
        moved = relative_pose(self._last, now)
        self._last = now
        return noisy_motion(moved, self._noise, self._rng)

    def scan(self) -> FloatArray:
        """Return 180 ranges, metres, from -90 to +90 degrees."""
        return self._laser.scan()

    def twist(self) -> Twist:
        """Return the present velocity."""
        return self.world.twist()
