"""The localizer's errors at random poses never trained on, and on the paper's split."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.checkpoint import read_card
from twonav_cli.config import IMAGE_PX
from twonav_cli.dataset.plan import HELD_OUT, PlanConfig, plan_frames
from twonav_cli.dataset.poses import TEST
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.mapping.floor import Floor, geometry_map
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.rng import stream
from twonav_cli.scene.camera import Camera
from twonav_cli.scene.world import World

BATCH = 64


def localizer_errors(
    floor: Floor, folder: Path, frames: int, seed: int, progress: Callable[[int, int], None]
) -> dict[str, Any]:
    """Return the errors of a localizer at frames that are rendered now.

    The held-out poses come from their own random stream of `seed`, the paper's test frames are drawn from the plan that
    the localizer was trained with (the seed in its card).

    Args:
        floor: Scene and map.
        folder: The localizer's checkpoint.
        frames: Number of frames of each kind.
        seed: Seed of the held-out poses.
        progress: Told (frames done, frames wanted).

    Returns:
        "off_grid" and "paper_split", each with n, mean, median and percentiles of the errors; and, from the card, the
        same for the pose of the most alike training frame.

    Raises:
        TwonavError: No renderer, or the localizer is damaged, of another scene, or was trained on another map.
    """
    card = read_card(folder)
    estimator = Estimator.load(folder, floor.scene.digest)
    starts = list(floor.scene.starts.values())
    area = (~floor.map.free, floor.map.frame, starts)
    planned = (~_map_of_frames(floor, card.get("map_digest")).free, floor.map.frame, starts)
    held_out = plan_frames(*area, PlanConfig(degree_step=180, random_frames=1, held_out_frames=frames), seed)
    trained = plan_frames(*planned, PlanConfig(random_frames=1, held_out_frames=1), int(card["seed"]))
    on_split = np.flatnonzero((trained.kinds != HELD_OUT) & (trained.splits == TEST))
    drawn = np.sort(stream(seed, "paper split").choice(on_split, min(frames, len(on_split)), replace=False))
    off_grid = held_out.poses[held_out.kinds == HELD_OUT]
    world = World(floor.scene)
    camera = Camera(world)
    total = len(off_grid) + len(drawn)

    def errors(poses: NDArray[np.float32], before: int) -> dict[str, float]:
        estimates = []
        for first in range(0, len(poses), BATCH):
            part = poses[first : first + BATCH]
            estimates.append(estimator.estimate_many(_pictures(world, camera, part)))
            progress(before + first + len(part), total)
        return error_metrics(np.concatenate(estimates), poses)

    report = {"off_grid": errors(off_grid, 0), "paper_split": errors(trained.poses[drawn], len(off_grid))}
    camera.close()
    nearest = card["metrics"].get("off_grid_nearest_frame")
    if nearest:
        report["off_grid_nearest_frame"] = nearest  # measured after training, where the training frames are
    return {**report, "settings": {"scene": floor.scene.name, "seed": seed, "trained_with_seed": card["seed"]}}


def _map_of_frames(floor: Floor, map_digest: str | None) -> OccupancyMap:
    """Return the map on which a localizer's frames were planned: only it tells which ones it was not trained on.

    Raises:
        TwonavError: It is neither the one in use nor the geometry's.
    """
    if map_digest == floor.map.digest:
        return floor.map
    geometry = geometry_map(floor.scene)
    if map_digest not in (None, geometry.digest):
        raise TwonavError(
            "the localizer was trained on another map of the scene: name the folder of both with --checkpoints, "
            "or train it again"
        )
    return geometry


def _pictures(world: World, camera: Camera, poses: NDArray[np.float32]) -> NDArray[np.uint8]:
    """Return what the camera sees at poses [B, 3]: [B, 84, 84, 3]."""
    pictures = np.empty((len(poses), IMAGE_PX, IMAGE_PX, 3), dtype=np.uint8)
    for index, (x_m, y_m, theta_rad) in enumerate(poses):
        world.place(Pose(float(x_m), float(y_m), float(theta_rad)))
        pictures[index] = camera.image()
    return pictures
