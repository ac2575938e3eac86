"""The layers that the convolutional networks are made of (Table 2): 5x5 convolutions and inception layers.

B batch; h, w size of a feature map.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval


@dataclass(frozen=True)
class PlainSpec:
    """One 5x5 convolution: its channels, and how much smaller it makes the picture."""

    channels: int
    shrink: int = 1


@dataclass(frozen=True)
class InceptionSpec:
    """One inception layer: channels of its three branches, and the narrow 1x1 convolutions before two of them."""

    one: int
    three_in: int
    three: int
    five_in: int
    five: int
    shrink: int = 1

    @property
    def channels(self) -> int:
        """Channels after the branches are joined."""
        return self.one + self.three + self.five


class Convolution(nn.Module):
    """A convolution, batch normalisation (ours) and a rectifier; smaller by a stride, or by taking the largest."""

    def __init__(self, channels_in: int, channels: int, kernel: int, shrink: int = 1, pooling: bool = False) -> None:
        super().__init__()
        self.conv = nn.Conv2d(channels_in, channels, kernel, 1 if pooling else shrink, kernel // 2, bias=False)
        self.norm: nn.Module = nn.BatchNorm2d(channels)
        self.pool = nn.MaxPool2d(shrink) if pooling and shrink > 1 else None

    def forward(self, x: Tensor) -> Tensor:
        """Map [B, channels_in, h, w] to [B, channels, h / shrink, w / shrink]."""
        x = self.conv(x)
        # The largest is taken before the normalisation: there are fewer numbers after it.
        return torch.relu_(self.norm(x if self.pool is None else self.pool(x)))

    def fold(self) -> None:
        """Merge the normalisation into the convolution where nothing stands between them, for inference."""
        if isinstance(self.norm, nn.BatchNorm2d) and self.pool is None:
            self.conv = fuse_conv_bn_eval(self.conv, self.norm)
            self.norm = nn.Identity()


class Inception(nn.Module):
    """Kernels of 1, 3 and 5 pixels side by side (§4.4.1)."""

    def __init__(self, channels_in: int, spec: InceptionSpec, pooling: bool = False) -> None:
        super().__init__()
        self.one = Convolution(channels_in, spec.one, 1, spec.shrink, pooling)
        self.three = nn.Sequential(
            Convolution(channels_in, spec.three_in, 1),
            Convolution(spec.three_in, spec.three, 3, spec.shrink, pooling),
        )
        self.five = nn.Sequential(
            Convolution(channels_in, spec.five_in, 1),
            Convolution(spec.five_in, spec.five, 5, spec.shrink, pooling),
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map [B, channels_in, h, w] to the joined branches [B, channels, h / shrink, w / shrink]."""
        return torch.cat([self.one(x), self.three(x), self.five(x)], dim=1)


def fold_all(network: nn.Module) -> None:
    """Merge every normalisation of a network into its convolution, for inference."""
    for module in network.modules():
        if isinstance(module, Convolution):
            module.fold()
