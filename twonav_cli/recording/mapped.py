"""What a recording of the mapper says when it is read back: how it went, and where it went wrong."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from twonav_cli.recording.mapping_figures import KeyframeFigures


@dataclass(frozen=True)
class Extreme:
    """The largest value of a curve and the keyframe it belongs to."""

    value: float
    keyframe: int


@dataclass(frozen=True)
class MappingSummary:
    """How the mapping went."""

    keyframes: int
    particles: int
    duration_s: float
    """From the first keyframe to the last."""
    resampled: int
    """Times that the particles were drawn again."""
    unmatched: tuple[int, ...]
    """Keyframes where scan matching failed for some particle."""
    lost: tuple[int, ...]
    """Those of them where it failed for all."""
    jump_m: Extreme
    """How far the best pose lay from odometry's guess."""
    jump_deg: Extreme
    from_odometry_m: float
    """How far it lies at the end from where odometry alone leads."""
    error_m: Extreme | None
    """How far it lay from the truth, where there is one."""
    last_error_m: float | None
    rows: int
    """Pixels of the last picture of the map, 0 when none was drawn."""
    cols: int
    resolution_m: float


def mapping_summary(keyframes: Sequence[dict[str, Any]], drawings: Sequence[dict[str, Any]]) -> MappingSummary | None:
    """Return the summary of rows of /keyframes and /drawings, None when there is no keyframe."""
    if not keyframes:
        return None
    all_ = sorted((KeyframeFigures(**row) for row in keyframes), key=lambda figures: figures.number)
    last = all_[-1]
    unmatched = [figures for figures in all_ if figures.unmatched]
    nothing: dict[str, Any] = {"rows": 0, "cols": 0, "resolution_m": 0.0}
    drawing = max(drawings, key=lambda row: int(row["number"]), default=nothing)
    known = not math.isnan(last.error_m)
    return MappingSummary(
        keyframes=len(all_),
        particles=last.particles,
        duration_s=last.time_s - all_[0].time_s,
        resampled=sum(figures.resampled for figures in all_),
        unmatched=tuple(figures.number for figures in unmatched),
        lost=tuple(figures.number for figures in unmatched if figures.unmatched == figures.particles),
        jump_m=_largest(all_, "correction_m"),
        jump_deg=_largest(all_, "correction_deg"),
        from_odometry_m=last.from_odometry_m,
        error_m=_largest(all_, "error_m") if known else None,
        last_error_m=last.error_m if known else None,
        rows=drawing["rows"],
        cols=drawing["cols"],
        resolution_m=drawing["resolution_m"],
    )


def _largest(all_: Sequence[KeyframeFigures], name: str) -> Extreme:
    value, number = max((float(getattr(figures, name)), figures.number) for figures in all_)
    return Extreme(value, number)
