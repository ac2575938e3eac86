"""A made-up drive and a made-up camera: a robot on an even floor, and beliefs that err as a network's do.

The small errors are a smooth function of the pose, so that looks near each other err alike; a few in a hundred looks
name another place, in runs of up to five.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, compose, relative_pose, wrap_angle
from twonav_cli.grid import GridFrame
from twonav_cli.motion import noisy_motion

WIDTH_M, DEPTH_M = 14.0, 9.0
FRAME = GridFrame(0.0, 0.0, 0.2, 45, 70)
STEP_M = 0.18
LONGEST_RUN = 5


def belief_at(
    places: list[tuple[float, float, float, float]],
    headings: list[tuple[float, float, float]],
    lost: float = 0.02,
) -> Belief:
    """Return a belief over places (weight, x, y, sigma) and headings (weight, theta, sigma)."""
    grid = np.zeros(FRAME.shape, dtype=np.float32)
    return Belief(np.array(places), np.array(headings), lost, WIDTH_M * DEPTH_M, grid, FRAME)


def sharp(pose: Pose, sigma_m: float = 0.05, sigma_rad: float = 0.03, lost: float = 0.02) -> Belief:
    """Return a belief in one pose."""
    return belief_at([(1.0, pose.x_m, pose.y_m, sigma_m)], [(1.0, pose.theta_rad, sigma_rad)], lost)


def random_pose(rng: np.random.Generator) -> Pose:
    """Return a pose anywhere on the floor, not at its border."""
    x_m, y_m = rng.uniform(0.5, [WIDTH_M - 0.5, DEPTH_M - 0.5])
    return Pose(float(x_m), float(y_m), float(rng.uniform(-np.pi, np.pi)))


@dataclass(frozen=True)
class Drive:
    """A drive: [N] true poses, what odometry reported since the frame before, and where the robot was carried off."""

    poses: list[Pose]
    motions: list[Pose]
    kidnapped: NDArray[np.bool_]


def drive(frames: int, seed: int, kidnap_every: int = 0) -> Drive:
    """Drive from waypoint to waypoint: turn by at most half a radian per frame, then go on."""
    rng = np.random.default_rng(seed)
    noise = OdometryNoise()
    here, goal = random_pose(rng), random_pose(rng)
    poses, motions, kidnapped = [here], [Pose(0.0, 0.0, 0.0)], np.zeros(frames, dtype=bool)
    for index in range(1, frames):
        if kidnap_every and index % kidnap_every == 0:
            kidnapped[index] = True
            here, goal, moved = random_pose(rng), random_pose(rng), Pose(0.0, 0.0, 0.0)
        else:
            turn = wrap_angle(np.arctan2(goal.y_m - here.y_m, goal.x_m - here.x_m) - here.theta_rad)
            left_m = np.hypot(goal.x_m - here.x_m, goal.y_m - here.y_m)
            turned = float(np.clip(turn, -0.5, 0.5))
            moved = Pose(0.0 if abs(turn) > 0.6 else min(STEP_M, float(left_m)), 0.0, turned)
            here = compose(here, moved)
            goal = random_pose(rng) if left_m < 0.3 else goal
        poses.append(here)
        motions.append(noisy_motion(moved, noise, rng))
    return Drive(poses, motions, kidnapped)


class MadeUpCamera:
    """Errs smoothly over the floor, with heavy tails, and now and then names another place.

    Args:
        seed: Of everything it draws.
        wrong: Share of looks that name another place.
        alike: Share of the runs of wrong looks that all name the same other place, moving along with the robot.
        sure: Share of wrong looks that are as sure as right ones.
    """

    def __init__(self, seed: int, wrong: float = 0.02, alike: float = 0.5, sure: float = 0.3) -> None:
        self._rng = np.random.default_rng(seed)
        self._begins = 2.0 * wrong / (1.0 + LONGEST_RUN)
        self._alike, self._sure = alike, sure
        self._waves = self._rng.normal(size=(4, 40, 4)) * [2.5, 2.5, 2.0, 2.0]
        self._phases = self._rng.uniform(0, 2 * np.pi, size=(4, 40))
        self._wrong_left, self._alike_now = 0, False
        self._other = self._at = Pose(0.0, 0.0, 0.0)

    def field(self, pose: Pose) -> NDArray[np.float64]:
        """Return four smooth functions of the pose [4], each with mean 0 and deviation 1 over the floor."""
        at = np.array([pose.x_m, pose.y_m, np.cos(pose.theta_rad), np.sin(pose.theta_rad)])
        return np.asarray(np.sqrt(2 / 40) * np.cos(self._waves @ at + self._phases).sum(axis=1))

    def look(self, pose: Pose) -> tuple[Belief, bool]:
        """Return what it says at a pose, and whether it names another place."""
        rng = self._rng
        if self._wrong_left == 0 and rng.random() < self._begins:
            self._wrong_left = int(rng.integers(1, LONGEST_RUN + 1))
            self._alike_now = bool(rng.random() < self._alike)
            self._other, self._at = random_pose(rng), pose
        if self._wrong_left:
            self._wrong_left -= 1
            return self._wrong(pose), True
        x, y, turn, size = self.field(pose)
        much = np.exp(0.6 * size)
        near = Pose(pose.x_m + 0.022 * much * x, pose.y_m + 0.022 * much * y, pose.theta_rad + 0.012 * much * turn)
        sigma = 0.03 * np.exp(0.6 * size + 0.3 * rng.standard_normal())
        if rng.random() < 0.1:
            other, share = random_pose(rng), rng.uniform(0.1, 0.4)
            places = [(1 - share, near.x_m, near.y_m, sigma), (share, other.x_m, other.y_m, sigma)]
            headings = [(1 - share, near.theta_rad, 0.5 * sigma), (share, other.theta_rad, 0.5 * sigma)]
            return belief_at(places, headings), False
        return sharp(near, sigma, 0.5 * sigma), False

    def _wrong(self, pose: Pose) -> Belief:
        rng = self._rng
        other = compose(self._other, relative_pose(self._at, pose)) if self._alike_now else random_pose(rng)
        if rng.random() < self._sure:
            return sharp(other, 0.05, 0.03)
        third, shares = random_pose(rng), (0.45, 0.3, 0.25)
        named = (other, pose, third)
        places = [(share, p.x_m, p.y_m, 0.1) for share, p in zip(shares, named, strict=True)]
        headings = [(share, p.theta_rad, 0.06) for share, p in zip(shares, named, strict=True)]
        return belief_at(places, headings, lost=0.1)
