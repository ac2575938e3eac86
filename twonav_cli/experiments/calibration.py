"""Whether a localizer is as sure as it is right: what its beliefs promise, beside where the robot was.

N frames with a belief and a true pose each.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.geometry import FloatArray
from twonav_cli.localizer.calibration_fit import check_pairs, mean_misfit
from twonav_cli.localizer.errors_report import Poses, pose_errors

SHARES = (0.5, 0.9)
"""Probabilities of the regions that are asked about."""

SAMPLES = 1000
"""Poses drawn from a belief to find how much of it lies higher than the truth (ours: a share is then good to 0.01)."""

FAR_M = 0.5
"""An error that confidence should warn of (ours: more than a maze cell)."""


def calibration_report(beliefs: Sequence[Belief], poses: Poses, rng: np.random.Generator) -> dict[str, Any]:
    """Return what beliefs promise beside what true poses [N, 3] keep.

    Returns:
        "places_50", "places_90", "headings_50", "headings_90": the share of truths inside the region of highest
        density that holds so much of the belief; "auroc": how well confidence tells errors above FAR_M from others
        (None when all are of one kind); "far": the share of such errors; "misfit": mean of -log density.

    Raises:
        TwonavError: There is no frame, or not one pose for each.
    """
    check_pairs(beliefs, poses)
    ranks = np.array(
        [_ranks(belief, pose, rng) for belief, pose in zip(beliefs, np.asarray(poses, dtype=np.float64), strict=True)]
    )
    named = np.array([belief.pose for belief in beliefs])
    far = pose_errors(named, poses)[0] > FAR_M
    confidence = np.array([belief.confidence for belief in beliefs])
    report: dict[str, Any] = {"n": len(beliefs)}
    for column, kind in enumerate(("places", "headings")):
        for share in SHARES:
            report[f"{kind}_{share:.0%}".rstrip("%")] = float((ranks[:, column] <= share).mean())
    auroc = area_under_roc(-confidence, far)
    return {**report, "auroc": auroc, "far": float(far.mean()), "misfit": mean_misfit(beliefs, poses)}


def area_under_roc(scores: FloatArray, positive: NDArray[np.bool_]) -> float | None:
    """Return the probability that a positive has a higher score [N] than a negative, ties counting half.

    This is the area under the receiver operating characteristic (the Mann-Whitney statistic); None without both kinds.
    """
    wanted, others = int(positive.sum()), int((~positive).sum())
    if not wanted or not others:
        return None
    _, group, size = np.unique(scores, return_inverse=True, return_counts=True)
    ranks = (np.cumsum(size) - 0.5 * (size - 1))[group]  # from 1; equal scores share the mean of theirs
    return float((ranks[positive].sum() - 0.5 * wanted * (wanted + 1)) / (wanted * others))


def _ranks(belief: Belief, pose: FloatArray, rng: np.random.Generator) -> tuple[float, float]:
    """Return how much of a belief lies where it is denser than at the true pose [3]: of places and of headings.

    What is spread evenly lies nowhere higher than the truth; where the truth lies on the bare floor, a random share of
    it counts as higher, else every truth would lie in the region of a belief that says nothing.
    """
    drawn = belief.sample(SAMPLES, rng)
    place = belief.place_density(drawn[:, :2]) > belief.place_density(pose[None, :2])
    heading = belief.heading_density(drawn[:, 2]) > belief.heading_density(pose[2:])
    found, of_floor = 1.0 - belief.lost, belief.lost * rng.random(2)
    place_rank, heading_rank = (
        found * float(higher.mean()) + (share if higher.all() else 0.0)
        for higher, share in zip((place, heading), of_floor.tolist(), strict=True)
    )
    return place_rank, heading_rank
