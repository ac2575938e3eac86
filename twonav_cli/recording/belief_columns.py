"""What a look says about the pose as Rerun columns: one function per track, as in `columns`.

Everything is in the map frame, in metres, y up. n rows, K places, P particles; rows, cols of the belief's grid.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.recording.columns import Filled, arrows, error_columns, pose_array, scalars

LEVELS_PER_POWER = 5
POWERS = 3
"""Powers of ten below 1 that are told apart; what is less likely is clear."""

HEAT_LEVELS = LEVELS_PER_POWER * POWERS
HEAT_RGB = np.array([(224, 205, 245), (189, 145, 226), (146, 84, 196), (118, 54, 178), (98, 36, 158)], dtype=np.float64)
"""From pale to dark violet: on the light floor dark is likely, and it is told apart without seeing colours."""


class Places(NamedTuple):
    """Other places where the robot could be."""

    points: NDArray[np.float32]
    """[K, 2]"""
    labels: list[str]
    """[K] their weights."""


def heat_levels(belief: Belief) -> NDArray[np.uint8]:
    """Return the level of every bin [rows, cols] by the logarithm of its probability: 0 below a thousandth."""
    powers = np.log10(np.maximum(belief.grid, 1e-9)) + POWERS
    return np.asarray(np.clip(np.ceil(powers * LEVELS_PER_POWER), 0, HEAT_LEVELS), dtype=np.uint8)


def heat_classes() -> list[tuple[int, str, tuple[int, int, int, int]]]:
    """Return level, what the viewer says when it is pointed at, and colour."""
    share = np.linspace(0.0, 1.0, HEAT_LEVELS)
    at = np.linspace(0.0, 1.0, len(HEAT_RGB))
    red, green, blue = (np.interp(share, at, channel).round().astype(int).tolist() for channel in HEAT_RGB.T)
    upto = 10.0 ** (np.arange(1, HEAT_LEVELS + 1) / LEVELS_PER_POWER - POWERS)
    shown = [(i + 1, f"probability up to {upto[i]:.2g}", (red[i], green[i], blue[i], 255)) for i in range(HEAT_LEVELS)]
    return [(0, "", (0, 0, 0, 0)), *shown]


def heat_columns(values: Sequence[NDArray[np.uint8]]) -> Filled:
    """What a picture alone says, as levels of its bins; every row has the same size."""
    height, width = values[0].shape
    formats = [rr.components.ImageFormat(width=width, height=height, channel_datatype="U8")] * len(values)
    pixels = np.stack(values).reshape(len(values), -1)
    return [("drive/map/belief/heat", rr.SegmentationImage.columns(buffer=pixels, format=formats))]


def place_columns(values: Sequence[Places]) -> Filled:
    """The other places where the robot could be, with their weights."""
    lengths = [len(v.points) for v in values]
    labels = [label for v in values for label in v.labels]
    positions = np.concatenate([v.points for v in values])
    columns = [
        *rr.Points2D.columns(positions=positions).partition(lengths),
        *rr.Points2D.columns(labels=labels).partition(lengths),
    ]
    return [
        ("drive/map/belief/places", rr.Points2D.columns(positions=positions).partition(lengths)),
        ("drive/map/belief/places/weights", columns),
    ]


def cloud_columns(values: Sequence[NDArray[np.float32]]) -> Filled:
    """Particles of the filter [P, 2]."""
    points = rr.Points2D.columns(positions=np.concatenate(values))
    return [("drive/map/belief/particles", points.partition([len(value) for value in values]))]


def picture_columns(values: Sequence[tuple[Pose, Pose]]) -> Filled:
    """True pose and the pose that the picture alone gives, where a filter makes something else of it."""
    true, alone = (pose_array([value[index] for value in values]) for index in (0, 1))
    return [("drive/map/robot/picture", arrows(alone)), *error_columns("picture", true, alone)]


def _floats(values: Sequence[Any]) -> FloatArray:
    return np.array(values, dtype=np.float64)


BELIEF_COLUMNS: dict[str, Callable[[Sequence[Any]], Filled]] = {
    "belief/heat": heat_columns,
    "belief/places": place_columns,
    "belief/cloud": cloud_columns,
    "belief/picture": picture_columns,
    "belief/confidence": scalars("metrics/confidence/estimate"),
    "belief/confidence/picture": scalars("metrics/confidence/picture"),
    "belief/spread": scalars("metrics/spread/filter"),
    "belief/spread/picture": scalars("metrics/spread/picture"),
}
"""Track to the function that fills its entities."""
