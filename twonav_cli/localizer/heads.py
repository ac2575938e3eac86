"""What a network's last numbers mean: the paper's pose, or our belief.

B batch, N frames.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, Self

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from twonav_cli.checkpoint import Arrays
from twonav_cli.localizer.belief_head import BeliefHead
from twonav_cli.localizer.regression import RegressionHead

if TYPE_CHECKING:
    from twonav_cli.localizer.training_config import TrainingConfig


class Head(Protocol):
    """Turns a network's output [B, outputs] into a loss and into poses."""

    outputs: int

    @classmethod
    def fitted(cls, labels: NDArray[np.float32], settings: TrainingConfig) -> Self:
        """Return the head for the labels [N, 3] of the training frames."""

    @classmethod
    def restored(cls, arrays: Arrays, settings: dict[str, Any]) -> Self:
        """Return the head of a checkpoint: its arrays, and the settings in its card."""

    def arrays(self) -> Arrays:
        """Return what a checkpoint must hold to restore the head."""

    def settings(self) -> dict[str, Any]:
        """Return what a checkpoint's card must hold to restore the head."""

    def to(self, device: torch.device) -> Self:
        """Return the head with its tensors on a device."""

    def loss(self, outputs: Tensor, poses: Tensor) -> Tensor:
        """Return what training makes small, a mean over the batch; poses [B, 3]."""

    def poses(self, outputs: Tensor) -> Tensor:
        """Return the poses [B, 3] that outputs [B, outputs] stand for."""


HEADS: dict[str, type[Head]] = {"belief": BeliefHead, "regression": RegressionHead}
