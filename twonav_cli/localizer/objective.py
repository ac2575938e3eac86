"""What training minimises, and how pictures are varied without moving anything in them (ours).

B batch, P position bins, H heading bins, W bins of a window.
"""

from __future__ import annotations

import torch
from torch import Tensor
from torch.nn import functional

from twonav_cli.localizer.networks import network_input
from twonav_cli.localizer.pose_code import HEADING_BINS, PoseCode


def varied(images: Tensor, strength: float, generator: torch.Generator) -> Tensor:
    """Return uint8 images [B, 84, 84, 3] as network input [B, 3, 84, 84] with other light, colour and a little noise.

    Args:
        images: As rendered.
        strength: Largest relative change of brightness, contrast and of each colour; 0 changes nothing.
        generator: Draws the changes.
    """
    x = network_input(images)
    if strength == 0.0:
        return x
    count = len(images)
    gain = 1.0 + strength * (2.0 * torch.rand(count, 1, 1, 1, generator=generator) - 1.0)
    tint = 1.0 + 0.5 * strength * (2.0 * torch.rand(count, 3, 1, 1, generator=generator) - 1.0)
    shift = strength * (2.0 * torch.rand(count, 1, 1, 1, generator=generator) - 1.0)
    return x.mul_(gain * tint).add_(shift)


def pose_loss(
    position_logits: Tensor, heading_logits: Tensor, poses: Tensor, code: PoseCode, huber_weight: float
) -> Tensor:
    """Return the cross entropy with soft targets plus the Huber distance of the decoded pose, in bins.

    Args:
        position_logits: [B, P].
        heading_logits: [B, H].
        poses: [B, 3] true poses.
        code: The bins.
        huber_weight: Share of the Huber term.
    """
    window, weights = code.position_targets(poses)
    likelihood = functional.pad(position_logits.log_softmax(dim=1), (0, 1)).gather(1, window)
    loss = -(weights * likelihood).sum(dim=1).mean()
    loss = loss - (code.heading_targets(poses) * heading_logits.log_softmax(dim=1)).sum(dim=1).mean()
    decoded = code.decode(position_logits, heading_logits).poses
    place_bins = (decoded[:, :2] - poses[:, :2]) / code.frame.resolution_m
    turn_rad = torch.remainder(decoded[:, 2] - poses[:, 2] + torch.pi, 2 * torch.pi) - torch.pi
    errors = torch.cat([place_bins, turn_rad[:, None] * (HEADING_BINS / (2 * torch.pi))], dim=1)
    distance = functional.huber_loss(errors, torch.zeros_like(errors), delta=0.5, reduction="none").sum(dim=1).mean()
    return loss + huber_weight * distance
