"""Buffered values of each track as Rerun columns: one function per track, no state.

A track is a list of values of one kind that share their moments; it fills one or more entities. Everything under
/drive/map is in the map frame, in metres, y up: the frame itself turns y for the viewer, whose 2D views have y down.
n rows, N candidates, T poses of a candidate.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.config import ROBOT_FOOTPRINT_M
from twonav_cli.events import DriveTrace
from twonav_cli.geometry import Pose, wrap_angles
from twonav_cli.grid import GridFrame
from twonav_cli.recording.palette import COST_LEVELS, UintArray, cost_colours, packed

FloatArray = NDArray[np.float64]
Filled = list[tuple[str, Any]]
"""Entity and its columns."""

ARROW_M = 0.45
GOAL_RING_M = 0.24
LIDAR_FORWARD_M = 0.02
"""Where the range finder sits, forward of the axle."""
BEAM_ANGLES_RAD = np.linspace(-math.pi / 2, math.pi / 2, 180)
JPEG_QUALITY = 85
MAX_CANDIDATES = 24
CANDIDATE_POSES = 6
SMALLEST_ERROR = 1e-4

_OUTLINE = np.array([*ROBOT_FOOTPRINT_M, ROBOT_FOOTPRINT_M[0]])


class Candidates(NamedTuple):
    """What is kept of a drive trace."""

    strips: NDArray[np.float32]
    """[N, T, 2]"""
    colours: UintArray
    """[N]"""
    best: NDArray[np.float32]
    """[1, T, 2], or [0, T, 2] when none was admissible."""


class CostPatch(NamedTuple):
    """A cost map of few levels and where it lies."""

    levels: NDArray[np.uint8]
    frame: GridFrame


class Marks(NamedTuple):
    """Labelled points that accumulate."""

    points: list[tuple[float, float]]
    labels: list[str]
    colours: list[int]


class GoalErrors(NamedTuple):
    """TD errors of every goal, ready to be drawn."""

    at_start: int
    """Goals that the recording began with: a curve has a fixed number of lines, so later ones get their own."""
    powers: FloatArray
    """[G] log10."""


def log10_error(td_errors: FloatArray) -> FloatArray:
    """Return log10 of TD errors of any shape, cut at SMALLEST_ERROR: plots have no logarithmic axis."""
    return np.asarray(np.log10(np.maximum(td_errors, SMALLEST_ERROR)), dtype=np.float64)


def goal_errors(at_start: int, td_errors: FloatArray) -> GoalErrors:
    """Return the TD errors of the goals [G] as they are drawn."""
    return GoalErrors(at_start, log10_error(td_errors))


@lru_cache
def _spread(count: int, most: int) -> NDArray[np.intp]:
    """Return at most `most` indices, evenly from the first to the last of `count`."""
    return np.linspace(0, max(count - 1, 0), min(most, count)).astype(np.intp)


def thinned_candidates(trace: DriveTrace) -> Candidates:
    """Return at most MAX_CANDIDATES candidates, evenly over the cost order, with CANDIDATE_POSES positions each."""
    count, poses = trace.candidates.shape[:2]
    at = _spread(poses, CANDIDATE_POSES)
    chosen = np.argsort(trace.costs)[_spread(count, MAX_CANDIDATES)]
    strips = trace.candidates[chosen[:, None], at].astype(np.float32)
    best = trace.candidates[[trace.best] if trace.best >= 0 else []][:, at].astype(np.float32)
    return Candidates(strips, cost_colours(trace.costs[chosen]), best)


def cost_patch(trace: DriveTrace) -> CostPatch:
    """Return the cost map in COST_LEVELS levels."""
    levels = np.clip(np.ceil(trace.cost_map * (COST_LEVELS - 1)), 0, COST_LEVELS - 1)
    return CostPatch(levels.astype(np.uint8), trace.cost_frame)


def pose_array(poses: Sequence[Pose]) -> FloatArray:
    """Return poses as an array [n, 3]."""
    return np.array(poses, dtype=np.float64).reshape(-1, 3)


def arrows(poses: FloatArray) -> Any:
    """Return an arrow for each pose [n, 3]."""
    heading = np.stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])], axis=1)
    return rr.Arrows2D.columns(origins=poses[:, :2], vectors=ARROW_M * heading)


def _outlines(poses: FloatArray) -> FloatArray:
    """Return the robot's outline [n, 9, 2] in the map frame at each pose [n, 3]."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    rotation = np.stack([np.stack([cos, sin], -1), np.stack([-sin, cos], -1)], axis=1)
    return np.asarray(_OUTLINE @ rotation + poses[:, None, :2], dtype=np.float64)


def error_columns(name: str, true: FloatArray, other: FloatArray) -> Filled:
    """Return how far other poses [n, 3] are from the true ones [n, 3], in metres and degrees."""
    distance = np.hypot(*(other - true)[:, :2].T)
    turn = np.degrees(np.abs(wrap_angles(other[:, 2] - true[:, 2])))
    return [
        (f"metrics/position_error/{name}", rr.Scalars.columns(scalars=distance)),
        (f"metrics/heading_error/{name}", rr.Scalars.columns(scalars=turn)),
    ]


