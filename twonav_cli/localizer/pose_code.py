"""A pose as a belief over bins: soft targets to learn, and a decoder that is finer than a bin (ours).

The paper regresses (x, y, sin, cos); one picture can fit several places, whose mean is none of them, so the network
classifies instead. P position bins, W = 25 bins of a window, H heading bins, B batch.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from twonav_cli.grid import GridFrame

HEADING_BINS = 72
POSITION_BIN_M = 0.27
"""Edge of a position bin. Not 25 cm, or every grid frame would lie at the same spot of its bin."""

_REACH = 2
_MISSING_M = 1e6
_TINY = 1e-12


@dataclass(frozen=True)
class Decoded:
    """Poses read out of a belief.

    Attributes:
        poses: [B, 3] (x_m, y_m, theta_rad).
        confidence: [B] probability of the window around the position's mode.
        positions: [B, P] probability of each position bin.
    """

    poses: Tensor
    confidence: Tensor
    positions: Tensor


class PoseCode:
    """The bins of a map: those where a robot can be, and their neighbours.

    Attributes:
        frame: The grid of the position bins.
        bins: [P] flat index of each bin in the grid.
    """

    def __init__(self, frame: GridFrame, bins: NDArray[np.int64], sigma_bins: float = 0.7) -> None:
        self.frame = frame
        self.bins = np.asarray(bins, dtype=np.int64)
        self.sigma_bins = sigma_bins
        rows, cols = np.divmod(self.bins, frame.cols)
        xs_m, ys_m = frame.centres()
        centres = np.column_stack([xs_m[cols], ys_m[rows]])
        number = np.full((frame.rows + 2 * _REACH, frame.cols + 2 * _REACH), len(self.bins))
        number[rows + _REACH, cols + _REACH] = np.arange(len(self.bins))
        offsets = np.arange(2 * _REACH + 1)
        windows = number[rows[:, None, None] + offsets[:, None], cols[:, None, None] + offsets]
        self._windows = torch.from_numpy(windows.reshape(len(self.bins), -1))  # [P, W], P where there is no bin
        missing = np.full((1, 2), _MISSING_M)
        self._centres = torch.from_numpy(np.concatenate([centres, missing])).float()  # [P + 1, 2]

    @classmethod
    def covering(cls, poses: NDArray[np.float32], bin_m: float = POSITION_BIN_M, sigma_bins: float = 0.7) -> PoseCode:
        """Return the code whose bins hold all poses [N, 3] and everything within two bins of them."""
        margin_m = (_REACH + 0.5) * bin_m
        low, high = poses[:, :2].min(axis=0) - margin_m, poses[:, :2].max(axis=0) + margin_m
        cols, rows = (int(np.ceil(extent / bin_m)) for extent in high - low)
        frame = GridFrame(float(low[0]), float(low[1]), bin_m, rows, cols)
        seen = np.zeros(frame.shape, dtype=bool)
        col = ((poses[:, 0] - frame.x_min_m) / bin_m).astype(np.int64)
        row = rows - 1 - ((poses[:, 1] - frame.y_min_m) / bin_m).astype(np.int64)
        for d_row in range(-_REACH, _REACH + 1):
            for d_col in range(-_REACH, _REACH + 1):
                seen[row + d_row, col + d_col] = True
        return cls(frame, np.flatnonzero(seen), sigma_bins)

    def to(self, device: torch.device) -> PoseCode:
        """Return the code with its tensors on a device."""
        moved = copy(self)
        moved._windows, moved._centres = self._windows.to(device), self._centres.to(device)
        return moved

    def area_m2(self, poses: NDArray[np.float32]) -> float:
        """Return the area of the bins that hold any of some poses [N, 3]: about the floor where the robot can be."""
        frame = self.frame
        col = ((poses[:, 0] - frame.x_min_m) / frame.resolution_m).astype(np.int64)
        row = ((poses[:, 1] - frame.y_min_m) / frame.resolution_m).astype(np.int64)
        return len(np.unique(row * frame.cols + col)) * frame.resolution_m**2

    def position_targets(self, poses: Tensor) -> tuple[Tensor, Tensor]:
        """Return the window of bins [B, W] around each pose [B, 3] and the Gaussian weight [B, W] of each bin in it."""
        nearest = torch.cdist(poses[:, :2], self._centres).argmin(dim=1)
        window = self._windows[nearest]
        distance_bins = (self._centres[window] - poses[:, None, :2]) / self.frame.resolution_m
        weights = torch.exp(-distance_bins.square().sum(dim=2) / (2 * self.sigma_bins**2))
        return window, weights / weights.sum(dim=1, keepdim=True)

    def heading_targets(self, poses: Tensor) -> Tensor:
        """Return the Gaussian weight [B, H] of every heading bin; bin h is centred at h + 1/2 bins from +x."""
        away = poses[:, 2:3] * (HEADING_BINS / (2 * torch.pi)) - (torch.arange(HEADING_BINS, device=poses.device) + 0.5)
        away = torch.remainder(away + HEADING_BINS / 2, HEADING_BINS) - HEADING_BINS / 2
        weights = torch.exp(-away.square() / (2 * self.sigma_bins**2))
        return weights / weights.sum(dim=1, keepdim=True)

    def decode(self, position_logits: Tensor, heading_logits: Tensor) -> Decoded:
        """Return the mean of the belief in the window around its mode: soft-argmax, differentiable.

        Args:
            position_logits: [B, P].
            heading_logits: [B, H].
        """
        positions = position_logits.float().softmax(dim=1)
        weights, places = self.place_modes(positions, 1)
        _, headings = heading_modes(heading_logits.float().softmax(dim=1), 1)
        return Decoded(torch.cat([places[:, 0], headings], dim=1), weights[:, 0], positions)

    def place_modes(self, positions: Tensor, count: int) -> tuple[Tensor, Tensor]:
        """Return the places of beliefs [B, P], the highest peak first: their probabilities, and where they are.

        Args:
            positions: [B, P] probability of each position bin.
            count: How many are wanted; each is looked for in what the windows of those before leave.

        Returns:
            The probability of the window around each [B, count], and the mean of the belief in it [B, count, 2].
        """
        left = torch.nn.functional.pad(positions, (0, 1))
        weights, places = [], []
        for number in range(count):
            window = self._windows[left[:, :-1].argmax(dim=1)]
            near = left.gather(1, window)
            weights.append(near.sum(dim=1))
            # Where there is no bin the probability is 0, but 0 times a far-away centre would still cost precision.
            centres = self._centres[window] * (window < len(self.bins))[..., None]
            places.append((near[..., None] * centres).sum(dim=1) / weights[-1].clamp(min=_TINY)[:, None])
            if number + 1 < count:
                left = left.scatter(1, window, 0.0)
        return torch.stack(weights, dim=1), torch.stack(places, dim=1)

    def belief(self, positions: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return the probabilities of the bins [P] as a grid [rows, cols], 0 where there is no bin."""
        grid = np.zeros(self.frame.rows * self.frame.cols, dtype=np.float32)
        grid[self.bins] = positions
        return grid.reshape(self.frame.shape)


def heading_modes(headings: Tensor, count: int) -> tuple[Tensor, Tensor]:
    """Return the headings of beliefs [B, H], the highest peak first: probabilities and angles, both [B, count]."""
    offsets = torch.arange(-_REACH, _REACH + 1, device=headings.device)
    left = headings
    weights, angles = [], []
    for number in range(count):
        mode = left.argmax(dim=1, keepdim=True)
        window = (mode + offsets) % HEADING_BINS
        near = left.gather(1, window)
        weights.append(near.sum(dim=1))
        shift = (near * offsets).sum(dim=1) / weights[-1].clamp(min=_TINY)
        theta = (mode[:, 0] + 0.5 + shift) * (2 * torch.pi / HEADING_BINS)
        angles.append(torch.remainder(theta + torch.pi, 2 * torch.pi) - torch.pi)
        if number + 1 < count:
            left = left.scatter(1, window, 0.0)
    return torch.stack(weights, dim=1), torch.stack(angles, dim=1)
