"""Where the robot is, asked once per look: of the picture alone, or of every look so far (Eq. 4-5)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.events import Filtered
from twonav_cli.geometry import FloatArray, Pose

if TYPE_CHECKING:
    from twonav_cli.localizer.belief_filter import BeliefFilter, FilteredPose

Image = NDArray[np.uint8]
"""[84, 84, 3] RGB."""

STILL = Pose(0.0, 0.0, 0.0)
"""The motion between two looks of a robot that did not drive."""

PARTICLES_SHOWN = 100
"""Particles of a filter that go along with an event (ours): enough to see their shape."""


@dataclass(frozen=True)
class Located:
    """Where a look says that the robot is."""

    pose: Pose
    belief: Belief | None = None
    """What the picture alone says; None from a localizer that gives poses only."""
    filtered: Filtered | None = None


class Localize(Protocol):
    """Says where the robot is, look by look."""

    def __call__(self, image: Image, motion: Pose) -> Located:
        """Return where the robot is.

        Args:
            image: What it sees.
            motion: How odometry says that it moved since the last look, in its frame then.
        """

    def forget(self) -> None:
        """Know nothing: the next look is the first."""

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw what is random from a stream from here on."""


class FromPicture:
    """The localizer's answer to each picture, whatever was seen before (the paper)."""

    def __init__(self, ask: Callable[[Image], Located]) -> None:
        self._ask = ask

    def __call__(self, image: Image, motion: Pose) -> Located:
        """Return what this picture says."""
        return self._ask(image)

    def forget(self) -> None:
        """Nothing is remembered."""

    def draw_from(self, rng: np.random.Generator) -> None:
        """Nothing is drawn."""


class FromEveryLook:
    """What the belief filter makes of every picture and of the odometry between them (Eq. 4-5)."""

    def __init__(self, believe: Callable[[Image], Belief], belief_filter: BeliefFilter) -> None:
        self._believe = believe
        self._filter = belief_filter

    def __call__(self, image: Image, motion: Pose) -> Located:
        """Move what was believed by the motion (Eq. 4), and weigh it by what the picture says (Eq. 5)."""
        belief = self._believe(image)
        self._filter.predict(motion)
        found = self._filter.correct(belief)
        return Located(found.pose, belief, _shown(found))

    def forget(self) -> None:
        """Know nothing: the next picture alone decides."""
        self._filter.forget()

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw the particles from a stream from here on."""
        self._filter.draw_from(rng)


def _shown(found: FilteredPose) -> Filtered:
    """Return what an event tells of the filter's answer."""
    particles = thinned(found.particles, found.weights, PARTICLES_SHOWN)
    placed = float(found.weights.sum())
    return Filtered(found.probability, found.spread_m, found.spread_rad, particles, found.others[:, :3], placed)


def thinned(particles: FloatArray, weights: FloatArray, count: int) -> NDArray[np.float32]:
    """Return particles [count, 3] of some [P, 3], each as often as its weight [P] asks for (even steps, no draw)."""
    upto = np.cumsum(weights)
    marks = (np.arange(count) + 0.5) / count * upto[-1]
    chosen = np.minimum(np.searchsorted(upto, marks), len(weights) - 1)
    return np.asarray(particles[chosen], dtype=np.float32)
