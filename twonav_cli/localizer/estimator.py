"""The trained localizer: one picture in, one pose out.

B batch; rows, cols of the grid of position bins.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from twonav_cli.checkpoint import Arrays, Card, load_checkpoint
from twonav_cli.config import IMAGE_PX
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.networks import PoseNetwork, build_network, network_input
from twonav_cli.localizer.pose_code import HEADING_BINS, Decoded, PoseCode

_SHAPE = (IMAGE_PX, IMAGE_PX, 3)
_PORTION = 64


@dataclass(frozen=True)
class Estimate:
    """Where the localizer thinks the robot is.

    Attributes:
        pose: In the map frame.
        confidence: Probability of the window of 5 x 5 bins that the position was read from, 0 to 1.
        grid_belief: [rows, cols] float32 probability of each position bin.
        frame: Where the bins lie.
    """

    pose: Pose
    confidence: float
    grid_belief: NDArray[np.float32]
    frame: GridFrame


class Estimator:
    """A localizer's network with its bins, ready for use on one core."""

    def __init__(self, network: PoseNetwork, code: PoseCode, card: Card) -> None:
        network.eval()
        network.fold()
        self._network = network.requires_grad_(False)
        self._code = code
        self.card = card

    @property
    def frame(self) -> GridFrame:
        """Grid of the belief."""
        return self._code.frame

    @classmethod
    def load(cls, folder: Path, scene_digest: str | None = None) -> Estimator:
        """Read a localizer's checkpoint.

        Args:
            folder: Where it is.
            scene_digest: The scene it must have been made for, unless None.

        Raises:
            TwonavError: Missing, damaged, or made for another scene or version.
        """
        arrays, card = load_checkpoint(folder, "localizer", scene_digest)
        try:
            network, code = _rebuilt(arrays, card)
        except (KeyError, TypeError, ValueError, RuntimeError) as error:
            raise TwonavError(f"the localizer in {folder} is of another version of twonav: train it again") from error
        return cls(network, code, card)

    def estimate(self, image: NDArray[np.uint8]) -> Estimate:
        """Return pose, confidence and belief of an image uint8 [84, 84, 3] RGB.

        Raises:
            TwonavError: The image has another shape or type.
        """
        decoded = self._decoded(image[None])
        x_m, y_m, theta_rad = (float(value) for value in decoded.poses[0])
        belief = self._code.belief(decoded.positions[0].numpy())
        return Estimate(Pose(x_m, y_m, theta_rad), float(decoded.confidence[0]), belief, self.frame)

    def estimate_many(self, images: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Return the poses [B, 3] of images uint8 [B, 84, 84, 3].

        Raises:
            TwonavError: The images have another shape or type.
        """
        starts = range(0, len(images), _PORTION)
        poses = [self._decoded(images[start : start + _PORTION]).poses.double().numpy() for start in starts]
        return np.concatenate(poses) if poses else np.zeros((0, 3))

    def _decoded(self, images: NDArray[Any]) -> Decoded:
        if not isinstance(images, np.ndarray) or images.shape[1:] != _SHAPE or images.dtype != np.uint8:
            raise TwonavError(
                f"the localizer needs uint8 RGB pictures of {IMAGE_PX} x {IMAGE_PX} x 3, "
                f"not {images.dtype} {'x'.join(map(str, images.shape[1:]))}: use the camera of the scene"
            )
        with torch.inference_mode():
            pixels = torch.from_numpy(np.ascontiguousarray(images))
            return self._code.decode(*self._network(network_input(pixels)))


def _rebuilt(arrays: Arrays, card: Card) -> tuple[PoseNetwork, PoseCode]:
    """Return the network and the bins of a checkpoint."""
    settings = card["settings"]
    code = PoseCode(GridFrame(**settings["bins"]), arrays["bins"].astype(np.int64))
    network = build_network(settings["architecture"], len(code.bins), HEADING_BINS)
    prefix = "network."
    weights = {
        name.removeprefix(prefix): torch.from_numpy(array.astype(np.float32) if array.dtype == np.float16 else array)
        for name, array in arrays.items()
        if name.startswith(prefix)
    }
    network.load_state_dict(weights)
    return network, code
