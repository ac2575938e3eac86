"""Buffered values of the mapper as Rerun columns: one function per track, as in `columns`.

Everything under /mapping/map is in the map frame, in metres, y up. n rows, P particles, N hits, K keyframes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.geometry import Pose
from twonav_cli.recording.columns import Filled, Marks, rows, scalars
from twonav_cli.recording.palette import VIRIDIS, UintArray

FloatArray = NDArray[np.float64]

ARROW_M = 0.4
PARTICLE_ARROW_M = 0.15
NAMED = 4
"""Troubles with a name on the map, the latest ones."""

CURVES = {
    "effective": "filter/effective",
    "unmatched": "filter/unmatched",
    "spread_m": "curves/spread_m",
    "spread_deg": "curves/spread_deg",
    "correction_m": "curves/correction_m",
    "correction_deg": "curves/correction_deg",
    "from_odometry_m": "curves/from_odometry_m",
    "from_odometry_deg": "curves/from_odometry_deg",
    "error_m": "curves/error_m",
    "error_deg": "curves/error_deg",
}
"""Field of `KeyframeFigures` to the entity of its curve."""


class Particles(NamedTuple):
    """The particles of one keyframe."""

    poses: NDArray[np.float32]
    """[P, 3]"""
    weights: FloatArray
    """[P]"""


def weight_colours(weights: FloatArray) -> UintArray:
    """Return a colour per particle [P]: dark where it weighs nothing, bright where it weighs most."""
    share = weights / max(float(weights.max(initial=0.0)), 1e-12)
    return np.asarray(VIRIDIS[np.clip(share * 255.0, 0, 255).astype(np.intp)])


def particle_columns(values: Sequence[Particles]) -> Filled:
    """All particles, coloured by weight."""
    poses = np.concatenate([v.poses for v in values])
    heading = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
    colours = np.concatenate([weight_colours(v.weights) for v in values])
    lengths = [len(v.poses) for v in values]
    arrows = rr.Arrows2D.columns(origins=poses[:, :2], vectors=PARTICLE_ARROW_M * heading, colors=colours)
    return [("mapping/map/particles", arrows.partition(lengths))]


def best_columns(values: Sequence[Pose]) -> Filled:
    """The best particle, and the frame of the view that goes along with it."""
    poses = np.array(values, dtype=np.float64)
    # A row of a transform replaces all of it, so the turn to y down comes with every row.
    here = np.concatenate([poses[:, :2], np.zeros((len(poses), 1))], axis=1)
    flip = np.tile((1.0, -1.0, 1.0), (len(poses), 1))
    return [
        ("mapping/map/best", _arrows(poses)),
        ("mapping/map/best/place", rr.Points2D.columns(positions=poses[:, :2])),
        ("mapping/map/here", rr.Transform3D.columns(translation=here, scale=flip)),
    ]


def truth_columns(values: Sequence[tuple[Pose, Pose]]) -> Filled:
    """Where the robot is, and the line from there to where the best particle believes it to be."""
    true, best = (np.array([value[index] for value in values], dtype=np.float64) for index in (0, 1))
    between = np.stack([true[:, :2], best[:, :2]], axis=1).astype(np.float32)
    return [("mapping/map/truth", _arrows(true)), ("mapping/map/error", rr.LineStrips2D.columns(strips=between))]


def odometry_columns(values: Sequence[Pose]) -> Filled:
    """Where odometry alone leads."""
    return [("mapping/map/odometry", _arrows(np.array(values, dtype=np.float64)))]


def hit_columns(values: Sequence[NDArray[np.float32]]) -> Filled:
    """The ends of a scan's beams [N, 2] as the best particle believes them to lie."""
    points = rr.Points2D.columns(positions=np.concatenate(values))
    return [("mapping/map/scan", points.partition([len(value) for value in values]))]


def _arrows(poses: FloatArray) -> Any:
    heading = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
    return rr.Arrows2D.columns(origins=poses[:, :2], vectors=ARROW_M * heading)


def _strip(entity: str) -> Callable[[Sequence[Any]], Filled]:
    """A way so far: one strip [K, 2] per row."""

    def fill(values: Sequence[NDArray[np.float32]]) -> Filled:
        return [(entity, rr.LineStrips2D.columns(strips=list(values)))]

    return fill


def trouble_columns(values: Sequence[Marks]) -> Filled:
    """The places where something went wrong, the latest ones with their names."""
    lengths = [len(v.points) for v in values]
    places = np.concatenate([np.array(v.points, dtype=np.float32) for v in values])
    latest = [v.points[-NAMED:] for v in values]
    named = np.concatenate([np.array(points, dtype=np.float32) for points in latest])
    counts = [len(points) for points in latest]
    labels = [label for v in values for label in v.labels[-NAMED:]]
    names = [
        *rr.Points2D.columns(positions=named).partition(counts),
        *rr.Points2D.columns(labels=labels).partition(counts),
    ]
    return [
        ("mapping/map/trouble", rr.Points2D.columns(positions=places).partition(lengths)),
        ("mapping/map/trouble/latest", names),
    ]


MAPPING_COLUMNS: dict[str, Callable[[Sequence[Any]], Filled]] = {
    "mapping/particles": particle_columns,
    "mapping/best": best_columns,
    "mapping/truth": truth_columns,
    "mapping/odometry": odometry_columns,
    "mapping/hits": hit_columns,
    "mapping/way": _strip("mapping/map/best/way"),
    "mapping/way/latest": _strip("mapping/map/best/latest"),
    "mapping/way/odometry": _strip("mapping/map/odometry/way"),
    "mapping/way/truth": _strip("mapping/map/truth/way"),
    "mapping/trouble": trouble_columns,
    "mapping/resampled": scalars("filter/resampled"),
    **{f"mapping/{name}": scalars(entity) for name, entity in CURVES.items()},
    "keyframes": rows("keyframes"),
    "drawings": rows("drawings"),
}
"""Track to the function that fills its entities."""
