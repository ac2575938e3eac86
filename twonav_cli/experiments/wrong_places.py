"""Fig. 9: places where the camera's pose is wrong, and what the picture says there.

N poses.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.experiments.belief_evidence import belief_sentence
from twonav_cli.geometry import FloatArray, Pose, distance_m, wrap_angle
from twonav_cli.mapping.floor import Floor
from twonav_cli.stages.localize import STILL, Image, Localize
from twonav_cli.stages.stage import Observation

WRONG_M = 0.5
"""An estimate that is further off names another place (ours)."""

APART_M = 1.0
"""Places that are shown lie at least so far apart (ours)."""


@dataclass(frozen=True)
class WrongPlace:
    """A look that went wrong.

    Attributes:
        true: Where the robot stood.
        estimate: Where its picture says that it stood.
        image: [84, 84, 3] RGB that it saw.
        belief: What the picture says, where a localizer says it.
        sentence: The same in words.
    """

    true: Pose
    estimate: Pose
    image: NDArray[np.uint8]
    belief: Belief | None
    sentence: str

    @property
    def error_m(self) -> float:
        """How far the estimate is off."""
        return distance_m(self.true, self.estimate)

    def figures(self) -> dict[str, Any]:
        """Return it as JSON can hold it, without the picture."""
        return {
            "true": [round(value, 3) for value in self.true],
            "estimate": [round(value, 3) for value in self.estimate],
            "error_m": round(self.error_m, 3),
            "error_rad": round(abs(wrap_angle(self.estimate.theta_rad - self.true.theta_rad)), 3),
            "confidence": None if self.belief is None else round(self.belief.confidence, 3),
            "sentence": self.sentence,
        }


@dataclass(frozen=True)
class LookedAround:
    """Looks from random poses.

    Attributes:
        looks: How many.
        errors_m: [N] how far each estimate is off.
        wrong: The poses [K, 2, 3] that are wrong: true and estimated.
        shown: The worst of them, far from each other.
    """

    looks: int
    errors_m: FloatArray
    wrong: FloatArray
    shown: list[WrongPlace]


def look_around(
    floor: Floor,
    poses: FloatArray,
    picture: Callable[[Pose], Image],
    localize: Localize,
    shown_at_most: int,
    on_look: Callable[[], None] = lambda: None,
) -> LookedAround:
    """Look from some poses and keep where the estimate is wrong.

    Args:
        floor: Its maze's cells are named in the sentences.
        poses: [N, 3] where the robot is put.
        picture: Puts it there and returns what it sees.
        localize: Says from a picture alone where it was taken.
        shown_at_most: How many of the worst are kept with their pictures.
        on_look: Called after each.
    """
    found: list[WrongPlace] = []
    errors_m = np.zeros(len(poses))
    for number, row in enumerate(poses):
        true = Pose(*(float(value) for value in row))
        image = picture(true)
        localize.forget()
        located = localize(image, STILL)
        errors_m[number] = distance_m(true, located.pose)
        if errors_m[number] > WRONG_M:
            found.append(WrongPlace(true, located.pose, image, located.belief, _sentence(floor, true, located)))
        on_look()
    wrong = np.array([[place.true, place.estimate] for place in found]).reshape(-1, 2, 3)
    return LookedAround(len(poses), errors_m, wrong, _worst_apart(found, shown_at_most))


def _sentence(floor: Floor, true: Pose, located: Any) -> str:
    """Return what was believed, in words; how far off it is where the localizer says nothing more."""
    cells = [floor.maze_frame.cell_at(pose.x_m, pose.y_m) for pose in (located.pose, true)]
    said = belief_sentence(Observation(cells[0], cells[1], true, located.pose, None, located.belief))
    off = f"{distance_m(true, located.pose):.2f} m off"
    return f"{off}. {said}" if said else f"{off}; the network does not say how sure it is."


def _worst_apart(found: list[WrongPlace], at_most: int) -> list[WrongPlace]:
    """Return the places with the largest errors, of which no two are near each other."""
    kept: list[WrongPlace] = []
    for place in sorted(found, key=lambda place: -place.error_m):
        if len(kept) < at_most and all(distance_m(place.true, other.true) >= APART_M for other in kept):
            kept.append(place)
    return kept
