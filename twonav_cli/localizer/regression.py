"""The paper's output: x, y, sin and cos of the heading as four numbers (§4.2, Fig. 6).

B batch, N frames.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from twonav_cli.checkpoint import Arrays

OUTPUTS = 4

SMOOTH_BELOW = 0.05
"""Error below which the loss is squared: 5 cm, 3 degrees (ours)."""


def pose_targets(poses: Tensor, middle_m: Tensor) -> Tensor:
    """Return poses [B, 3] as the numbers to give [B, 4]: metres from the middle [2], sin, cos (§4.2).

    A metre weighs as much as a radian, about as the paper's errors do. Divided by their deviation over the apartment,
    positions came out worse and headings better (0.175 m, 2.5 deg; so 0.154 m, 3.1 deg after 200,000 pictures).
    """
    return torch.cat([poses[:, :2] - middle_m, poses[:, 2:].sin(), poses[:, 2:].cos()], dim=1)


def regression_loss(outputs: Tensor, targets: Tensor) -> Tensor:
    """Return the mean over a batch of the smooth absolute errors of numbers [B, 4], added up (ours)."""
    return functional.smooth_l1_loss(outputs, targets, beta=SMOOTH_BELOW, reduction="none").sum(dim=1).mean()


def poses_of(outputs: Tensor, middle_m: Tensor) -> Tensor:
    """Return the poses [B, 3] that numbers [B, 4] stand for; the heading is atan2 of sine and cosine."""
    return torch.cat([outputs[:, :2] + middle_m, torch.atan2(outputs[:, 2:3], outputs[:, 3:4])], dim=1)


class RegressionHead:
    """Four numbers, and the middle [2] of the training labels' positions, from which they count."""

    outputs = OUTPUTS

    def __init__(self, middle_m: Tensor) -> None:
        self.middle_m = middle_m

    @classmethod
    def fitted(cls, labels: NDArray[np.float32], settings: Any) -> RegressionHead:
        """Return the head for the labels [N, 3] of the training frames; it has no settings."""
        return cls(torch.from_numpy(labels[:, :2].astype(np.float64).mean(axis=0)).float())

    @classmethod
    def restored(cls, arrays: Arrays, settings: dict[str, Any]) -> RegressionHead:
        """Return the head of a checkpoint."""
        return cls(torch.from_numpy(arrays["middle_m"]))

    def arrays(self) -> Arrays:
        """Return what a checkpoint must hold."""
        return {"middle_m": self.middle_m.cpu().numpy()}

    def settings(self) -> dict[str, Any]:
        """Return what a checkpoint's card must hold."""
        return {}

    def to(self, device: torch.device) -> RegressionHead:
        """Return the head with its tensors on a device."""
        return RegressionHead(self.middle_m.to(device))

    def loss(self, outputs: Tensor, poses: Tensor) -> Tensor:
        """Return what training makes small."""
        return regression_loss(outputs, pose_targets(poses, self.middle_m))

    def poses(self, outputs: Tensor) -> Tensor:
        """Return the poses [B, 3]."""
        return poses_of(outputs, self.middle_m)
