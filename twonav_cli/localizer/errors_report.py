"""How far estimates lie from the truth.

N estimates.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.geometry import wrap_angles

Poses = NDArray[np.floating]


def pose_errors(estimated: Poses, true: Poses) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the distances [N] in metres and the absolute angles [N] in radians between poses [N, 3]."""
    difference = np.asarray(estimated, dtype=np.float64) - np.asarray(true, dtype=np.float64)
    return np.hypot(difference[:, 0], difference[:, 1]), np.abs(wrap_angles(difference[:, 2]))


def error_metrics(estimated: Poses, true: Poses) -> dict[str, float]:
    """Return mean, median and tail of the position and heading errors of poses [N, 3] (the measures of Table 4)."""
    distance_m, angle_rad = pose_errors(estimated, true)
    angle_deg = np.rad2deg(angle_rad)
    return {
        "n": len(distance_m),
        "pos_mean_m": float(distance_m.mean()),
        "pos_median_m": float(np.median(distance_m)),
        "pos_p95_m": float(np.percentile(distance_m, 95)),
        "pos_p99_m": float(np.percentile(distance_m, 99)),
        "ang_mean_deg": float(angle_deg.mean()),
        "ang_median_deg": float(np.median(angle_deg)),
        "ang_p95_deg": float(np.percentile(angle_deg, 95)),
    }
