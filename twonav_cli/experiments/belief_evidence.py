"""What a lost robot believed, as a sentence: how sure it was, and whether it thought of the true place at all."""

from __future__ import annotations

import numpy as np

from twonav_cli.belief import Belief
from twonav_cli.events import Filtered, confidence_of, other_places
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.stages.stage import Observation

NEAR_M = 0.45
"""A place within this of the true one is the true one (Fox, Burgard, Thrun 1999)."""


def belief_sentence(seen: Observation) -> str:
    """Return what was believed at a look, beside where the robot stood; empty where nobody says."""
    true, estimate = seen.pose_true, seen.pose_estimate
    confidence = confidence_of(seen.belief, seen.filtered)
    if true is None or estimate is None or confidence is None:
        return ""
    near = share_near(seen.belief, seen.filtered, true)
    others = _others_sentence(other_places(seen.belief, seen.filtered), true)
    sure = f"It was {confidence:.2f} sure to be at {_place(estimate)}"
    sentence = f"{sure} and gave the true place, {_place(true)}, {near:.2f}; {others}."
    if seen.filtered is None or seen.belief is None:
        return sentence
    alone = seen.belief
    return (
        f"{sentence} The last picture alone was {alone.confidence:.2f} sure of {_place(alone.pose)} and gave the true "
        f"place {share_near(alone, None, true):.2f}."
    )


def _others_sentence(others: FloatArray, true: Pose) -> str:
    """Return whether the true place is among other places [K, 3] (weight, x_m, y_m)."""
    if not len(others):
        return "it named no other place"
    named = (np.hypot(others[:, 1] - true.x_m, others[:, 2] - true.y_m) <= NEAR_M).any()
    places = "1 other place" if len(others) == 1 else f"{len(others)} other places"
    return f"it named {places}, {'the true one among them' if named else 'none of them the true one'}"


def share_near(belief: Belief | None, filtered: Filtered | None, pose: Pose) -> float:
    """Return the share of what is believed that lies within NEAR_M of a position: the filter's, else the picture's."""
    if filtered is not None:
        x_m, y_m = filtered.particles[:, 0], filtered.particles[:, 1]
        near = np.hypot(x_m - pose.x_m, y_m - pose.y_m) <= NEAR_M
        return filtered.placed * float(near.mean()) if len(near) else 0.0
    if belief is None:
        return 0.0
    weight, x_m, y_m, _ = belief.places.T
    there = float(weight[np.hypot(x_m - pose.x_m, y_m - pose.y_m) <= NEAR_M].sum())
    return (1.0 - belief.lost) * there + belief.lost * min(np.pi * NEAR_M**2 / belief.area_m2, 1.0)


def _place(pose: Pose) -> str:
    return f"({pose.x_m:.1f}, {pose.y_m:.1f}) m"
