"""Making a trained network as sure as it is right, on frames that it has not learned from."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import torch
from torch import nn

from twonav_cli.dataset.collect import SIMULATOR
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.belief_head import BeliefHead
from twonav_cli.localizer.calibration import Calibration
from twonav_cli.localizer.calibration_fit import fit_calibration, mean_misfit
from twonav_cli.localizer.measuring import PORTION, thinned
from twonav_cli.localizer.pictures import network_input

FRAMES = 2500
"""Frames at most by which a network is calibrated (ours)."""

EXPONENTS = (0.6, 0.8, 1.0, 1.25, 1.6, 2.0)
"""Exponents of the weights of places that are tried: each is one through a temperature."""

MAP_M = 0.01
"""How far a survey's map is off, as a deviation along each axis (ours: surveys of our scenes err by 0.5 to 1 cm)."""

AS_IT_IS = Calibration(0.0, 1.0, 1.0, 1.0)


def calibration_frames(validation: Selection) -> Selection:
    """Return the labelled frames to calibrate by: evenly taken from those for validation."""
    store, frames = validation
    return store, thinned(frames[np.isfinite(store.labels[frames]).all(axis=1)], FRAMES)


def calibration_of(
    network: nn.Module, head: BeliefHead, pictures: str, frames: Selection, pool: ThreadPoolExecutor
) -> Calibration:
    """Return the calibration under which the labels of some frames are likeliest.

    Args:
        network: In evaluation mode.
        head: Of the network; its own calibration does not matter.
        pictures: What the network is shown.
        frames: Which it has not learned from.
        pool: Shares the work.
    """
    plain = BeliefHead(head.code, calibration=AS_IT_IS, area_m2=head.area_m2)
    store, chosen = frames
    device = next(network.parameters()).device
    ordered = np.sort(chosen)
    parts = [ordered[start : start + PORTION] for start in range(0, len(ordered), PORTION)]

    def outputs(part: np.ndarray) -> torch.Tensor:
        with torch.inference_mode():
            images = torch.from_numpy(store.batch(part)[0]).to(device)
            found: torch.Tensor = network(network_input(images, pictures))
            return found.float()

    beliefs = [belief for found in pool.map(outputs, parts) for belief in plain.beliefs(found)]
    labels = store.labels[ordered].astype(np.float64)
    tried = [fit_calibration(beliefs, labels, exponent) for exponent in EXPONENTS]
    best = min(tried, key=lambda found: mean_misfit([found.applied(belief) for belief in beliefs], labels))
    return replace(best, map_m=0.0 if store.meta.get("labels", SIMULATOR) == SIMULATOR else MAP_M)
