"""Poses in cells: what the compiled loops of the mapper work in.

x and y are counted in cells from a corner of the map, y upwards; headings stay in radians. P poses.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twonav_cli.geometry import FloatArray, Pose, wrap_angle


@dataclass(frozen=True)
class CellUnits:
    """Converts between metres and cells.

    Attributes:
        resolution_m: Edge of a cell.
        corner: A point of the map frame, metres, where four cells meet.
    """

    resolution_m: float
    corner: tuple[float, float] = (0.0, 0.0)

    def of_pose(self, pose: Pose) -> FloatArray:
        """Return a pose of the map frame [3] in cells."""
        x, y = (pose.x_m - self.corner[0]) / self.resolution_m, (pose.y_m - self.corner[1]) / self.resolution_m
        return np.array([x, y, pose.theta_rad])

    def of_motion(self, motion: Pose) -> FloatArray:
        """Return a motion [3], or a place in a frame other than the map's, in cells."""
        return np.array([motion.x_m / self.resolution_m, motion.y_m / self.resolution_m, motion.theta_rad])

    def pose(self, cells: FloatArray) -> Pose:
        """Return the pose of the map frame that is given in cells [3]."""
        x_m = float(cells[0]) * self.resolution_m + self.corner[0]
        y_m = float(cells[1]) * self.resolution_m + self.corner[1]
        return Pose(x_m, y_m, wrap_angle(float(cells[2])))


def composed(poses: FloatArray, motion: FloatArray) -> FloatArray:
    """Return where poses [P, 3] come to by one motion [3] in their own frames."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    x = poses[:, 0] + cos * motion[0] - sin * motion[1]
    y = poses[:, 1] + sin * motion[0] + cos * motion[1]
    return np.column_stack([x, y, poses[:, 2] + motion[2]])
