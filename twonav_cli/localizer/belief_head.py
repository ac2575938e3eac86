"""Our output: logits of position and heading bins and how precise they are, and what training makes small (ours).

B batch, P position bins, H heading bins, N frames.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from twonav_cli.belief import Belief
from twonav_cli.checkpoint import Arrays
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.calibration import Calibration
from twonav_cli.localizer.objective import pose_loss, precision_loss
from twonav_cli.localizer.pose_code import HEADING_BINS, Decoded, PoseCode, heading_modes

if TYPE_CHECKING:
    from twonav_cli.localizer.training_config import TrainingConfig

PRECISIONS = 2
"""Outputs behind the logits: log deviations of position and heading."""

SIGMA_M, SIGMA_RAD = 0.05, 0.02
"""Deviations that an output of 0 stands for."""

LOG_SIGMA_AT_MOST = 3.0
"""Deviations are between a twentieth and twenty times that."""

PLACES, HEADINGS = 5, 3
"""Places and headings that are told apart in one belief."""

LEAST_WEIGHT = 0.01
"""A place or heading that is less likely is left out, unless it is the first: places go to the floor."""


class Outputs(NamedTuple):
    """What the numbers of a network are: logits [B, P] and [B, H], log deviations [B, 2]."""

    position: Tensor
    heading: Tensor
    log_sigma: Tensor


class BeliefHead:
    """The bins of a scene, with the weight of the decoded pose's error in the loss."""

    def __init__(
        self,
        code: PoseCode,
        huber_weight: float = 0.0,
        calibration: Calibration | None = None,
        area_m2: float | None = None,
    ) -> None:
        self.code = code
        self.huber_weight = huber_weight
        self.calibration = calibration or Calibration()
        self.area_m2 = area_m2 or len(code.bins) * code.frame.resolution_m**2
        self.outputs = len(code.bins) + HEADING_BINS + PRECISIONS

    @classmethod
    def fitted(cls, labels: NDArray[np.float32], settings: TrainingConfig) -> BeliefHead:
        """Return the head whose bins hold the labels [N, 3] of the training frames."""
        code = PoseCode.covering(labels, settings.position_bin_m)
        return cls(code, settings.huber_weight, area_m2=code.area_m2(labels))

    @classmethod
    def restored(cls, arrays: Arrays, settings: dict[str, Any]) -> BeliefHead:
        """Return the head of a checkpoint."""
        code = PoseCode(GridFrame(**settings["bins"]), arrays["bins"].astype(np.int64))
        return cls(code, calibration=Calibration(**settings["calibration"]), area_m2=settings["area_m2"])

    def arrays(self) -> Arrays:
        """Return what a checkpoint must hold."""
        return {"bins": self.code.bins.astype(np.int32)}

    def settings(self) -> dict[str, Any]:
        """Return what a checkpoint's card must hold."""
        bins, calibration = asdict(self.code.frame), asdict(self.calibration)
        return {"bins": bins, "calibration": calibration, "area_m2": self.area_m2}

    def to(self, device: torch.device) -> BeliefHead:
        """Return the head with its tensors on a device."""
        return BeliefHead(self.code.to(device), self.huber_weight, self.calibration, self.area_m2)

    def loss(self, outputs: Tensor, poses: Tensor) -> Tensor:
        """Return what training makes small."""
        found = split(outputs)
        loss, decoded = pose_loss(found.position, found.heading, poses, self.code, self.huber_weight)
        return loss + precision_loss(decoded.detach(), sigmas(found.log_sigma), poses, self.code.frame.resolution_m)

    def poses(self, outputs: Tensor) -> Tensor:
        """Return the poses [B, 3]."""
        return self.decoded(outputs).poses

    def decoded(self, outputs: Tensor) -> Decoded:
        """Return poses, confidences and probabilities of the position bins."""
        found = split(outputs)
        return self.code.decode(found.position, found.heading)

    def beliefs(self, outputs: Tensor) -> list[Belief]:
        """Return the belief that each row of outputs [B, outputs] stands for, calibrated."""
        found = split(outputs)
        positions = found.position.float().softmax(dim=1)
        places = self.code.place_modes(positions, PLACES)
        headings = heading_modes(found.heading.float().softmax(dim=1), HEADINGS)
        arrays = [value.double().cpu().numpy() for value in (*places, *headings, sigmas(found.log_sigma))]
        grids = positions.cpu().numpy()
        beliefs = []
        for number, (weight, place, share, angle, sigma) in enumerate(zip(*arrays, strict=True)):
            left_open = max(0.0, 1.0 - float(weight[_kept(weight)].sum()))
            belief = Belief(
                _likely(weight, place, sigma[0]), _likely(share, angle[:, None], sigma[1]),
                left_open, self.area_m2, self.code.belief(grids[number]), self.code.frame,
            )  # fmt: skip
            beliefs.append(self.calibration.applied(belief))
        return beliefs


def split(outputs: Tensor) -> Outputs:
    """Return the parts of the numbers of a network [B, outputs]."""
    first = outputs.shape[1] - HEADING_BINS - PRECISIONS
    return Outputs(outputs[:, :first], outputs[:, first:-PRECISIONS], outputs[:, -PRECISIONS:])


def sigmas(log_sigma: Tensor) -> Tensor:
    """Return the deviations [B, 2] of position (metres, along each axis) and heading (radians)."""
    usual = torch.tensor([SIGMA_M, SIGMA_RAD], device=log_sigma.device)
    return usual * log_sigma.float().clamp(-LOG_SIGMA_AT_MOST, LOG_SIGMA_AT_MOST).exp()


def _kept(weights: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Return which of some places or headings are likely enough to be named; the first one is in any case."""
    return np.asarray((weights >= LEAST_WEIGHT) | (np.arange(len(weights)) == 0))


def _likely(weights: NDArray[np.float64], values: NDArray[np.float64], sigma: float) -> NDArray[np.float64]:
    """Return rows of weight, values and deviation for what is likely enough; the weights add up to 1."""
    kept = _kept(weights)
    shares = weights[kept] / weights[kept].sum()
    return np.column_stack([shares, values[kept], np.full(len(shares), sigma)])
