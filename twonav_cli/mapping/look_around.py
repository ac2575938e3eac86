"""Finding the pose of a scan when the guess may be far off: other places and headings are tried before giving up."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.cells import CellMap
from twonav_cli.mapping.scan_match import SURE_MATCH, best_pose, likelihood_at, log_prior

SEARCH_STEP_RAD = 0.04
SEARCH_STEPS = 12
"""Headings tried on each side of a guess: to 27 degrees, as far as real odometry was seen to err in a step (ours)."""

SEARCH_BEAMS = 90
"""Beams that are enough to tell headings apart (ours)."""

CLIMBS = 3
"""Headings from which the scan matcher then starts (ours)."""


class Match(NamedTuple):
    """Where a scan fits a map."""

    pose: FloatArray
    """[3] x and y in cells, theta."""
    log_likelihood: float
    share: float
    """Of the beams that fit."""


def found_pose(
    grid: CellMap, points: FloatArray, normals: FloatArray, guesses: Iterable[FloatArray], information: FloatArray,
    rule: FloatArray,
) -> Match:  # fmt: skip
    """Return the best match of a scan near several guesses; the first that is sure ends the search.

    Args:
        grid: Map of one particle.
        points: [N, 2] ends of the beams in the robot's frame, cells.
        normals: [N, 2] across the surfaces.
        guesses: Poses [3] to look around, the likeliest first; at least one.
        information: [3, 3] inverse covariance of each guess.
        rule: As `best_pose` takes it.
    """
    best: Match | None = None
    for guess in guesses:
        for start in _starts(grid, points, normals, guess, information, rule):
            pose, likelihood, share, _ = best_pose(grid, points, normals, start, guess, information, rule)
            if best is None or likelihood > best.log_likelihood:
                best = Match(pose, likelihood, share)
            if share >= SURE_MATCH:
                return best
    assert best is not None
    return best


def _starts(
    grid: CellMap, points: FloatArray, normals: FloatArray, guess: FloatArray, information: FloatArray, rule: FloatArray
) -> Iterable[FloatArray]:
    """Yield where to start climbing: the guess, then the likeliest headings around it."""
    yield guess
    stride = max(1, len(points) // SEARCH_BEAMS)
    headings = guess[2] + SEARCH_STEP_RAD * np.arange(-SEARCH_STEPS, SEARCH_STEPS + 1)
    turned = np.column_stack([np.full((len(headings), 2), guess[:2]), headings])
    values = np.array(
        [
            rule[0] * stride * likelihood_at(grid, points, normals, at, rule[1], 3, stride)[0]
            + log_prior(at, guess, information)
            for at in turned
        ]
    )
    for _ in range(CLIMBS):
        k = int(np.argmax(values))
        values[max(0, k - 1) : k + 2] = -np.inf
        yield turned[k]
