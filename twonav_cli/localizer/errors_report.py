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
    """Return the position and heading errors of poses [N, 3]: mean and deviation (Table 4), median, tail, shares."""
    distance_m, angle_rad = pose_errors(estimated, true)
    angle_deg = np.rad2deg(angle_rad)
    return {
        "n": len(distance_m),
        **_spread("pos", "m", distance_m),
        **_spread("ang", "deg", angle_deg),
        "within_5cm_5deg": float(((distance_m <= 0.05) & (angle_deg <= 5.0)).mean()),
        "within_25cm_2deg": float(((distance_m <= 0.25) & (angle_deg <= 2.0)).mean()),
    }


def _spread(name: str, unit: str, errors: NDArray[np.float64]) -> dict[str, float]:
    return {
        f"{name}_mean_{unit}": float(errors.mean()),
        f"{name}_std_{unit}": float(errors.std()),
        f"{name}_median_{unit}": float(np.median(errors)),
        f"{name}_p95_{unit}": float(np.percentile(errors, 95)),
        f"{name}_p99_{unit}": float(np.percentile(errors, 99)),
    }
