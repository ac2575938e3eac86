"""The five convolutional networks of Table 2: 7 or 9 layers, 5x5 or inception, with strides or with pooling (§4.2.2).

A network has 5 or 7 convolutional layers, a dense one of 512 and the output (x, y, sin, cos). The paper gives layers
and kernels, not widths, and no normalisation: both are ours. B batch.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn

from twonav_cli.config import IMAGE_PX
from twonav_cli.localizer.layers import Convolution, Inception, InceptionSpec, PlainSpec, fold_all

DENSE = 512
"""Units of the dense layer (Table 2)."""


@dataclass(frozen=True)
class CnnSpec:
    """A network of Table 2: its convolutional layers, and whether they shrink the picture by pooling or by strides."""

    layers: tuple[PlainSpec | InceptionSpec, ...]
    pooling: bool = False


_INCEPTIONS_7 = (
    PlainSpec(32, shrink=3),
    InceptionSpec(16, 16, 32, 8, 16, shrink=2),
    InceptionSpec(24, 24, 40, 16, 16),
    InceptionSpec(32, 32, 64, 16, 32, shrink=2),
    InceptionSpec(24, 32, 32, 16, 16),
)
_INCEPTIONS_9 = (
    *_INCEPTIONS_7[:4],
    InceptionSpec(32, 32, 64, 16, 32),
    InceptionSpec(48, 48, 64, 24, 32),
    InceptionSpec(24, 32, 32, 16, 16),
)

CNNS: dict[str, CnnSpec] = {
    "cnn-7": CnnSpec((PlainSpec(32, 3), PlainSpec(32, 2), PlainSpec(48), PlainSpec(64, 2), PlainSpec(64))),
    "inception-pool-7": CnnSpec(_INCEPTIONS_7, pooling=True),
    "cnn-9": CnnSpec(
        (
            PlainSpec(32, 3), PlainSpec(32, 2), PlainSpec(48), PlainSpec(64, 2),
            PlainSpec(64), PlainSpec(64), PlainSpec(64),
        )
    ),
    "inception-9": CnnSpec(_INCEPTIONS_9),
    "inception-pool-9": CnnSpec(_INCEPTIONS_9, pooling=True),
}  # fmt: skip
"""Name to network, in the order of Table 2."""


class Cnn(nn.Module):
    """A picture to a few numbers: convolutional layers, a dense layer and the output layer."""

    def __init__(self, spec: CnnSpec, outputs: int) -> None:
        super().__init__()
        layers: list[nn.Module] = []
        channels, size = 3, IMAGE_PX
        for layer in spec.layers:
            if isinstance(layer, InceptionSpec):
                layers.append(Inception(channels, layer, spec.pooling))
            else:
                layers.append(Convolution(channels, layer.channels, 5, layer.shrink, spec.pooling))
            channels, size = layer.channels, -(-size // layer.shrink)
        self.layers = nn.Sequential(*layers)
        self.dense = nn.Linear(channels * size * size, DENSE)
        self.out = nn.Linear(DENSE, outputs)

    def forward(self, pictures: Tensor) -> Tensor:
        """Map pictures [B, 3, 84, 84] to numbers [B, outputs]."""
        x = self.layers(pictures.contiguous(memory_format=torch.channels_last))
        x = torch.relu(self.dense(x.flatten(1)))
        # Metres need more digits than bfloat16 has: 3 cm at 7 m.
        with torch.autocast(x.device.type, enabled=False):
            return self.out(x.float())  # type: ignore[no-any-return]  # a module returns Any

    def fold(self) -> None:
        """Merge what can be merged, for inference."""
        fold_all(self)
