"""What a network is shown: a batch of camera pictures in its colours and size, with varied light if wanted.

Colours follow OpenCV's eight-bit convention: hue 0 to 180 (two degrees each), saturation and value 0 to 255. B batch.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import numpy as np
import torch
from torch import Tensor

from twonav_cli.errors import unknown_name

SMALL_PX = 36
"""Edge of the pictures that autoencoders are shown (§4.2.1)."""


def network_input(
    images: Tensor, kind: str, variation: float = 0.0, generator: torch.Generator | None = None
) -> Tensor:
    """Return uint8 RGB pictures [B, 84, 84, 3] as a network wants them.

    Args:
        images: As rendered.
        kind: A name of PICTURES.
        variation: Strength of `varied`; 0 changes nothing.
        generator: Draws the variation.

    Returns:
        Floats [B, 3, 84, 84] from -1 to 1 ("rgb84", "hsv84"), or [B, 3, 36, 36] from 0 to 1 ("hsv36"); memory stays
        pixel by pixel.

    Raises:
        TwonavError: There is no such kind of picture.
    """
    if kind not in PICTURES:
        raise unknown_name("kind of picture", kind, PICTURES)
    pixels = images.float()
    if variation > 0.0:
        pixels = varied(pixels, variation, generator)
    return PICTURES[kind](pixels).permute(0, 3, 1, 2)


def varied(pixels: Tensor, strength: float, generator: torch.Generator | None) -> Tensor:
    """Change light and colour of pixels [B, 84, 84, 3], 0 to 255, in place; edges stay where they are (ours).

    Args:
        pixels: Float RGB.
        strength: Largest relative change of brightness, contrast and of each colour.
        generator: Draws the changes, on the processor.
    """

    def drawn(channels: int, largest: float) -> Tensor:
        even = torch.rand(len(pixels), 1, 1, channels, generator=generator)
        return (largest * (2.0 * even - 1.0)).to(pixels.device)

    gain = (1.0 + drawn(1, strength)) * (1.0 + drawn(3, 0.5 * strength))
    shift = 127.5 * (1.0 + drawn(1, strength)) - 127.5 * gain
    return pixels.mul_(gain).add_(shift)


def hsv_of(pixels: Tensor) -> Tensor:
    """Return hue, saturation and value of float RGB pixels [..., 3], 0 to 255 (OpenCV's eight-bit scale)."""
    red, green, blue = pixels.unbind(-1)
    value = pixels.amax(-1)
    spread = value - pixels.amin(-1)
    sector = 30.0 / spread.clamp(min=1e-9)
    of_red = torch.remainder((green - blue) * sector, 180.0)
    of_green = 60.0 + (blue - red) * sector
    of_blue = 120.0 + (red - green) * sector
    hue = torch.where(value == red, of_red, torch.where(value == green, of_green, of_blue))
    return torch.stack([hue, 255.0 * spread / value.clamp(min=1e-9), value], dim=-1)


@lru_cache
def area_weights(size: int, wanted: int) -> Tensor:
    """Return the share [wanted, size] that each of `size` pixels has in each of `wanted` larger ones."""
    edges = np.arange(wanted + 1) * (size / wanted)
    pixel = np.arange(size)
    overlap = np.minimum(edges[1:, None], pixel + 1) - np.maximum(edges[:-1, None], pixel)
    return torch.from_numpy(np.clip(overlap, 0.0, None) * (wanted / size)).float()


def shrunk(pixels: Tensor, wanted: int) -> Tensor:
    """Return pixels [B, h, w, 3] as [B, wanted, wanted, 3], each the mean of its area, as a whole number."""
    rows = area_weights(pixels.shape[1], wanted).to(pixels.device)
    cols = area_weights(pixels.shape[2], wanted).to(pixels.device)
    return torch.einsum("rh,bhwc,sw->brsc", rows, pixels, cols).round_()


def _rgb84(pixels: Tensor) -> Tensor:
    return pixels.mul_(2.0 / 255.0).sub_(1.0)


def _hsv84(pixels: Tensor) -> Tensor:
    return hsv_of(pixels.clamp_(0.0, 255.0)).mul_(2.0 / _hsv_range(pixels)).sub_(1.0)


def _hsv36(pixels: Tensor) -> Tensor:
    return hsv_of(shrunk(pixels.clamp_(0.0, 255.0), SMALL_PX)).div_(_hsv_range(pixels))


def _hsv_range(pixels: Tensor) -> Tensor:
    return torch.tensor([180.0, 255.0, 255.0], device=pixels.device)


PICTURES: dict[str, Callable[[Tensor], Tensor]] = {"rgb84": _rgb84, "hsv84": _hsv84, "hsv36": _hsv36}
"""Name to the change of float RGB pixels [B, 84, 84, 3], 0 to 255, which may happen in place."""
