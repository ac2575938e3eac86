"""Trajectory files: `timestamp x y theta` a line, seconds, metres and radians, as the tools that score maps read."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.geometry import Pose
from twonav_cli.mapping.scan import StampedPose


def write_trajectory(path: Path, poses: Iterable[StampedPose]) -> Path:
    """Write poses with six digits, so that a stamp is found again as the log gives it.

    Raises:
        TwonavError: The folder cannot be written.
    """
    lines = [f"{p.stamp_s:.6f} {p.pose.x_m:.6f} {p.pose.y_m:.6f} {p.pose.theta_rad:.6f}\n" for p in poses]
    return write_whole(path, "".join(lines))


def read_trajectory(path: Path) -> list[StampedPose]:
    """Read a trajectory; empty lines and lines that begin with # are passed over.

    Raises:
        TwonavError: There is no such file, or a line is not four finite numbers.
    """
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise TwonavError(f"there is no trajectory at {path}: name another file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise TwonavError(f"{path} cannot be read as a trajectory: {str(error).splitlines()[0]}") from error
    poses = []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.strip() and not line.lstrip().startswith("#"):
            poses.append(_stamped(path, number, line))
    return poses


def _stamped(path: Path, number: int, line: str) -> StampedPose:
    try:
        stamp_s, x_m, y_m, theta_rad = (float(word) for word in line.split())
    except ValueError:
        stamp_s = x_m = y_m = theta_rad = math.nan
    if not all(math.isfinite(value) for value in (stamp_s, x_m, y_m, theta_rad)):
        raise TwonavError(f"{path}, line {number} is not `timestamp x y theta`: {line.strip()[:60]!r}")
    return StampedPose(stamp_s, Pose(x_m, y_m, theta_rad))
