"""What was seen from near, and from which sides: a cell that was seen from far or from one side only is known badly.

R rows, C columns of the map.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.geometry import FloatArray, Pose, compose
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.scan import RangeSensor

SIDES = 8
"""Directions from which a cell can be seen, an eighth of a turn each (ours)."""


@compiled
def _mark_beams(
    sides: NDArray[np.uint8],
    origin: tuple[float, float],
    resolution_m: float,
    laser: tuple[float, float, float],
    angles_rad: FloatArray,
    ranges_m: FloatArray,
    near_m: float,
) -> None:
    """Set the bit of the direction it is seen from in every cell [R, C] that a beam passes or ends in, up to `near_m`.

    `origin` is the lower left corner of the map, `laser` is (x_m, y_m, theta_rad).
    """
    rows, cols = sides.shape
    step_m = 0.5 * resolution_m
    for beam in range(angles_rad.shape[0]):
        angle = laser[2] + angles_rad[beam]
        bit = np.uint8(1 << (math.floor((angle / (2 * math.pi)) % 1.0 * SIDES)) % SIDES)
        cos, sin = math.cos(angle), math.sin(angle)
        for k in range(int(min(ranges_m[beam], near_m) / step_m) + 1):
            col = math.floor((laser[0] + k * step_m * cos - origin[0]) / resolution_m)
            up = math.floor((laser[1] + k * step_m * sin - origin[1]) / resolution_m)
            if 0 <= col < cols and 0 <= up < rows:
                sides[rows - 1 - up, col] |= bit


class NearViews:
    """Which cells were seen from near, and from where.

    Attributes:
        sides: [R, C] a bit for each direction from which the cell was seen.
    """

    def __init__(self, frame: GridFrame, sensor: RangeSensor, near_m: float) -> None:
        self.sides = np.zeros(frame.shape, dtype=np.uint8)
        self._frame = frame
        self._sensor = sensor
        self._near_m = near_m

    def add(self, pose: Pose, ranges_m: FloatArray) -> None:
        """Note what a scan [B] saw from where the robot believes to be."""
        at = compose(pose, self._sensor.mount)
        origin = (self._frame.x_min_m, self._frame.y_min_m)
        laser = (at.x_m, at.y_m, at.theta_rad)
        angles_rad = self._sensor.angles_rad
        _mark_beams(self.sides, origin, self._frame.resolution_m, laser, angles_rad, ranges_m, self._near_m)

    def seen_from(self, least: int) -> NDArray[np.bool_]:
        """Return the cells [R, C] that were seen from near from at least so many directions."""
        bits = np.unpackbits(self.sides[..., None], axis=-1).sum(axis=-1)
        return np.asarray(bits >= least)
