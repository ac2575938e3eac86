"""The belief as a heat on the floor plan: coloured pixels, or characters where there is no colour.

R rows, C columns of boxes (half characters in colour, else characters); rows, cols of the belief's grid.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.floor_plan import Sheet

POWERS = 3.0
"""Powers of ten below 1 that the heat shows: a probability of 0.001 in a bin of the belief has no colour any more."""

GLYPHS = ((0.01, ":"), (0.05, "="), (0.2, "%"))
"""Probability from which a character stands on the floor where there is no colour."""

MIXED = 0.85
"""Share of the heat's own colour where it is hottest; the rest is the floor's."""


def boxed(belief: Belief, sheet: Sheet, rows: int, cols: int) -> NDArray[np.float64]:
    """Return the largest probability of the bins that lie in or about each box [R, C] of a sheet."""
    frame, plan = belief.frame, sheet.frame
    xs, ys = frame.centres()
    width_m, height_m = plan.x_max_m - plan.x_min_m, plan.y_max_m - plan.y_min_m
    box_cols = np.floor((xs - plan.x_min_m) / width_m * cols).astype(np.int64)
    box_rows = np.floor((plan.y_max_m - ys) / height_m * rows).astype(np.int64)
    inside = np.outer((box_rows >= 0) & (box_rows < rows), (box_cols >= 0) & (box_cols < cols))
    row_of, col_of = np.broadcast_arrays(box_rows[:, None], box_cols[None])
    found = _bins_about(belief, sheet, rows, cols)
    # Boxes wider than a bin hold several: the largest counts, or a sharp belief would fall between two boxes.
    np.maximum.at(found, (row_of[inside], col_of[inside]), belief.grid[inside])
    return found


def _bins_about(belief: Belief, sheet: Sheet, rows: int, cols: int) -> NDArray[np.float64]:
    """Return the probability of the bin about the centre of each box [R, C]: boxes narrower than a bin share it."""
    frame, plan = belief.frame, sheet.frame
    xs = plan.x_min_m + (np.arange(cols) + 0.5) * (plan.x_max_m - plan.x_min_m) / cols
    ys = plan.y_max_m - (np.arange(rows) + 0.5) * (plan.y_max_m - plan.y_min_m) / rows
    bin_cols = np.floor((xs - frame.x_min_m) / frame.resolution_m).astype(np.int64)
    bin_rows = np.floor((frame.y_max_m - ys) / frame.resolution_m).astype(np.int64)
    inside = np.outer((bin_rows >= 0) & (bin_rows < frame.rows), (bin_cols >= 0) & (bin_cols < frame.cols))
    bins = np.ix_(np.clip(bin_rows, 0, frame.rows - 1), np.clip(bin_cols, 0, frame.cols - 1))
    return np.asarray(np.where(inside, belief.grid[bins], 0.0), dtype=np.float64)


def heat_of(probabilities: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the heat 0 to 1 of probabilities of any shape: their logarithm, so that unlikely places are seen too."""
    return np.clip(1.0 + np.log10(np.maximum(probabilities, 1e-9)) / POWERS, 0.0, 1.0)


def heated(pixels: NDArray[np.uint8], heat: NDArray[np.float64], floor: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Return pixels [R, C, 3] with the heat [R, C] laid over those that are floor [R, C]."""
    share = np.where(floor, heat, 0.0)[..., None]
    # The faintest heat is seen as well: it begins with a fifth of its colour.
    mixed = np.where(share > 0, 0.2 + (MIXED - 0.2) * share, 0.0)
    return np.asarray((1.0 - mixed) * pixels + mixed * palette.heat(share[..., 0]), dtype=np.uint8)


def put_heat_glyphs(glyphs: NDArray[np.str_], probabilities: NDArray[np.float64]) -> None:
    """Write the character of each probability [R, C] on the floor [R, C], in place."""
    floor = glyphs == "."
    for least, glyph in GLYPHS:
        glyphs[floor & (probabilities >= least)] = glyph
