"""The position-estimator networks: strides instead of pooling, so that where an edge is stays known (§3.2.1, Table 2).

B batch, P position bins, H heading bins.
"""

from __future__ import annotations

from dataclasses import dataclass

import torch
from torch import Tensor, nn
from torch.nn.utils.fusion import fuse_conv_bn_eval

from twonav_cli.config import IMAGE_PX
from twonav_cli.errors import unknown_name


@dataclass(frozen=True)
class InceptionSpec:
    """One inception layer: channels of its three branches, and the narrow 1x1 convolutions before two of them."""

    one: int
    three_in: int
    three: int
    five_in: int
    five: int
    stride: int

    @property
    def channels(self) -> int:
        """Channels after the branches are joined."""
        return self.one + self.three + self.five


@dataclass(frozen=True)
class Architecture:
    """A network: a first 5x5 convolution, inception layers, one dense layer, and the output layer (§4.2.2)."""

    first: int
    first_stride: int
    inceptions: tuple[InceptionSpec, ...]
    dense: int = 512


ARCHITECTURES: dict[str, Architecture] = {
    "inception-9": Architecture(
        first=32,
        first_stride=3,
        inceptions=(
            InceptionSpec(16, 16, 32, 8, 16, stride=2),
            InceptionSpec(24, 24, 40, 16, 16, stride=1),
            InceptionSpec(32, 32, 64, 16, 32, stride=2),
            InceptionSpec(32, 32, 64, 16, 32, stride=1),
            InceptionSpec(48, 48, 64, 24, 32, stride=1),
            InceptionSpec(24, 32, 32, 16, 16, stride=1),
        ),
    ),
    "inception-9-slim": Architecture(
        first=24,
        first_stride=3,
        inceptions=(
            InceptionSpec(16, 16, 24, 8, 8, stride=2),
            InceptionSpec(16, 16, 32, 8, 16, stride=1),
            InceptionSpec(32, 32, 48, 16, 16, stride=2),
            InceptionSpec(32, 32, 48, 16, 16, stride=1),
            InceptionSpec(32, 32, 48, 16, 16, stride=1),
            InceptionSpec(24, 32, 32, 16, 16, stride=1),
        ),
    ),
    "inception-9-wide": Architecture(
        first=32,
        first_stride=2,
        inceptions=(
            InceptionSpec(16, 16, 32, 16, 16, stride=2),
            InceptionSpec(24, 24, 48, 16, 24, stride=1),
            InceptionSpec(32, 32, 64, 24, 32, stride=2),
            InceptionSpec(32, 48, 64, 24, 32, stride=1),
            InceptionSpec(48, 64, 96, 32, 48, stride=2),
            InceptionSpec(24, 48, 48, 24, 24, stride=1),
        ),
    ),
}
"""Name to architecture. The paper gives layers and kernels, not widths: those are ours."""


