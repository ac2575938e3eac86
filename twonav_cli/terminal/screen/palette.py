"""The colours of the play screen. None of them is told from another by red against green alone."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Rgb = tuple[int, int, int]

OUTSIDE: Rgb = (13, 17, 23)
FLOOR: Rgb = (36, 42, 52)
WALL: Rgb = (168, 178, 192)
TRAIL: Rgb = (38, 132, 150)
SCAN: Rgb = (222, 143, 70)
TRUE: Rgb = (60, 220, 240)
ESTIMATE: Rgb = (240, 90, 220)
GOAL: Rgb = (200, 208, 220)
CURRENT_GOAL: Rgb = (250, 214, 60)
ROOM: Rgb = (128, 140, 158)
DARK: Rgb = (10, 12, 16)
OTHER: Rgb = (214, 150, 255)
TOGETHER: Rgb = (130, 0, 95)
QUIET: Rgb = (110, 122, 140)
ALARM: Rgb = (255, 123, 84)

VIRIDIS: NDArray[np.float64] = np.array(
    [
        (78, 92, 168),
        (64, 112, 160),
        (38, 130, 142),
        (31, 158, 137),
        (53, 183, 121),
        (110, 206, 88),
        (181, 222, 43),
        (253, 231, 37),
    ],
    dtype=np.float64,
)
"""Matplotlib's viridis from a quarter up, its lowest two lightened: the dark end vanishes on a dark terminal."""


def viridis(shares: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the colours [..., 3] of numbers [...] from 0 (dark blue) to 1 (yellow)."""
    places = np.clip(shares, 0.0, 1.0) * (len(VIRIDIS) - 1)
    anchors = np.arange(len(VIRIDIS))
    return np.stack([np.interp(places, anchors, VIRIDIS[:, c]) for c in range(3)], axis=-1).astype(np.uint8)


HEAT: NDArray[np.float64] = np.array([(72, 60, 124), (112, 84, 170), (156, 118, 212), (206, 170, 246), (238, 222, 255)])
"""From dark to pale violet, ever lighter: next to the belief's magenta, and no colour of viridis."""


def heat(shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the colours [..., 3] of a belief's heat [...] from 0 (dark) to 1 (pale)."""
    places = np.clip(shares, 0.0, 1.0) * (len(HEAT) - 1)
    return np.stack([np.interp(places, np.arange(len(HEAT)), HEAT[:, c]) for c in range(3)], axis=-1)


def hexadecimal(colour: Rgb) -> str:
    """Return a colour as #rrggbb."""
    return "#{:02x}{:02x}{:02x}".format(*colour)
