"""How a localizer is trained: the settings, and how the rate rises and falls."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

from twonav_cli.localizer.networks import network_spec
from twonav_cli.localizer.pose_code import POSITION_BIN_M


def _setting(default: Any, sentence: str) -> Any:
    return field(default=default, metadata={"help": sentence})


MAY_CHANGE = ("threads", "validations", "validation_frames", "nearest_frames", "save_every_s")
"""Settings that a training may change when it goes on."""


@dataclass(frozen=True)
class TrainingConfig:
    """How a localizer is trained."""

    network: str = _setting("belief", "Network, a name of NETWORKS: ours, or one of the paper's (Tables 1 and 2).")
    images: int = _setting(800_000, "Pictures shown in all to learn poses, repeats included (ours).")
    batch: int = _setting(128, "Pictures between two updates (ours).")
    part: int = _setting(128, "Pictures a thread takes at a time; normalised together (ours).")
    threads: int = _setting(2, "Threads that compute gradients, one core each (ours).")
    peak_rate: float = _setting(2.5e-3, "Largest learning rate of the one-cycle schedule (ours).")
    warm_up: float = _setting(0.15, "Share of the batches in which the rate rises (ours).")
    weight_decay: float = _setting(0.02, "Decoupled weight decay of Adam (ours; the paper has plain Adam).")
    variation: float = _setting(0.1, "Largest relative change of brightness, contrast and colour (ours).")
    pretraining_images: int = _setting(0, "Pictures shown before, to an autoencoder's layers in turn (§4.2.1; ours).")
    pretraining_rate: float = _setting(1e-3, "Largest learning rate of each layer's denoising (ours).")
    huber_weight: float = _setting(0.3, "Weight of the decoded pose's error beside the cross entropy (ours).")
    position_bin_m: float = _setting(POSITION_BIN_M, "Edge of a position bin (ours).")
    precision: str = _setting("auto", "Arithmetic: float32, bfloat16, or auto: bfloat16 where it is fast (ours).")
    device: str = _setting("auto", "cpu, cuda, or auto: a graphics card where there is one (ours).")
    validations: int = _setting(6, "How often the held-out frames are tried during training (ours).")
    validation_frames: int = _setting(1000, "Held-out frames tried each time; the end tries all (ours).")
    nearest_frames: int = _setting(4000, "Frames of each trial that are also placed by the most alike frame (ours).")
    save_every_s: float = _setting(60.0, "Time between two saves of the training's state (ours).")

    @property
    def pretraining_steps(self) -> int:
        """Number of batches before the pose is learned."""
        return self.pretraining_images // self.batch

    @property
    def pose_steps(self) -> int:
        """Number of batches from which the pose is learned."""
        return max(1, self.images // self.batch)

    @property
    def steps(self) -> int:
        """Number of batches in all."""
        return self.pretraining_steps + self.pose_steps


def training_settings(network: str, **changes: Any) -> TrainingConfig:
    """Return the settings that suit a network, with `changes` over them; with fewer pictures it is pretrained less.

    Raises:
        TwonavError: There is no network of that name.
    """
    usual = dict(network_spec(network).training)
    if "images" in changes and "pretraining_images" not in changes:
        before = usual.get("pretraining_images", 0)
        usual["pretraining_images"] = round(before * changes["images"] / usual.get("images", TrainingConfig.images))
    return TrainingConfig(network=network, **{**usual, **changes})


def learning_rate(step: int, steps: int, peak: float, warm_up: float) -> float:
    """Return the rate of a batch: a cosine up to the peak, then a cosine down to nearly nothing (one cycle; ours)."""
    rising = max(1, round(warm_up * steps))
    if step < rising:
        share, low = step / rising, 0.04
    else:
        share, low = 1.0 - (step - rising) / max(1, steps - rising), 0.0005
    return peak * (low + (1.0 - low) * 0.5 * (1.0 - math.cos(math.pi * share)))
