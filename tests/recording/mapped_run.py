"""What a mapper might say: a robot drives to the right, its odometry drifts to the left, its map grows."""

from __future__ import annotations

import numpy as np

from twonav_cli.events import Clock, Event, KeyframeMapped, MapDrawn, RunEnded, RunStarted
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame

PARTICLES = 4
BEAMS = 90
STEP_M, DRIFT_M, ERROR_M = 0.5, 0.02, 0.1
"""From one keyframe to the next, to the left of it, and how far the best particle is from the truth."""


def clock_of(number: int) -> Clock:
    return Clock(step=number, time_s=2.0 * (number - 1))


def started() -> RunStarted:
    return RunStarted(Clock(), "map", "map", "corridor", 3, {"particles": str(PARTICLES)})


def best_pose(number: int) -> Pose:
    return Pose(STEP_M * (number - 1), 0.25, 0.0)


def odometry(number: int) -> Pose:
    return Pose(STEP_M * (number - 1), 0.25 + DRIFT_M * (number - 1), 0.0)


def keyframe(number: int, *, truth: bool = False, unmatched: int = 0, resampled: bool = False) -> KeyframeMapped:
    """Return a keyframe whose particles are 0, 1, 2 and 3 cm to the left of the best one; the third is heaviest."""
    pose = best_pose(number)
    poses = np.array([(pose.x_m, pose.y_m + 0.01 * index, 0.0) for index in range(PARTICLES)])
    weights = np.array([0.1, 0.2, 0.6, 0.1])
    hits = np.array([(pose.x_m + 0.01 * index, 1.5) for index in range(BEAMS)])
    effective = float(1.0 / (weights**2).sum())
    true = Pose(pose.x_m, pose.y_m - ERROR_M, 0.0) if truth else None
    return KeyframeMapped(
        clock_of(number), pose, poses, weights, effective, resampled, unmatched, hits, odometry(number), true
    )


def drawing(number: int) -> MapDrawn:
    """Return the map at a keyframe: 4 m high, as wide as the robot came, its left half unknown, a wall on top."""
    frame = GridFrame(-1.0, -1.0, 0.1, 40, 20 + 5 * number)
    pixels = np.full(frame.shape, 254, dtype=np.uint8)
    pixels[:, : frame.cols // 2] = 205
    pixels[0] = 0
    return MapDrawn(clock_of(number), pixels, frame, np.array([best_pose(n) for n in range(1, number + 1)]))


def mapped_run(keyframes: int, *, truth: bool = False) -> list[Event]:
    """Return a whole run; a drawing comes with every tenth keyframe, beginning with the first."""
    sent: list[Event] = [started()]
    for number in range(1, keyframes + 1):
        sent.append(keyframe(number, truth=truth))
        if number % 10 == 1:
            sent.append(drawing(number))
    return [*sent, RunEnded(clock_of(keyframes), "mapped")]
