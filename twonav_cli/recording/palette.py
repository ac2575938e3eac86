"""Colours of a recording: told apart by colour-blind readers (Okabe-Ito, Tol), as 0xRRGGBBAA."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

UintArray = NDArray[np.uint32]

GOAL_COLOURS: tuple[int, ...] = (
    0x77AADDFF,
    0xEE8866FF,
    0x44BB99FF,
    0xEEDD88FF,
    0xFFAABBFF,
    0x99DDFFFF,
    0xBBCC33FF,
    0xAA4499FF,
    0xDDDDDDFF,
    0xAAAA00FF,
    0xCC6677FF,
    0x8877CCFF,
)
"""One per goal, repeated from the thirteenth on."""

OUTCOME_COLOURS: dict[str, int] = {
    "reached": 0x009E73FF,
    "time-out": 0xE69F00FF,
    "false-arrival": 0xD55E00FF,
    "given-up": 0x999999FF,
    "unfinished": 0x777777FF,
}
CAUSE_COLOURS: dict[str, int] = {
    "none": 0x444444FF,
    "mislocalized": 0xCC79A7FF,
    "ambiguous view": 0x56B4E9FF,
    "stuck": 0x009E73FF,
    "blocked": 0xD55E00FF,
    "loop": 0xF0E442FF,
    "time-out": 0xE69F00FF,
}
"""Of every cause of a failure."""

TRUE_COLOUR = 0x0072B2FF
BELIEVED_COLOUR = 0xCC3399FF
ESTIMATE_COLOUR = 0xE69F00FF
PICTURE_COLOUR = 0x4A1486FF
PICTURE_CURVE_COLOUR = 0xA58BE8FF
"""The same violet where the ground is dark."""
ERROR_COLOUR = 0xD50000FF
LASER_COLOUR = 0xD55E00FF
TRAIL_COLOUR = 0x4A90C4FF
CHOSEN_COLOUR = 0x111111FF
SHORTEST_COLOUR = 0x999999FF
TOUCHING_COLOUR = 0xE08080FF

VIRIDIS_ANCHORS = np.array(
    [(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (190, 200, 40)], dtype=np.float64
)
"""Five colours of viridis, the last one darkened so that it shows on a light floor."""

WAITING_COLOUR = 0x33333AFF
LEARNED_COLOUR = 0x2F5D50FF
"""Of a goal's lane while it is not its turn, and from the moment on when it is learned."""

COST_LEVELS = 16
"""A cost map is recorded in this many levels: it compresses well and no eye sees more."""


def packed(colours: tuple[int, ...] | list[int]) -> UintArray:
    """Return colours [N] as Rerun wants them (a plain list of three or four numbers is ambiguous)."""
    return np.array(colours, dtype=np.uint32)


def goal_colours(count: int) -> UintArray:
    """Return the colour of each goal [G]."""
    return packed([GOAL_COLOURS[i % len(GOAL_COLOURS)] for i in range(count)])


def _viridis_table() -> UintArray:
    """Return 256 colours from dark to bright."""
    share, at = np.linspace(0.0, 1.0, 256), np.linspace(0.0, 1.0, len(VIRIDIS_ANCHORS))
    red, green, blue = (np.interp(share, at, channel).round().astype(np.uint32) for channel in VIRIDIS_ANCHORS.T)
    return np.asarray((red << 24) | (green << 16) | (blue << 8) | np.uint32(0xFF), dtype=np.uint32)


VIRIDIS = _viridis_table()


def cost_colours(costs: NDArray[np.float32]) -> UintArray:
    """Return a colour per candidate [N]: dark where cheap, bright where dear, red where it would touch something."""
    finite = np.isfinite(costs)
    colours = np.full(costs.shape, TOUCHING_COLOUR, dtype=np.uint32)
    if finite.any():
        kept = costs[finite]
        low = kept.min()
        colours[finite] = VIRIDIS[((kept - low) * (255.0 / max(float(kept.max() - low), 1e-9))).astype(np.intp)]
    return colours


def cost_level_colours() -> list[tuple[int, int, int, int]]:
    """Return the colour of each cost level: free is clear, the rest goes from pale to dark orange."""
    shares = np.linspace(0.0, 1.0, COST_LEVELS)
    return [(0, 0, 0, 0)] + [(int(250 - 90 * s), int(190 - 160 * s), int(90 - 70 * s), 255) for s in shares[1:]]
