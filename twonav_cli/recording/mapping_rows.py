"""Rows of the mapper: every keyframe with its particles and its scan, the growing map, and what went wrong.

P particles, K keyframes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from twonav_cli.events import KeyframeMapped, MapDrawn
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.grid import GridFrame
from twonav_cli.recording.columns import Marks
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.mapping_blueprint import mapping_blueprint
from twonav_cli.recording.mapping_columns import CURVES, Particles, picture_of
from twonav_cli.recording.mapping_figures import KeyframeFigures, figures_of, moved_most
from twonav_cli.recording.mapping_scenery import write_mapping_looks
from twonav_cli.recording.rrd_file import RrdFile

KEYFRAMES_PER_SHIPMENT = 20
"""Keyframes after which rows are written, so that a killed run loses little."""
JUMP_M, JUMP_DEG = 0.3, 10.0
"""A correction of odometry by more than this is told as a jump."""
REDRAWN_M = 0.2
"""A way that moved by more than this between two drawings is told: a loop was closed, or another particle leads."""
LOST_M = 0.5
"""Farther than this from the truth the mapper is told to be lost."""
MAX_TROUBLES = 40
"""Named places on the map, the latest ones."""


class MappingRows:
    """Turns what the mapper says into rows."""

    def __init__(self, file: RrdFile, level: Callable[[], Detail]) -> None:
        """Write what never changes.

        Args:
            file: Where to.
            level: How much of what is buffered is to be written now.
        """
        self._file, self._level = file, level
        self._before: KeyframeMapped | None = None
        self._last: KeyframeFigures | None = None
        self._odometry: list[Pose] = []
        self._truth: list[Pose] = []
        self._latest: list[tuple[float, float]] = []
        self._path: FloatArray = np.empty((0, 3))
        self._troubles = Marks([], [], [])
        self._shown: tuple[GridFrame, bool] | None = None
        self._lost = False
        write_mapping_looks(file.always)

    def keyframe(self, event: KeyframeMapped) -> None:
        """Buffer a keyframe: where everything is, its numbers, and what went wrong."""
        put, clock, pose = self._file.put, event.clock, event.pose
        figures = figures_of(event, self._before)
        put("mapping/best", pose, clock, Detail.POSES)
        put("mapping/odometry", event.pose_odom, clock, Detail.POSES)
        put("mapping/particles", Particles(event.poses.astype(np.float32), event.weights.copy()), clock)
        put("mapping/hits", event.hits.astype(np.float32), clock)
        self._latest.append((pose.x_m, pose.y_m))
        put("mapping/way/latest", _positions(self._latest), clock, Detail.POSES)
        self._odometry.append(event.pose_odom)
        if event.pose_true is not None:
            put("mapping/truth", (event.pose_true, pose), clock, Detail.POSES)
            self._truth.append(event.pose_true)
        numbers = asdict(figures)
        for name in CURVES:
            if np.isfinite(numbers[name]):
                put(f"mapping/{name}", numbers[name], clock, Detail.TRIAL)
        if figures.resampled:
            put("mapping/resampled", figures.effective, clock, Detail.TRIAL)
        put("keyframes", numbers, clock, Detail.TRIAL)
        self._tell(event, figures)
        self._before, self._last = event, figures
        if self._file.buffered("keyframes") >= KEYFRAMES_PER_SHIPMENT:
            self._file.ship(self._level())

    def drawn(self, event: MapDrawn) -> None:
        """Buffer a picture of the map with the whole ways, and make room for it in the view."""
        put, clock = self._file.put, event.clock
        put("mapping/picture", picture_of(event), clock)
        put("mapping/way", _positions(event.path), clock, Detail.POSES)
        put("mapping/way/odometry", _positions(self._odometry), clock, Detail.POSES)
        if self._truth:
            put("mapping/way/truth", _positions(self._truth), clock, Detail.POSES)
        rows, cols = event.frame.shape
        put("drawings", {"rows": rows, "cols": cols, "resolution_m": event.frame.resolution_m}, clock, Detail.TRIAL)
        number, moved_m = moved_most(self._path, event.path)
        if moved_m > REDRAWN_M:
            text = f"the way was redrawn: keyframe {number + 1} moved by {moved_m:.2f} m (another particle is the best)"
            self._log("INFO", text)
        self._path = event.path.copy()
        self._latest = [(float(x_m), float(y_m)) for x_m, y_m in event.path[-1:, :2]]
        self._show(event.frame)

    def _show(self, frame: GridFrame) -> None:
        """Lay the recording out again when the map has outgrown its view."""
        truth = bool(self._truth)
        if self._shown is None or self._shown[1] != truth or not _holds(self._shown[0], frame):
            self._file.show(mapping_blueprint(frame, truth=truth))
            self._shown = frame, truth

    def _tell(self, event: KeyframeMapped, figures: KeyframeFigures) -> None:
        """Say what went wrong at a keyframe, and mark its place."""
        count, unmatched = figures.particles, figures.unmatched
        if unmatched:
            level = "ERROR" if unmatched == count else "WARN"
            text = f"scan matching failed for {unmatched} of {count} particles: they keep odometry"
            self._trouble(level, text, "no match", event.pose)
        if figures.correction_m > JUMP_M or figures.correction_deg > JUMP_DEG:
            text = f"the pose jumped by {figures.correction_m:.2f} m, {figures.correction_deg:.0f} deg from odometry's guess"
            self._trouble("WARN", text, f"jump {figures.correction_m:.2f} m", event.pose)
        if figures.resampled:
            self._log("INFO", f"particles drawn again: {figures.effective:.1f} of {count} were effective", event)
        lost = figures.error_m > LOST_M
        if lost and not self._lost:
            text = f"lost: believes to be {figures.error_m:.2f} m from where it is"
            self._trouble("ERROR", text, f"lost {figures.error_m:.2f} m", event.pose)
        if self._lost and not lost:
            self._log("INFO", f"found again: {figures.error_m:.2f} m from where it is", event)
        self._lost = lost
