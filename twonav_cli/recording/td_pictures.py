"""Pictures of the TD-error tables: one level per cell on a logarithmic scale, told apart from what was never tried.

R rows, C columns, A = 4 actions.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
RGB = tuple[int, int, int]

LOWEST, HIGHEST = -2.0, 4.0
"""Powers of ten between which the levels lie: 0.01 is nothing beside the reward of 100, 10^4 is its square."""
LEVELS_PER_POWER = 4
LEVELS = int((HIGHEST - LOWEST) * LEVELS_PER_POWER) + 1
WALL = 0
FIRST_UNTRIED = LEVELS + 1
"""Level of a cell with one action that was never tried; two, three and four follow."""

WALL_RGB: RGB = (26, 27, 32)
VIRIDIS_ANCHORS = np.array(
    [(68, 1, 84), (59, 82, 139), (33, 145, 140), (94, 201, 98), (253, 231, 37)], dtype=np.float64
)
UNTRIED_RGB: tuple[RGB, ...] = ((250, 200, 205), (245, 170, 185), (240, 140, 165), (232, 110, 150))
"""Of one to four actions never tried: pink is no colour of viridis."""


def td_levels(td_errors: FloatArray, blocked: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return the level of every cell [R, C] by the mean over its actions, whose mean is the goal's TD error (ours).

    Args:
        td_errors: [R, C, A] squared TD error of the latest visit, not a number where there was none.
        blocked: [R, C].
    """
    untried = np.isnan(td_errors).sum(axis=-1)
    mean = np.maximum(np.where(untried > 0, 0.0, td_errors.mean(axis=-1)), 10.0**LOWEST)
    steps = np.rint((np.log10(mean) - LOWEST) * LEVELS_PER_POWER)
    levels = np.where(untried > 0, FIRST_UNTRIED - 1 + untried, 1 + np.minimum(steps, LEVELS - 1))
    return np.where(blocked, WALL, levels).astype(np.uint8)


def level_classes() -> list[tuple[int, str, RGB]]:
    """Return level, what the viewer says when it is pointed at, and colour."""
    share, at = np.linspace(0.0, 1.0, LEVELS), np.linspace(0.0, 1.0, len(VIRIDIS_ANCHORS))
    red, green, blue = (np.interp(share, at, channel).round().astype(int).tolist() for channel in VIRIDIS_ANCHORS.T)
    powers = [LOWEST + step / LEVELS_PER_POWER for step in range(LEVELS)]
    scale = [(1 + i, f"TD error about {10**p:.2g}", (red[i], green[i], blue[i])) for i, p in enumerate(powers)]
    scale[0] = (1, f"TD error {10**LOWEST:g} or less", scale[0][2])
    untried = [(FIRST_UNTRIED + i, f"{i + 1} of 4 actions never tried", colour) for i, colour in enumerate(UNTRIED_RGB)]
    return [(WALL, "wall", WALL_RGB), *scale, *untried]
