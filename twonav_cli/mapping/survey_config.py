"""How a scene is surveyed, and how the mapper is set for this robot."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from twonav_cli.config import MappingConfig


def _setting(default: Any, sentence: str) -> Any:
    return field(default=default, metadata={"help": sentence})


@dataclass(frozen=True)
class SurveyConfig:
    """How a scene is surveyed."""

    range_noise_m: float = _setting(0.01, "Deviation of a measured range, metres, as of a real laser (ours).")
    waypoint_m: float = _setting(0.4, "Distance between two points that are driven to, metres (ours).")
    view_m: float = _setting(1.5, "Farthest place from which a frontier is looked at, metres (ours).")
    near_m: float = _setting(1.5, "A cell that was seen from nearer than this is seen well, metres (ours).")
    sides: int = _setting(2, "Directions, of eight, from which a cell must have been seen (ours).")
    least_frontier: int = _setting(4, "Cells of the smallest frontier that is looked at (ours).")
    least_unknown: int = _setting(6, "Cells of the smallest unknown region that has a frontier (ours).")
    least_badly_seen: int = _setting(20, "Cells of the smallest region that is looked at again (ours).")
    tries: int = _setting(2, "Times that a place is tried before it is left out (ours).")
    time_limit_s: float = _setting(3600.0, "Simulated time after which the survey ends, seconds (ours).")


SURVEY_MAPPING = MappingConfig(
    error_m_per_m=0.03,
    error_m_per_rad=0.02,
    error_rad_per_m=0.04,
    error_rad_per_rad=0.06,
    error_m=0.01,
    error_rad=0.01,
)
"""The mapper for this robot: the errors of its own odometry (config.OdometryNoise), rounded up. The usual ones are of
unknown robots; with them the filter lets a scan slide along the only wall that it sees (ours)."""

QUICK = SurveyConfig(sides=0, time_limit_s=180.0)
"""Shorter: nothing is looked at again."""
