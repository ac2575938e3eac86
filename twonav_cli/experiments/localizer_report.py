"""Everything about a localizer in numbers: single pictures, beliefs, tracks with and without the filter, kidnaps, time.

All frames are taken now; none was trained on.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.checkpoint import read_card
from twonav_cli.dataset.collect import Labels
from twonav_cli.dataset.photographer import Photographer
from twonav_cli.dataset.plan import CHUNK, GRID_SET, HELD_CELL, HELD_OUT, RANDOM_SET, FramePlan, PlanConfig, plan_frames
from twonav_cli.dataset.poses import TEST
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.calibration import calibration_report
from twonav_cli.experiments.predecessors import free_floor
from twonav_cli.experiments.tracking_report import filtered_poses, single_poses, tracking_report
from twonav_cli.experiments.tracks import drive_tracks
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.localizer.timing import milliseconds_of
from twonav_cli.mapping.floor import Floor, geometry_map
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.rng import stream

Images = NDArray[np.uint8]
Progress = Callable[[str, int, int], None]
"""Told (what is measured, frames done, frames wanted)."""


@dataclass(frozen=True)
class ReportConfig:
    """How much is measured."""

    frames: int = field(default=4000, metadata={"help": "Held-out random poses, and frames of the paper's split."})
    track_frames: int = field(default=5000, metadata={"help": "Frames along undisturbed tracks (ours)."})
    kidnap_frames: int = field(default=10_000, metadata={"help": "Frames along tracks with kidnaps (ours)."})
    kidnap_every: int = field(default=25, metadata={"help": "Frames from one kidnap to the next (ours)."})


def localizer_report(floor: Floor, folder: Path, config: ReportConfig, seed: int, progress: Progress) -> dict[str, Any]:
    """Return the figures of a localizer.

    The held-out poses come from their own random stream of `seed`; held-out cells and the paper's test frames are those
    of the plan that the localizer was trained with (the seed in its card).

    Args:
        floor: Scene and map.
        folder: The localizer's checkpoint.
        config: How much is measured.
        seed: Seed of the held-out poses and of the tracks.
        progress: Told what is measured.

    Returns:
        "off_grid", "held_cells" and "paper_split", each with n, mean, median and percentiles of the errors;
        "paper_split_by_labels": the same against what the robot says itself, as the paper measures; where the
        network gives beliefs "belief", "tracks" and "kidnaps", and "milliseconds" for one picture; and, from the card,
        the rows of the most alike training frame.

    Raises:
        TwonavError: No renderer, or the localizer is damaged, of another scene, or was trained on another map.
    """
    card = read_card(folder)
    estimator = Estimator.load(folder, floor.scene.digest)
    report: dict[str, Any] = {}
    for name, poses in _poses_of_trials(floor, card, config, seed).items():
        images, labels = _pictures(floor, poses, seed, partial(progress, name))
        estimated = estimator.estimate_many(images)
        report[name] = error_metrics(estimated, poses)
        if name == "paper_split" and labels is not None:
            known = np.isfinite(labels).all(axis=1)
            report["paper_split_by_labels"] = error_metrics(estimated[known], labels[known])
        if name == "off_grid" and estimator.gives_beliefs:
            report["belief"] = calibration_report(estimator.beliefs(images), poses, stream(seed, "calibration"))
            report["milliseconds"] = milliseconds_of(estimator, images)
    if estimator.gives_beliefs:
        report |= _driven(floor, estimator, config, seed, progress)
    nearest = {name: row for name, row in card["metrics"].items() if name.endswith("_nearest")}
    return {
        **report,
        **nearest,
        "settings": {"scene": floor.scene.name, "seed": seed, "trained_with_seed": card["seed"]},
    }


def _driven(floor: Floor, estimator: Estimator, config: ReportConfig, seed: int, progress: Progress) -> dict[str, Any]:
    """Return the figures of tracks with and without the filter, and of kidnaps."""
    free = free_floor(floor)
    found: dict[str, Any] = {}
    drives = (("tracks", config.track_frames, 0), ("kidnaps", config.kidnap_frames, config.kidnap_every))
    for name, frames, every in drives:
        if frames:
            tracks = drive_tracks(floor, seed, frames, every, progress=partial(progress, name))
            beliefs = estimator.beliefs(tracks.images)
            filtered = filtered_poses(tracks, beliefs, seed=seed, floor=free)
            found[name] = tracking_report(tracks, single_poses(beliefs), filtered)
    return found


def _poses_of_trials(
    floor: Floor, card: dict[str, Any], config: ReportConfig, seed: int
) -> dict[str, NDArray[np.float32]]:
    """Return the poses [N, 3] at which a localizer is tried, by the name of the trial."""
    trained_on = _map_of_frames(floor, card.get("map_digest"))

    def planned(name: str, map_: OccupancyMap, frames: int, plan_seed: int) -> FramePlan:
        counts = PlanConfig(random_frames=1, held_out_frames=frames)
        starts = list(floor.scene.starts.values())
        return plan_frames(name, ~map_.free, map_.frame, starts, counts, plan_seed)

    held_out = planned(RANDOM_SET, floor.map, config.frames, seed)
    in_cells = planned(RANDOM_SET, trained_on, 1, int(card["seed"]))
    grid = planned(GRID_SET, trained_on, 1, int(card["seed"]))
    on_split = np.flatnonzero(grid.splits == TEST)
    drawn = np.sort(stream(seed, "paper split").choice(on_split, min(config.frames, len(on_split)), replace=False))
    return {
        "off_grid": held_out.poses[held_out.kinds == HELD_OUT],
        "held_cells": in_cells.poses[in_cells.kinds == HELD_CELL],
        "paper_split": grid.poses[drawn],
    }


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


def _pictures(
    floor: Floor, poses: NDArray[np.float32], seed: int, progress: Callable[[int, int], None]
) -> tuple[Images, Labels | None]:
    """Return what the camera sees at poses [N, 3], and their labels [N, 3] where the robot labels on its own map."""
    chunks = np.stack([firsts := np.arange(0, len(poses), CHUNK), np.minimum(firsts + CHUNK, len(poses))], axis=1)
    kinds = np.full(len(poses), HELD_OUT, dtype=np.uint8)
    plan = FramePlan(poses, kinds, kinds, chunks, tuple(np.zeros((0, 2)) for _ in chunks))
    taken = []
    with closing(Photographer(floor, seed)) as photographer:
        for chunk, (_, end) in enumerate(chunks.tolist()):
            taken.append(photographer.take(plan, chunk))
            progress(end, len(poses))
    labels = [label for _, label in taken if label is not None]
    return np.concatenate([images for images, _ in taken]), np.concatenate(labels) if labels else None
