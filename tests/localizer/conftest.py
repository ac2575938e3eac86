"""A toy room whose pictures are computed from the pose: four striped walls, a floor and a ceiling."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from twonav_cli.dataset.collect import Provenance, collect
from twonav_cli.dataset.plan import GRID_SET, RANDOM_SET, FramePlan, PlanConfig, plan_frames
from twonav_cli.dataset.store import FrameStore, open_store
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame

WIDTH_M, DEPTH_M = 3.0, 2.0
ROOM = GridFrame(0.0, 0.0, 0.05, 40, 60)


def toy_picture(pose: Pose) -> NDArray[np.uint8]:
    """Ray-cast the walls, one ray for each column of the picture; uint8 [84, 84, 3]."""
    bearing = pose.theta_rad + np.arctan(np.linspace(1.0, -1.0, 84))
    cos, sin = np.cos(bearing), np.sin(bearing)
    with np.errstate(divide="ignore"):
        to_x = np.where(cos > 0, (WIDTH_M - pose.x_m) / cos, -pose.x_m / cos)
        to_y = np.where(sin > 0, (DEPTH_M - pose.y_m) / sin, -pose.y_m / sin)
    distance_m = np.minimum(to_x, to_y)
    hit_x, hit_y = pose.x_m + distance_m * cos, pose.y_m + distance_m * sin
    wall = np.where(to_x < to_y, np.where(cos > 0, 0, 1), np.where(sin > 0, 2, 3))
    along = np.where(to_x < to_y, hit_y, hit_x)
    hues = np.array([[200, 60, 60], [60, 200, 60], [60, 60, 200], [200, 200, 60]])
    colour = hues[wall] * (0.6 + 0.4 * np.sin(3.0 * along + wall))[:, None]
    half_px = 30.0 / np.maximum(distance_m * np.cos(bearing - pose.theta_rad), 0.1)
    above = np.abs(np.arange(84)[:, None] - 41.5) > half_px
    picture = np.where(above[..., None], np.array([90, 90, 90]), colour[None])
    return np.clip(picture, 0, 255).astype(np.uint8)


class ToyCamera:
    """Takes the frames of the toy room; implements `Taker`."""

    def take(self, plan: FramePlan, chunk: int) -> tuple[NDArray[np.uint8], None]:
        first, end = plan.chunks[chunk]
        return np.stack([toy_picture(Pose(*(float(v) for v in pose))) for pose in plan.poses[first:end]]), None

    def close(self) -> None:
        pass


def _collected(folder: Path, name: str) -> FrameStore:
    config = PlanConfig(degree_step=60, random_frames=1200, held_out_frames=150)
    plan = plan_frames(name, np.zeros(ROOM.shape, dtype=bool), ROOM, [Pose(1.5, 1.0, 0.0)], config, seed=5)
    return open_store(collect(ToyCamera, plan, folder, Provenance("toy", "toy-digest", 5)), "toy-digest")


@pytest.fixture(scope="session")
def toy_store(tmp_path_factory: pytest.TempPathFactory) -> FrameStore:
    """Frames at random poses: 1200 to train on, 150 held out, and those of held-out cells."""
    return _collected(tmp_path_factory.mktemp("random-frames"), RANDOM_SET)


@pytest.fixture(scope="session")
def toy_grid_store(tmp_path_factory: pytest.TempPathFactory) -> FrameStore:
    """Frames of the paper's kind: on a grid, with its split."""
    return _collected(tmp_path_factory.mktemp("grid-frames"), GRID_SET)
