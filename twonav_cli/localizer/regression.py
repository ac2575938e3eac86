"""The paper's output: x, y, sin and cos of the heading as four numbers (§4.2, Fig. 6).

B batch, N frames.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from twonav_cli.checkpoint import Arrays

OUTPUTS = 4

SMOOTH_BELOW = 0.05
"""Error below which the loss is squared: about 20 cm in the apartment, 3 degrees (ours)."""


@dataclass(frozen=True)
class PoseScale:
    """What makes x and y of the training labels about as large as a sine: x = offset + scale * number (ours).

    Attributes:
        offset_m: [2].
        scale_m: [2].
    """

    offset_m: Tensor
    scale_m: Tensor

    @classmethod
    def of(cls, labels: NDArray[np.float32]) -> PoseScale:
        """Return mean and deviation of the positions of labels [N, 3]."""
        places = labels[:, :2].astype(np.float64)
        scale = np.maximum(places.std(axis=0), 1e-3)
        return cls(torch.from_numpy(places.mean(axis=0)).float(), torch.from_numpy(scale).float())


def pose_targets(poses: Tensor, scale: PoseScale) -> Tensor:
    """Return poses [B, 3] as the numbers to give [B, 4]: standardised x and y, sin, cos (§4.2)."""
    places = (poses[:, :2] - scale.offset_m) / scale.scale_m
    return torch.cat([places, poses[:, 2:].sin(), poses[:, 2:].cos()], dim=1)


def regression_loss(outputs: Tensor, targets: Tensor) -> Tensor:
    """Return the mean over a batch of the smooth absolute errors of numbers [B, 4], added up (ours)."""
    return functional.smooth_l1_loss(outputs, targets, beta=SMOOTH_BELOW, reduction="none").sum(dim=1).mean()


def poses_of(outputs: Tensor, scale: PoseScale) -> Tensor:
    """Return the poses [B, 3] that numbers [B, 4] stand for; the heading is atan2 of sine and cosine."""
    places = outputs[:, :2] * scale.scale_m + scale.offset_m
    return torch.cat([places, torch.atan2(outputs[:, 2:3], outputs[:, 3:4])], dim=1)


class RegressionHead:
    """Four numbers with the scale of their positions."""

    outputs = OUTPUTS

    def __init__(self, scale: PoseScale) -> None:
        self.scale = scale

    @classmethod
    def fitted(cls, labels: NDArray[np.float32], settings: Any) -> RegressionHead:
        """Return the head for the labels [N, 3] of the training frames; it has no settings."""
        return cls(PoseScale.of(labels))

    @classmethod
    def restored(cls, arrays: Arrays, settings: dict[str, Any]) -> RegressionHead:
        """Return the head of a checkpoint."""
        return cls(PoseScale(torch.from_numpy(arrays["offset_m"]), torch.from_numpy(arrays["scale_m"])))

    def arrays(self) -> Arrays:
        """Return what a checkpoint must hold."""
        return {"offset_m": self.scale.offset_m.cpu().numpy(), "scale_m": self.scale.scale_m.cpu().numpy()}

    def settings(self) -> dict[str, Any]:
        """Return what a checkpoint's card must hold."""
        return {}

    def to(self, device: torch.device) -> RegressionHead:
        """Return the head with its tensors on a device."""
        return RegressionHead(PoseScale(self.scale.offset_m.to(device), self.scale.scale_m.to(device)))

    def loss(self, outputs: Tensor, poses: Tensor) -> Tensor:
        """Return what training makes small."""
        return regression_loss(outputs, pose_targets(poses, self.scale))

    def poses(self, outputs: Tensor) -> Tensor:
        """Return the poses [B, 3]."""
        return poses_of(outputs, self.scale)
