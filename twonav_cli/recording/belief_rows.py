"""Rows of what the robot believes after a look: the picture's belief, the filter's particles, how sure it is."""

from __future__ import annotations

import numpy as np
import rerun as rr

from twonav_cli.belief import Belief
from twonav_cli.events import Clock, Filtered, Looked, StepTaken, confidence_of, other_places
from twonav_cli.grid import GridFrame
from twonav_cli.recording.belief_columns import Places, heat_classes, heat_levels
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.rrd_file import RrdFile
from twonav_cli.recording.scenery import image_transform


class BeliefRows:
    """Turns looks into rows; those without a belief leave none."""

    def __init__(self, file: RrdFile) -> None:
        self._file = file
        self._frame: GridFrame | None = None

    def look(self, event: Looked | StepTaken) -> None:
        """Buffer what one look said."""
        belief, filtered, clock = event.belief, event.filtered, event.clock
        if belief is None:
            return
        if belief.frame != self._frame:
            self._frame = belief.frame
            self._file.always(
                "drive/map/belief/heat", image_transform(belief.frame), rr.AnnotationContext(heat_classes())
            )
        put = self._file.put
        put("belief/heat", heat_levels(belief), clock)
        others = other_places(belief, filtered)
        put("belief/places", Places(others[:, 1:].astype(np.float32), [f"{w:.2f}" for w in others[:, 0]]), clock)
        put("belief/confidence", confidence_of(belief, filtered), clock, Detail.POSES)
        put("belief/spread/picture", float(belief.places[0, 3]), clock, Detail.POSES)
        if filtered is not None:
            self._filtered(event, belief, filtered, clock)

    def _filtered(self, event: Looked | StepTaken, belief: Belief, filtered: Filtered, clock: Clock) -> None:
        """Buffer what the filter makes of a look, and beside it what the picture alone says."""
        put = self._file.put
        put("belief/cloud", filtered.particles[:, :2], clock)
        put("belief/confidence/picture", belief.confidence, clock, Detail.POSES)
        put("belief/spread", filtered.spread_m, clock, Detail.POSES)
        if event.pose_true is not None:
            put("belief/picture", (event.pose_true, belief.pose), clock, Detail.POSES)
