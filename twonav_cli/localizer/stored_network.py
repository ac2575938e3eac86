"""A trained network as a checkpoint holds it: arrays and a few settings in the card."""

from __future__ import annotations

from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import nn

from twonav_cli.checkpoint import Arrays, Card
from twonav_cli.localizer.heads import Head
from twonav_cli.localizer.networks import NetworkSpec, network_spec

LARGE = 100_000
"""Numbers from which on a matrix is rounded to few levels."""

LEVELS = 127

_PREFIX, _SCALES = "network.", "scale."
_TINY = 1e-12


def packed(network: nn.Module, head: Head) -> Arrays:
    """Return what a checkpoint holds: large matrices as int8 with a scale for each row, kernels as float16.

    Small vectors stay float32. The matrices of dense layers are most of a network, and rounding them to 255 levels
    changes poses by far less than the errors they have; what a card says is measured after it.
    """
    arrays: dict[str, NDArray[Any]] = dict(head.arrays())
    for name, value in network.state_dict().items():
        array = value.cpu().numpy()
        if array.dtype == np.float32 and array.ndim == 2 and array.size >= LARGE:
            levels, scale = _levels(array)
            arrays[_PREFIX + name], arrays[_SCALES + name] = levels, scale
            continue
        if array.dtype == np.float32 and array.ndim >= 2:
            array = array.astype(np.float16)
        arrays[_PREFIX + name] = array
    return arrays


def _levels(matrix: NDArray[np.float32]) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Return a matrix [rows, cols] as whole numbers from -127 to 127, and what one is worth in each row [rows]."""
    scale = np.maximum(np.abs(matrix).max(axis=1), _TINY) / LEVELS
    return np.round(matrix / scale[:, None]).astype(np.int8), scale.astype(np.float32)


def unpacked(arrays: Arrays, card: Card) -> tuple[NetworkSpec, nn.Module, Head]:
    """Return the network and the head of a checkpoint.

    Raises:
        TwonavError: The card names a network that there is not.
        KeyError, TypeError, ValueError, RuntimeError: Arrays or settings are those of another network.
    """
    settings = card["settings"]
    spec = network_spec(settings.get("network", "belief"))  # cards of before say nothing: there was one network
    head = spec.head_class.restored(arrays, settings)
    network = spec.build(head)
    set_weights(network, arrays)
    return spec, network, head


def set_weights(network: nn.Module, arrays: Arrays) -> None:
    """Give a network the weights of a checkpoint, as float32.

    Raises:
        RuntimeError: They are those of another network.
    """
    weights = {name.removeprefix(_PREFIX): array for name, array in arrays.items() if name.startswith(_PREFIX)}
    for name, array in weights.items():
        scale = arrays.get(_SCALES + name)
        if scale is not None:
            weights[name] = array.astype(np.float32) * scale[:, None]
        elif array.dtype == np.float16:
            weights[name] = array.astype(np.float32)
    network.load_state_dict({name: torch.from_numpy(array) for name, array in weights.items()})
