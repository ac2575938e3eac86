"""The trained localizer, whichever network it is: pictures in; poses out, and beliefs where the network has them.

B batch.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor, nn

from twonav_cli.belief import Belief
from twonav_cli.checkpoint import Card, load_checkpoint
from twonav_cli.config import IMAGE_PX
from twonav_cli.errors import TwonavError
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.belief_head import BeliefHead
from twonav_cli.localizer.belief_network import BeliefNetwork
from twonav_cli.localizer.heads import Head
from twonav_cli.localizer.networks import NetworkSpec
from twonav_cli.localizer.paper_networks import Cnn
from twonav_cli.localizer.pictures import network_input
from twonav_cli.localizer.stored_network import unpacked

_SHAPE = (IMAGE_PX, IMAGE_PX, 3)
_PORTION = 64


class Estimator:
    """A localizer's network with the meaning of its output, ready for use."""

    def __init__(self, spec: NetworkSpec, network: nn.Module, head: Head, card: Card) -> None:
        network.eval()
        if isinstance(network, Cnn | BeliefNetwork):
            network.fold()
        self._network = network.requires_grad_(False)
        self._pictures = spec.pictures
        self._head = head
        self.card = card

    @property
    def gives_beliefs(self) -> bool:
        """Whether it says how sure it is; the paper's networks give poses only."""
        return isinstance(self._head, BeliefHead)

    @property
    def frame(self) -> GridFrame:
        """Grid of the belief.

        Raises:
            TwonavError: The network gives poses only.
        """
        return self._belief_head().code.frame

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
            spec, network, head = unpacked(arrays, card)
        except (KeyError, TypeError, ValueError, RuntimeError, TwonavError) as error:
            raise TwonavError(f"the localizer in {folder} is of another version of twonav: train it again") from error
        return cls(spec, network, head, card)

    def estimate(self, image: NDArray[np.uint8]) -> Belief:
        """Return the belief of an image uint8 [84, 84, 3] RGB.

        Raises:
            TwonavError: The image has another shape or type, or the network gives poses only.
        """
        return self.beliefs(image[None])[0]

    def beliefs(self, images: NDArray[np.uint8]) -> list[Belief]:
        """Return the beliefs [B] of images uint8 [B, 84, 84, 3].

        Raises:
            TwonavError: The images have another shape or type, or the network gives poses only.
        """
        head = self._belief_head()
        starts = range(0, len(images), _PORTION)
        outputs = (self._outputs(images[start : start + _PORTION]) for start in starts)
        return [belief for part in outputs for belief in head.beliefs(part)]

    def estimate_many(self, images: NDArray[np.uint8]) -> NDArray[np.float64]:
        """Return the poses [B, 3] of images uint8 [B, 84, 84, 3].

        Raises:
            TwonavError: The images have another shape or type.
        """
        starts = range(0, len(images), _PORTION)
        outputs = (self._outputs(images[start : start + _PORTION]) for start in starts)
        poses = [self._head.poses(part).double().numpy() for part in outputs]
        return np.concatenate(poses) if poses else np.zeros((0, 3))

    def _belief_head(self) -> BeliefHead:
        if not isinstance(self._head, BeliefHead):
            network = self.card["settings"]["network"]
            raise TwonavError(f"the network {network} gives poses without a belief: train the network belief")
        return self._head

    def _outputs(self, images: NDArray[Any]) -> Tensor:
        """Return the network's numbers [B, outputs]."""
        images = np.asarray(images)
        if images.shape[1:] != _SHAPE or images.dtype != np.uint8:
            raise TwonavError(
                f"the localizer needs uint8 RGB pictures of {IMAGE_PX} x {IMAGE_PX} x 3, "
                f"not {images.dtype} {'x'.join(map(str, images.shape[1:]))}: use the camera of the scene"
            )
        with torch.inference_mode(), _one_thread_for(len(images)):
            pixels = torch.from_numpy(np.ascontiguousarray(images))
            return self._network(network_input(pixels, self._pictures))  # type: ignore[no-any-return]  # a module returns Any


@contextmanager
def _one_thread_for(pictures: int) -> Iterator[None]:
    """Compute on one thread if there is one picture.

    Two gain little there, and stand still when another program needs a core. The number of threads is that of the whole
    process, so it is put back.
    """
    threads = torch.get_num_threads()
    if pictures > 1 or threads == 1:
        yield
        return
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
