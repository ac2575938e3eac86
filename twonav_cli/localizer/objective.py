"""What the training of our own network minimises (ours).

B batch, P position bins, H heading bins, W bins of a window.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from twonav_cli.localizer.pose_code import HEADING_BINS, PoseCode

PRECISION_WEIGHT = 0.1
"""Weight of the deviations' likelihood beside the cross entropy (ours)."""

WITHIN_BINS = 2.0
"""Estimates that are further off are in a wrong place altogether: the weights of places tell those, not deviations."""


def pose_loss(
    position_logits: Tensor, heading_logits: Tensor, poses: Tensor, code: PoseCode, huber_weight: float
) -> tuple[Tensor, Tensor]:
    """Return the cross entropy with soft targets plus the Huber distance of the decoded pose in bins, and that pose.

    Args:
        position_logits: [B, P].
        heading_logits: [B, H].
        poses: [B, 3] true poses.
        code: The bins.
        huber_weight: Share of the Huber term.

    Returns:
        The mean loss, and the decoded poses [B, 3].
    """
    window, weights = code.position_targets(poses)
    likelihood = functional.pad(position_logits.float().log_softmax(dim=1), (0, 1)).gather(1, window)
    loss = -(weights * likelihood).sum(dim=1).mean()
    loss = loss - (code.heading_targets(poses) * heading_logits.float().log_softmax(dim=1)).sum(dim=1).mean()
    decoded = code.decode(position_logits, heading_logits).poses
    place_m, turn_rad = _errors(decoded, poses)
    errors = torch.cat([place_m / code.frame.resolution_m, turn_rad * (HEADING_BINS / (2 * torch.pi))], dim=1)
    distance = functional.huber_loss(errors, torch.zeros_like(errors), delta=0.5, reduction="none").sum(dim=1).mean()
    return loss + huber_weight * distance, decoded


def precision_loss(decoded: Tensor, sigma: Tensor, poses: Tensor, bin_m: float) -> Tensor:
    """Return how badly deviations fit the errors of estimates in the right place: Laplace's negative log likelihood.

    Args:
        decoded: [B, 3] estimated poses; they are taken as they are, so that doubt cannot replace precision.
        sigma: [B, 2] deviations of position (metres, along each axis) and heading (radians).
        poses: [B, 3] true poses.
        bin_m: Edge of a position bin.
    """
    place_m, turn_rad = _errors(decoded, poses)
    away = torch.cat([place_m.abs().mean(dim=1, keepdim=True), turn_rad.abs()], dim=1)
    limit = WITHIN_BINS * torch.tensor([bin_m, 2 * torch.pi / HEADING_BINS], device=away.device)
    right = (away < limit).float()
    return PRECISION_WEIGHT * (right * (sigma.log() + away / sigma)).sum(dim=1).mean()


def _errors(decoded: Tensor, poses: Tensor) -> tuple[Tensor, Tensor]:
    """Return how far estimates lie from poses: [B, 2] metres, and [B, 1] radians the short way round."""
    turn_rad = torch.remainder(decoded[:, 2:] - poses[:, 2:] + torch.pi, 2 * torch.pi) - torch.pi
    return decoded[:, :2] - poses[:, :2], turn_rad