def pose_columns(values: Sequence[tuple[Pose, Pose]]) -> Filled:
    """True and believed pose of a tick: arrows, the line between them, the outline, the errors."""
    true, believed = pose_array([v[0] for v in values]), pose_array([v[1] for v in values])
    between = np.stack([true[:, :2], believed[:, :2]], axis=1).astype(np.float32)
    # A row of a transform replaces all of it, so the turn to y down comes with every row.
    here = np.concatenate([true[:, :2], np.zeros((len(true), 1))], axis=1)
    return [
        ("drive/map/robot/true", arrows(true)),
        ("drive/map/robot/believed", arrows(believed)),
        ("drive/map/robot/error", rr.LineStrips2D.columns(strips=between)),
        ("drive/map/robot/footprint", rr.LineStrips2D.columns(strips=_outlines(true).astype(np.float32))),
        ("drive/map/here", rr.Transform3D.columns(translation=here, scale=np.tile((1.0, -1.0, 1.0), (len(here), 1)))),
        *error_columns("believed", true, believed),
    ]


def estimate_columns(values: Sequence[tuple[Pose, Pose]]) -> Filled:
    """True pose and the pose that the robot takes for its own after a look."""
    true, estimate = pose_array([v[0] for v in values]), pose_array([v[1] for v in values])
    return [("drive/map/robot/estimate", arrows(estimate)), *error_columns("estimate", true, estimate)]


def position_columns(values: Sequence[tuple[float, float]]) -> Filled:
    """Position in a stage without poses: the centre of the cell."""
    return [("drive/map/robot/cell", rr.Points2D.columns(positions=np.array(values, dtype=np.float32)))]


def scan_columns(values: Sequence[tuple[Pose, NDArray[np.float32]]]) -> Filled:
    """Laser points in the map frame; beams that read the cut (the largest range) are left out."""
    poses, scans = pose_array([v[0] for v in values]), np.stack([v[1] for v in values])
    hit = scans < scans.max(axis=1, keepdims=True) - 1e-4
    angles = poses[:, 2:] + BEAM_ANGLES_RAD
    xs = poses[:, :1] + LIDAR_FORWARD_M * np.cos(poses[:, 2:]) + scans * np.cos(angles)
    ys = poses[:, 1:2] + LIDAR_FORWARD_M * np.sin(poses[:, 2:]) + scans * np.sin(angles)
    points = np.stack([xs, ys], axis=-1)[hit].astype(np.float32)
    return [("drive/map/scan", rr.Points2D.columns(positions=points).partition(hit.sum(axis=1)))]


def _strips(strips: Sequence[NDArray[np.float32]]) -> Any:
    """Return one row per array [k, T, 2] of k strips."""
    return rr.LineStrips2D.columns(strips=np.concatenate(strips)).partition([len(s) for s in strips])


def candidate_columns(values: Sequence[Candidates]) -> Filled:
    """Candidate motions coloured by cost, and the chosen one."""
    lengths = [len(v.strips) for v in values]
    colours = rr.LineStrips2D.columns(colors=np.concatenate([v.colours for v in values])).partition(lengths)
    return [
        ("drive/map/dwa/candidates", [*_strips([v.strips for v in values]), *colours]),
        ("drive/map/dwa/best", _strips([v.best for v in values])),
    ]


def cost_columns(values: Sequence[CostPatch]) -> Filled:
    """Local cost map as an image, and where its top left corner lies."""
    rows, cols = (max(v.levels.shape[axis] for v in values) for axis in (0, 1))
    # Windows at the map's border may be smaller; they are filled up right and below, away from their corner.
    pixels = np.zeros((len(values), rows, cols), dtype=np.uint8)
    for row, value in enumerate(values):
        pixels[row, : value.levels.shape[0], : value.levels.shape[1]] = value.levels
    formats = [rr.components.ImageFormat(width=cols, height=rows, channel_datatype="U8")] * len(values)
    corner = np.array([(v.frame.x_min_m, v.frame.y_max_m, 0.0) for v in values])
    scale = np.array([(v.frame.resolution_m, -v.frame.resolution_m, 1.0) for v in values])
    return [
        ("drive/map/dwa/cost", rr.SegmentationImage.columns(buffer=pixels.reshape(len(values), -1), format=formats)),
        ("drive/map/dwa/cost", rr.Transform3D.columns(translation=corner, scale=scale)),
    ]


def camera_columns(values: Sequence[NDArray[np.uint8]]) -> Filled:
    """Camera pictures [84, 84, 3] as JPEG: 1.3 kB instead of 21."""
    import cv2

    quality = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
    blobs = [cv2.imencode(".jpg", image[..., ::-1], quality)[1].tobytes() for image in values]
    return [("camera/rgb", rr.EncodedImage.columns(blob=blobs, media_type=["image/jpeg"] * len(blobs)))]


def trail_columns(values: Sequence[NDArray[np.float32]]) -> Filled:
    """Way driven so far in the trial: one strip [k, 2] per row."""
    return [("drive/map/robot/trail", rr.LineStrips2D.columns(strips=list(values)))]


