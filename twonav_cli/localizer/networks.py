"""Every network that estimates a pose, by name: ours, and all of the paper's Tables 1 and 2."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

import torch
from torch import nn

from twonav_cli.errors import unknown_name
from twonav_cli.localizer.autoencoder import StackedAutoencoder
from twonav_cli.localizer.belief_network import BeliefNetwork
from twonav_cli.localizer.heads import HEADS, Head
from twonav_cli.localizer.paper_networks import CNNS, Cnn


@dataclass(frozen=True)
class NetworkSpec:
    """One network.

    Attributes:
        pictures: What it is shown, a name of PICTURES.
        head: What its output means, a name of HEADS.
        make: Makes the module for a number of outputs.
        training: Settings of TrainingConfig that suit it, where they differ from the usual ones (ours).
    """

    pictures: str
    head: str
    make: Callable[[int], nn.Module]
    training: Mapping[str, Any] = field(default_factory=dict)

    def build(self, head: Head) -> nn.Module:
        """Return a freshly initialised network for a head."""
        network = self.make(head.outputs)
        return network.to(memory_format=torch.channels_last)  # type: ignore[call-overload, no-any-return]  # torch's stub lacks the keyword alone

    @property
    def head_class(self) -> type[Head]:
        """Class of its head."""
        return HEADS[self.head]


_OUR_TRAINING: dict[str, Any] = {"images": 2_500_000, "batch": 256, "peak_rate": 3.5e-3, "variation": 0.05}
_CNN_TRAINING: dict[str, Any] = {
    "variation": 0.0, "batch": 128, "part": 64, "peak_rate": 2.5e-3, "weight_decay": 0.0,
}  # fmt: skip
_SDA_TRAINING: dict[str, Any] = {"variation": 0.0, "pretraining_images": 150_000, "batch": 256, "part": 128}
SDAS: dict[str, tuple[int, ...]] = {
    f"sda-{layers}x{units}": (units,) * layers for layers in (1, 2, 3) for units in (1500, 4000)
}
"""Name to units per layer (Table 1)."""

OURS = "belief"
"""The name of our own network."""

NETWORKS: dict[str, NetworkSpec] = {
    OURS: NetworkSpec("rgb84", "belief", BeliefNetwork, _OUR_TRAINING),
    **{name: NetworkSpec("rgb84", "regression", partial(Cnn, spec), _CNN_TRAINING) for name, spec in CNNS.items()},
    **{
        f"{name}-hsv": NetworkSpec("hsv84", "regression", partial(Cnn, spec), _CNN_TRAINING)
        for name, spec in CNNS.items()
    },
    **{
        name: NetworkSpec(
            "hsv36", "regression", partial(StackedAutoencoder, units),
            # Measured: three layers learn worse at the rate that is best for one.
            {**_SDA_TRAINING, "peak_rate": 3e-3 / len(units)},
        )
        for name, units in SDAS.items()
    },
}  # fmt: skip
"""Name to network."""


def network_spec(name: str) -> NetworkSpec:
    """Return a network's entry in NETWORKS.

    Raises:
        TwonavError: There is no network of that name.
    """
    if name not in NETWORKS:
        raise unknown_name("network", name, NETWORKS)
    return NETWORKS[name]
