"""Calibration: the few numbers that make a network's beliefs as sure as they are right (ours)."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from twonav_cli.belief import Belief


@dataclass(frozen=True)
class Calibration:
    """What makes a belief as sure as it is right.

    Attributes:
        lost: Share of every belief that is spread evenly over the floor, beside what the network leaves open itself.
        scale_m: Factor on every deviation of a place.
        scale_rad: Factor on every deviation of a heading.
        exponent: Of the weights of places and headings, before they are made to add up to 1: 1 / temperature.
        map_m: Deviation of the map itself, metres, which labels that were found on it cannot show.
    """

    lost: float = 0.02
    scale_m: float = 1.25
    scale_rad: float = 1.25
    exponent: float = 1.0
    map_m: float = 0.0

    def applied(self, belief: Belief) -> Belief:
        """Return the belief with these numbers."""
        places, headings = belief.places.copy(), belief.headings.copy()
        for modes, scale in ((places, self.scale_m), (headings, self.scale_rad)):
            modes[:, 0] **= self.exponent
            modes[:, 0] /= modes[:, 0].sum()
            modes[:, -1] *= scale
        places[:, 3] = np.hypot(places[:, 3], self.map_m)
        return replace(belief, places=places, headings=headings, lost=1.0 - (1.0 - self.lost) * (1.0 - belief.lost))