def goal_columns(values: Sequence[tuple[float, float]]) -> Filled:
    """Position of the goal that is driven to."""
    centers = np.array(values, dtype=np.float32)
    return [("drive/map/goal", rr.Ellipses2D.columns(centers=centers, half_sizes=np.full_like(centers, GOAL_RING_M)))]


def mark_columns(values: Sequence[Marks]) -> Filled:
    """All failures so far as points, and the latest ones with their names."""
    recent = [Marks(v.points[-6:], v.labels[-6:], v.colours[-6:]) for v in values]
    return [
        ("drive/map/failures/all", _points(values, with_labels=False)),
        ("drive/map/failures/latest", _points(recent, with_labels=True)),
    ]


def _points(values: Sequence[Marks], *, with_labels: bool) -> Any:
    lengths = [len(v.points) for v in values]
    columns = [
        *rr.Points2D.columns(positions=np.concatenate([np.array(v.points, np.float32) for v in values])).partition(
            lengths
        ),
        *rr.Points2D.columns(colors=packed([c for v in values for c in v.colours])).partition(lengths),
    ]
    if with_labels:
        labels = [label for v in values for label in v.labels]
        columns += rr.Points2D.columns(labels=labels).partition(lengths)
    return columns


def scalars(entity: str) -> Callable[[Sequence[Any]], Filled]:
    """Return what fills a curve, or several of one entity."""

    def fill(values: Sequence[Any]) -> Filled:
        return [(entity, rr.Scalars.columns(scalars=np.array(values, dtype=np.float64)))]

    return fill


def _state(entity: str) -> Callable[[Sequence[str]], Filled]:
    def fill(values: Sequence[str]) -> Filled:
        return [(entity, rr.StateChange.columns(state=list(values)))]

    return fill


def curves_of_goals(entity: str, at_start: int, powers: FloatArray) -> Filled:
    """Return a row of lines [n, G] of the goals at the start, and a line of its own for each later goal."""
    later = [
        (f"{entity}/goal_{index:02d}", rr.Scalars.columns(scalars=powers[:, index]))
        for index in range(at_start, powers.shape[1])
    ]
    return [(entity, rr.Scalars.columns(scalars=powers[:, :at_start])), *later]


def _goal_curves(entity: str) -> Callable[[Sequence[GoalErrors]], Filled]:
    def fill(values: Sequence[GoalErrors]) -> Filled:
        powers = np.full((len(values), max(len(value.powers) for value in values)), np.nan)
        for row, value in enumerate(values):
            powers[row, : len(value.powers)] = value.powers
        return curves_of_goals(entity, values[0].at_start, powers)

    return fill


def choice_mark_columns(values: Sequence[tuple[float, int]]) -> Filled:
    """TD error (log10) and colour of a goal at the moment when it was chosen."""
    marks = rr.Scalars.columns(scalars=[value[0] for value in values])
    colours = rr.SeriesPoints.columns(colors=packed([value[1] for value in values]))
    return [("learning/chosen", [*marks, *colours])]


def log_columns(values: Sequence[tuple[str, str]]) -> Filled:
    """Sentences with their level."""
    return [("log", rr.TextLog.columns(level=[v[0] for v in values], text=[v[1] for v in values]))]


def rows(entity: str) -> Callable[[Sequence[dict[str, Any]]], Filled]:
    """Return what fills machine-readable rows; every value has the same keys."""

    def fill(values: Sequence[dict[str, Any]]) -> Filled:
        columns: dict[str, Any] = {key: [value[key] for value in values] for key in values[0]}
        return [(entity, rr.AnyValues.columns(**columns))]

    return fill


def table_columns(values: Sequence[str]) -> Filled:
    """Tables of the last trials in Markdown."""
    types = ["text/markdown"] * len(values)
    return [("learning/trials", rr.TextDocument.columns(text=list(values), media_type=types))]


COLUMNS: dict[str, Callable[[Sequence[Any]], Filled]] = {
    "pose": pose_columns,
    "estimate": estimate_columns,
    "position": position_columns,
    "scan": scan_columns,
    "candidates": candidate_columns,
    "cost": cost_columns,
    "camera": camera_columns,
    "trail": trail_columns,
    "goal": goal_columns,
    "failures": mark_columns,
    "log": log_columns,
    "trials": rows("trials"),
    "choices": rows("choices"),
    "learned": rows("learned"),
    "added": rows("added"),
    "warnings": rows("warnings"),
    "table": table_columns,
    "step/q": scalars("metrics/q_values"),
    "step/td_error": _goal_curves("metrics/td_error"),
    "state/goal": _state("state/goal"),
    "state/outcome": _state("state/outcome"),
    "state/cause": _state("state/why"),
    "learning/td_error": _goal_curves("learning/td_error"),
    "learning/chosen": choice_mark_columns,
    "learning/round": scalars("learning/round"),
    "learning/steps": scalars("learning/steps"),
    "learning/reached": scalars("learning/reached"),
    "fit/loss": scalars("train/loss"),
    "fit/learning_rate": scalars("train/learning_rate"),
    "fit/images_per_s": scalars("train/images_per_s"),
}
"""Track to the function that fills its entities."""
