"""A mapper that is told where the robot is: for tests of the survey that are not about mapping."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.geometry import FloatArray, Pose, compose
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from twonav_cli.mapping.scan import RangeSensor, Reading, StampedPose, usable

STEP_M = 0.02
SHORT_M = 0.06
"""A beam passes no cell nearer to its end than this."""

Grid = NDArray[np.bool_]


class TrueMapper:
    """Puts every third reading into one map from the simulator's pose."""

    def __init__(self, frame: GridFrame, sensor: RangeSensor) -> None:
        self.frame = frame
        self.sensor = sensor
        self.readings: list[Reading] = []
        self._path: list[StampedPose] = []
        self._hit = np.zeros(frame.shape, dtype=np.bool_)
        self._passed = np.zeros(frame.shape, dtype=np.bool_)

    def add(self, reading: Reading, pose_true: Pose | None = None) -> bool:
        assert pose_true is not None
        self.readings.append(reading)
        self._path.append(StampedPose(reading.stamp_s, pose_true))
        if len(self.readings) % 3 == 1:
            self._carve(reading, compose(pose_true, self.sensor.mount))
        return True

    def _carve(self, reading: Reading, laser: Pose) -> None:
        ranges_m = reading.ranges_m[:, None]  # [B, 1]
        along_m = np.arange(0.0, self.sensor.max_m, STEP_M)[None]  # [1, steps]
        self._mark(self._passed, laser, along_m, along_m < ranges_m - SHORT_M)
        self._mark(self._hit, laser, ranges_m, usable(reading.ranges_m, self.sensor.max_m)[:, None])

    def _mark(self, cells: Grid, laser: Pose, distances_m: FloatArray, keep: Grid) -> None:
        angles_rad = self.sensor.angles_rad[:, None] + laser.theta_rad
        x_m, y_m = laser.x_m + np.cos(angles_rad) * distances_m, laser.y_m + np.sin(angles_rad) * distances_m
        cols = np.floor((x_m - self.frame.x_min_m) / self.frame.resolution_m).astype(int)
        rows = self.frame.rows - 1 - np.floor((y_m - self.frame.y_min_m) / self.frame.resolution_m).astype(int)
        inside = keep & (rows >= 0) & (rows < self.frame.rows) & (cols >= 0) & (cols < self.frame.cols)
        cells[rows[inside], cols[inside]] = True

    def pose(self) -> Pose:
        return self._path[-1].pose

    def trajectory(self) -> list[StampedPose]:
        return self._path

    def walls(self) -> FloatArray:
        rows, cols = np.nonzero(self._hit)
        xs_m, ys_m = self.frame.centres()
        return np.stack([xs_m[cols], ys_m[rows]], axis=1)

    def occupancy(self, frame: GridFrame | None = None) -> OccupancyMap:
        assert frame in (None, self.frame)
        pixels = np.where(self._hit, OCCUPIED, np.where(self._passed, FREE, UNKNOWN)).astype(np.uint8)
        return OccupancyMap(self.frame, pixels)