class Convolution(nn.Module):
    """A convolution, batch normalisation and a rectifier."""

    def __init__(self, channels_in: int, channels: int, kernel: int, stride: int = 1) -> None:
        super().__init__()
        self.conv = nn.Conv2d(channels_in, channels, kernel, stride, kernel // 2, bias=False)
        self.norm: nn.Module = nn.BatchNorm2d(channels)

    def forward(self, x: Tensor) -> Tensor:
        """Map [B, channels_in, h, w] to [B, channels, h / stride, w / stride]."""
        return torch.relu_(self.norm(self.conv(x)))

    def fold(self) -> None:
        """Merge the normalisation into the convolution, for inference."""
        if isinstance(self.norm, nn.BatchNorm2d):
            self.conv = fuse_conv_bn_eval(self.conv, self.norm)
            self.norm = nn.Identity()


class Inception(nn.Module):
    """Kernels of 1, 3 and 5 pixels side by side (§4.4.1)."""

    def __init__(self, channels_in: int, spec: InceptionSpec) -> None:
        super().__init__()
        self.one = Convolution(channels_in, spec.one, 1, spec.stride)
        self.three = nn.Sequential(
            Convolution(channels_in, spec.three_in, 1), Convolution(spec.three_in, spec.three, 3, spec.stride)
        )
        self.five = nn.Sequential(
            Convolution(channels_in, spec.five_in, 1), Convolution(spec.five_in, spec.five, 5, spec.stride)
        )

    def forward(self, x: Tensor) -> Tensor:
        """Map [B, channels_in, h, w] to the joined branches [B, channels, h / stride, w / stride]."""
        return torch.cat([self.one(x), self.three(x), self.five(x)], dim=1)


class PoseNetwork(nn.Module):
    """Image to the logits of position and heading bins.

    Two channels with the pixel's own coordinates are joined to the image, so that a strided network knows where an
    edge is (ours).
    """

    coordinates: Tensor

    def __init__(self, architecture: Architecture, position_bins: int, heading_bins: int) -> None:
        super().__init__()
        self.heading_bins = heading_bins
        self.first = Convolution(3, architecture.first, 5, architecture.first_stride)
        # A convolution is linear, so the coordinate channels have a kernel of their own, run once for a whole batch.
        self.place = nn.Conv2d(2, architecture.first, 5, architecture.first_stride, 2, bias=False)
        layers: list[nn.Module] = []
        channels, size = architecture.first, -(-IMAGE_PX // architecture.first_stride)
        for spec in architecture.inceptions:
            layers.append(Inception(channels, spec))
            channels, size = spec.channels, -(-size // spec.stride)
        self.layers = nn.Sequential(*layers)
        self.dense = nn.Linear(channels * size * size, architecture.dense)
        self.out = nn.Linear(architecture.dense, position_bins + heading_bins)
        axis = torch.linspace(-1.0, 1.0, IMAGE_PX)
        rows, cols = torch.meshgrid(axis, axis, indexing="ij")
        self.place_map: Tensor | None = None
        self.register_buffer("coordinates", torch.stack([cols, rows])[None], persistent=False)

    def forward(self, images: Tensor) -> tuple[Tensor, Tensor]:
        """Map images [B, 3, 84, 84], about -1 to 1, to logits [B, P] of position and [B, H] of heading."""
        place = self.place(self.coordinates) if self.place_map is None else self.place_map
        x = self.first.conv(images.contiguous(memory_format=torch.channels_last)) + place
        x = self.layers(torch.relu_(self.first.norm(x)))
        x = torch.relu(self.dense(x.flatten(1)))
        logits = self.out(x)
        return logits[:, : -self.heading_bins], logits[:, -self.heading_bins :]

    def fold(self) -> None:
        """Merge every normalisation into its convolution, and what never changes into one map, for inference."""
        norm = self.first.norm
        if isinstance(norm, nn.BatchNorm2d) and norm.running_var is not None:
            with torch.no_grad():
                scale = norm.weight / torch.sqrt(norm.running_var + norm.eps)
                self.place_map = self.place(self.coordinates) * scale[None, :, None, None]
        for module in self.modules():
            if isinstance(module, Convolution):
                module.fold()


def build_network(name: str, position_bins: int, heading_bins: int) -> PoseNetwork:
    """Return a freshly initialised network of a named architecture.

    Raises:
        TwonavError: There is no architecture of that name.
    """
    if name not in ARCHITECTURES:
        raise unknown_name("architecture", name, ARCHITECTURES)
    network = PoseNetwork(ARCHITECTURES[name], position_bins, heading_bins)
    return network.to(memory_format=torch.channels_last)  # type: ignore[call-overload, no-any-return]  # torch's stub lacks the keyword alone


def network_input(images: Tensor) -> Tensor:
    """Return uint8 images [B, 84, 84, 3] as floats [B, 3, 84, 84] from -1 to 1; memory stays pixel by pixel."""
    return images.permute(0, 3, 1, 2).float().mul_(2.0 / 255.0).sub_(1.0)
