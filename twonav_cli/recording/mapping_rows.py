"""Rows of the mapper: every keyframe with its particles and its scan, the growing map, and what went wrong.

P particles, K keyframes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray

from twonav_cli.events import Event, KeyframeMapped, MapDrawn
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.grid import GridFrame
from twonav_cli.recording.columns import Marks
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.mapping_blueprint import mapping_blueprint
from twonav_cli.recording.mapping_columns import CURVES, Particles
from twonav_cli.recording.mapping_figures import KeyframeFigures, figures_of, moved_most
from twonav_cli.recording.mapping_picture import GrowingPicture, without_border
from twonav_cli.recording.mapping_scenery import write_mapping_looks
from twonav_cli.recording.rrd_file import RrdFile

KEYFRAMES_PER_SHIPMENT = 20
"""Keyframes after which rows are written, so that a killed run loses little."""
JUMP_M, JUMP_DEG = 0.5, 30.0
"""A correction of odometry by more than this is told as a jump."""
CORRECTED_M, CORRECTED_DEG = 0.3, 15.0
"""One by more than this is told, for it shows at a glance on the map: most are a tenth of it (ours)."""
REDRAWN_M = 0.2
"""A way that moved by more than this between two drawings is told: a loop was closed, or another particle leads."""
LOST_M = 0.5
"""Farther than this from the truth the mapper is told to be lost."""
MAX_TROUBLES = 200
"""Marked places on the map, the latest ones."""
FEW_EFFECTIVE = 0.1
"""Drawn again from a smaller share than this, nearly all particles are copies of one or two."""

FIRST_DRAWINGS = 150
"""Pictures of the map that are kept whatever their distance."""
GROWTH = 1.02
"""After those, a picture must be this factor later in keyframes than the one before it."""
MAX_WAY = 1000
"""Points that a way is drawn with."""


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
        self._odometry: list[Pose] = []
        self._truth: list[Pose] = []
        self._latest: list[tuple[float, float]] = []
        self._path: FloatArray = np.empty((0, 3))
        self._troubles = Marks([], [], [])
        self._frame: GridFrame | None = None
        self._waiting: MapDrawn | None = None
        self._drawings = self._drawn_at = 0
        self._picture = GrowingPicture(file)
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
        put("mapping/way/latest", np.array(self._latest, dtype=np.float32), clock, Detail.POSES)
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
        self._before = event
        if self._file.buffered("keyframes") >= KEYFRAMES_PER_SHIPMENT:
            self._file.ship(self._level())

    def drawn(self, event: MapDrawn) -> None:
        """Write a picture of the map with the whole ways, unless the last one is nearly as late in the run."""
        number, moved_m = moved_most(self._path, event.path)
        if moved_m > REDRAWN_M:
            text = f"the way was redrawn: keyframe {number + 1} moved by {moved_m:.2f} m (another particle is the best)"
            self._log("INFO", text, event)
        self._path = event.path.copy()
        rows, cols = event.frame.shape
        size = {"number": event.clock.step, "rows": rows, "cols": cols, "resolution_m": event.frame.resolution_m}
        self._file.put("drawings", size, event.clock, Detail.TRIAL)
        early = self._drawings >= FIRST_DRAWINGS and event.clock.step < self._drawn_at * GROWTH
        if early or self._level() < Detail.FULL:
            self._waiting = event
            return
        canvas = self._draw(event)
        if canvas is not None:
            self._file.show(mapping_blueprint(canvas, truth=bool(self._truth)))

    def close(self) -> None:
        """Write the last picture, and lay the recording out for the map as it is at the end."""
        if self._waiting is not None:
            self._draw(self._waiting)
        if self._frame is not None:
            self._file.show(mapping_blueprint(self._frame, truth=bool(self._truth)))

    def _draw(self, event: MapDrawn) -> GridFrame | None:
        """Write a picture and the ways to there; return the picture's canvas when it is a new one."""
        put, clock = self._file.put, event.clock
        self._drawings, self._drawn_at, self._waiting = self._drawings + 1, clock.step, None
        self._latest = [(float(x_m), float(y_m)) for x_m, y_m in event.path[-1:, :2]]
        self._frame = without_border(event.frame, event.pixels)[0]
        put("mapping/way", _way(event.path), clock, Detail.POSES)
        put("mapping/way/odometry", _way(self._odometry), clock, Detail.POSES)
        if self._truth:
            put("mapping/way/truth", _way(self._truth), clock, Detail.POSES)
        return self._picture.draw(event)

    def _tell(self, event: KeyframeMapped, figures: KeyframeFigures) -> None:
        """Say what went wrong at a keyframe, and mark its place."""
        count, unmatched, error_m = figures.particles, figures.unmatched, figures.error_m
        if unmatched:
            level = "ERROR" if unmatched == count else "WARN"
            text = f"scan matching failed for {unmatched} of {count} particles: they keep odometry"
            self._trouble(level, text, "no match", event)
        if figures.correction_m > JUMP_M or figures.correction_deg > JUMP_DEG:
            jump = f"{figures.correction_m:.2f} m, {figures.correction_deg:.0f} deg"
            self._trouble("WARN", f"the pose jumped {jump} away from odometry's guess", f"jump {jump}", event)
        elif figures.correction_m > CORRECTED_M or figures.correction_deg > CORRECTED_DEG:
            by = f"{figures.correction_m:.2f} m, {figures.correction_deg:.0f} deg"
            self._log("INFO", f"odometry's guess was corrected by {by}", event)
        if figures.resampled:
            level = "WARN" if figures.effective < FEW_EFFECTIVE * count else "DEBUG"
            self._log(level, f"particles drawn again: {figures.effective:.1f} of {count} were effective", event)
        lost = error_m > LOST_M
        if lost and not self._lost:
            self._trouble("ERROR", f"lost: believes to be {error_m:.2f} m from where it is", "lost", event)
        if self._lost and not lost:
            self._log("INFO", f"found again: {error_m:.2f} m from where it is", event)
        self._lost = lost

    def _trouble(self, level: str, text: str, label: str, event: KeyframeMapped) -> None:
        self._log(level, text, event)
        marks = self._troubles
        marks.points.append((event.pose.x_m, event.pose.y_m))
        marks.labels.append(f"{event.clock.step}: {label}")
        latest = Marks(marks.points[-MAX_TROUBLES:], marks.labels[-MAX_TROUBLES:], [])
        self._file.put("mapping/trouble", latest, event.clock, Detail.TRIAL)

    def _log(self, level: str, text: str, event: Event) -> None:
        self._file.put("log", (level, text), event.clock, Detail.TRIAL)


def _way(poses: Sequence[Pose] | FloatArray) -> NDArray[np.float32]:
    """Return the positions [K, 2] of poses, thinned to MAX_WAY from the first to the last."""
    kept = np.linspace(0, max(len(poses) - 1, 0), min(len(poses), MAX_WAY)).astype(np.intp)
    return np.array(poses, dtype=np.float32).reshape(-1, 3)[kept, :2]
