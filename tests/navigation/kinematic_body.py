"""A body without physics for tests: it follows twists exactly, and an obstacle stops it dead."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import ROBOT_FOOTPRINT_M, OdometryNoise
from twonav_cli.geometry import Pose, Twist, compose, points_in_map, relative_pose
from twonav_cli.grid import GridFrame
from twonav_cli.motion import noisy_motion

STEP_S = 0.02
RAY_STEP_M = 0.01
RAY_END_M = 0.7
BEAMS_RAD = np.linspace(-math.pi / 2, math.pi / 2, 180)


def footprint_points() -> NDArray[np.float64]:
    """Return points [N, 2] of the whole footprint: rings 3 cm apart, each in steps of at most 1 cm."""
    outline = np.array(ROBOT_FOOTPRINT_M)
    corners = np.concatenate([outline * share for share in np.arange(1.0, 0.0, -0.1)])
    ends = np.concatenate([np.roll(outline, -1, axis=0) * share for share in np.arange(1.0, 0.0, -0.1)])
    steps = np.arange(25)[:, None, None] / 25
    return np.asarray((corners + (ends - corners) * steps).reshape(-1, 2), dtype=np.float64)


def rays() -> NDArray[np.float64]:
    """Return points [180 * steps, 2] along the beams, in the robot's frame."""
    ranges = np.arange(0.1, RAY_END_M, RAY_STEP_M)
    directions = np.stack([np.cos(BEAMS_RAD), np.sin(BEAMS_RAD)], axis=1)
    return (ranges[None, :, None] * directions[:, None, :] + np.array([0.02, 0.0])).reshape(-1, 2)


class KinematicBody:
    """Integrates twists in small steps; a step into an occupied pixel is not taken."""

    def __init__(
        self,
        occupied: NDArray[np.bool_],
        frame: GridFrame,
        pose: Pose,
        noise: OdometryNoise | None = None,
        seed: int = 0,
        lag_s: float = 0.0,
    ) -> None:
        self.pose = pose
        self.touched = 0
        self.time_s = 0.0
        self.path: list[Pose] = [pose]
        self._occupied, self._frame = occupied, frame
        self._footprint, self._rays = footprint_points(), rays()
        self._twist = Twist(0.0, 0.0, 0.0)
        self._noise, self._rng = noise, np.random.default_rng(seed)
        self._reported = pose
        self._lag_s = lag_s

    def drive(self, twist: Twist, duration_s: float) -> None:
        for _ in range(round(duration_s / STEP_S)):
            share = 1.0 if self._lag_s == 0.0 else 1.0 - math.exp(-STEP_S / self._lag_s)
            self._twist = Twist(*(now + share * (asked - now) for now, asked in zip(self._twist, twist, strict=True)))
            self._step()
        self.time_s += duration_s

    def _step(self) -> None:
        forward, left, turn = self._twist
        half = 0.5 * turn * STEP_S
        chord = STEP_S * float(np.sinc(half / math.pi))
        dx = chord * (math.cos(half) * forward - math.sin(half) * left)
        dy = chord * (math.sin(half) * forward + math.cos(half) * left)
        moved = compose(self.pose, Pose(dx, dy, turn * STEP_S))
        if self.touches(moved):
            self.touched += 1
            self._twist = Twist(0.0, 0.0, 0.0)
        else:
            self.pose = moved
            self.path.append(moved)

    def touches(self, pose: Pose) -> bool:
        return bool(self._occupied_at(points_in_map(pose, self._footprint)).any())

    def _occupied_at(self, points: NDArray[np.float64]) -> NDArray[np.bool_]:
        frame = self._frame
        cols = np.floor((points[..., 0] - frame.x_min_m) / frame.resolution_m + 1e-9).astype(int)
        rows = frame.rows - 1 - np.floor((points[..., 1] - frame.y_min_m) / frame.resolution_m + 1e-9).astype(int)
        inside = (rows >= 0) & (rows < frame.rows) & (cols >= 0) & (cols < frame.cols)
        return inside & self._occupied[rows.clip(0, frame.rows - 1), cols.clip(0, frame.cols - 1)]

    def odometry(self) -> Pose:
        relative = relative_pose(self._reported, self.pose)
        self._reported = self.pose
        return relative if self._noise is None else noisy_motion(relative, self._noise, self._rng)

    def scan(self) -> NDArray[np.float64]:
        ranges = np.arange(0.1, RAY_END_M, RAY_STEP_M)
        hits = self._occupied_at(points_in_map(self.pose, self._rays)).reshape(len(BEAMS_RAD), len(ranges))
        return np.where(hits.any(axis=1), ranges[hits.argmax(axis=1)], 8.0)

    def twist(self) -> Twist:
        return self._twist
