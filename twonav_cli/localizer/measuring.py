"""How far a network's poses lie from the truth at chosen frames.

B batch, N frames.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from twonav_cli.dataset.collect import SIMULATOR
from twonav_cli.dataset.store import FrameStore
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.heads import Head
from twonav_cli.localizer.nearest import nearest_poses
from twonav_cli.localizer.pictures import network_input

PORTION = 64


def poses_at(network: nn.Module, head: Head, pictures: str, images: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the poses [B, 3] that a network gives to images uint8 [B, 84, 84, 3]; it must be in evaluation mode."""
    device = next(network.parameters()).device
    with torch.inference_mode():
        x = network_input(torch.from_numpy(np.ascontiguousarray(images)).to(device), pictures)
        return np.asarray(head.poses(network(x).float()).cpu().numpy())


def measured(
    network: nn.Module, head: Head, pictures: str, selection: Selection, pool: ThreadPoolExecutor
) -> dict[str, float]:
    """Return the errors of a network against where the robot stood (`error_metrics`)."""
    store, frames = selection
    network.eval()
    ordered = np.sort(frames)
    parts = [ordered[start : start + PORTION] for start in range(0, len(ordered), PORTION)]
    found = pool.map(lambda part: poses_at(network, head, pictures, store.batch(part)[0]), parts)
    return error_metrics(np.concatenate(list(found)), store.poses[ordered])


def nearest_measured(training: Selection, selection: Selection, frames_at_most: int) -> dict[str, float]:
    """Return the errors of the pose of the most alike training frame, at evenly chosen frames of a selection."""
    store, frames = selection
    chosen = thinned(frames, frames_at_most)
    return error_metrics(nearest_poses(*training, chosen, store), store.poses[chosen])


def trial_metrics(
    network: nn.Module, head: Head, pictures: str, trials: Mapping[str, Selection], pool: ThreadPoolExecutor
) -> dict[str, Any]:
    """Return the errors of a network at every named selection that has frames."""
    return {
        name: measured(network, head, pictures, selection, pool)
        for name, selection in trials.items()
        if len(selection[1])
    }


def nearest_metrics(training: Selection, trials: Mapping[str, Selection], frames_at_most: int) -> dict[str, Any]:
    """Return the row beside: the same for the most alike training frame, each name with `_nearest` behind it."""
    if frames_at_most == 0:
        return {}
    return {
        f"{name}_nearest": nearest_measured(training, selection, frames_at_most)
        for name, selection in trials.items()
        if len(selection[1])
    }


def label_metrics(store: FrameStore) -> dict[str, Any]:
    """Return who labelled the frames, how many have no label, and how far labels lie from where the robot stood."""
    known = store.labelled()
    counts = {"by": store.meta.get("labels", SIMULATOR), "without_label": int((~known).sum())}
    return {**counts, **error_metrics(store.labels[known], store.poses[known])}


def thinned(frames: NDArray[np.int64], at_most: int) -> NDArray[np.int64]:
    """Return at most so many of some frames, evenly spread over them."""
    if len(frames) <= at_most:
        return frames
    return np.asarray(frames[np.linspace(0, len(frames) - 1, at_most).round().astype(np.int64)])
