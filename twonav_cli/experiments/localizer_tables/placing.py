"""Where a network, or the most alike frame, places the pictures of a selection; kept in a file, since it takes minutes.

N frames.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.checkpoint import read_card
from twonav_cli.dataset.store import FrameStore, Indices
from twonav_cli.files import digest_of, write_whole
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.localizer.nearest import nearest_poses
from twonav_cli.worker_pool import StoppedError

NEAREST_FRAMES = 20_000
"""Frames at most that are placed by the most alike one: in the apartment that takes a minute or two."""

Poses = NDArray[np.float32]


@dataclass(frozen=True)
class Locator:
    """Something that gives pictures a pose.

    Attributes:
        identity: What it is; another one has another.
        place: Gives the poses [N, 3] of some frames of a store.
        portion: Frames that it is given at a time.
    """

    identity: str
    place: Callable[[FrameStore, Indices], NDArray[Any]]
    portion: int


def network_locator(folder: Path, scene_digest: str) -> Locator:
    """Return the network of a checkpoint.

    Raises:
        TwonavError: It is missing, damaged, or of another scene.
    """
    estimator = Estimator.load(folder, scene_digest)

    def place(store: FrameStore, frames: Indices) -> NDArray[Any]:
        return estimator.estimate_many(np.asarray(store.frames[frames]))

    return Locator(read_card(folder)["sha256"], place, portion=256)


def nearest_locator(training: Selection) -> Locator:
    """Return what gives each picture the pose of the most alike training frame."""
    store, known = training

    def place(queried: FrameStore, frames: Indices) -> NDArray[Any]:
        return nearest_poses(store, known, frames, queried)

    return Locator(f"nearest {_identity(training)}", place, portion=5_000)


def placed(
    locator: Locator,
    selection: Selection,
    file: Path,
    should_stop: Callable[[], bool],
    on_done: Callable[[int], None] = lambda done: None,
) -> Poses:
    """Return the poses [N, 3] of a selection: from the file when they are in it, else worked out and written there.

    Args:
        locator: Who places.
        selection: What.
        file: Where the poses are kept.
        should_stop: Asked after every portion.
        on_done: Told how many frames are placed.

    Raises:
        StoppedError: `should_stop` said so.
        TwonavError: The file cannot be written.
    """
    from safetensors.numpy import save

    facts = {"locator": locator.identity, "frames": _identity(selection)}
    store, frames = selection
    poses = _kept(file, facts)
    if poses is None:
        parts = [np.zeros((0, 3), dtype=np.float32)]
        for start in range(0, len(frames), locator.portion):
            if should_stop():
                raise StoppedError
            parts.append(locator.place(store, frames[start : start + locator.portion]).astype(np.float32))
            on_done(min(start + locator.portion, len(frames)))
        poses = np.concatenate(parts)
        write_whole(file, save({"poses": poses}, metadata={"facts": json.dumps(facts)}))
    on_done(len(frames))
    return poses


def errors_at(poses: Poses, selection: Selection) -> dict[str, float]:
    """Return the errors of poses [N, 3] against where the robot stood (`error_metrics`)."""
    store, frames = selection
    return error_metrics(poses, store.poses[frames])


def _identity(selection: Selection) -> str:
    store, frames = selection
    return digest_of([json.dumps(store.meta, sort_keys=True).encode(), frames.tobytes()])


def _kept(file: Path, facts: dict[str, str]) -> Poses | None:
    """Return the poses in a file; None where there are none, or those of something else."""
    from safetensors import SafetensorError, safe_open

    if not file.is_file():
        return None
    try:
        with safe_open(file, framework="numpy") as opened:
            same = json.loads((opened.metadata() or {}).get("facts", "{}")) == facts
            return np.asarray(opened.get_tensor("poses")) if same else None
    except (OSError, SafetensorError, ValueError):  # damaged: it is only a copy of what can be worked out again
        return None
