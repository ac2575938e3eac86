"""A laser log in the CARMEN format as readings: what GMapping, FLIRT and the public data sets use.

B beams, n scans.
"""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose, compose, distance_m, relative_pose, wrap_angle, wrap_angles
from twonav_cli.mapping.carmen_lines import BROKEN, CUT_OFF, CarmenLines, ScanLine, is_place, read_lines
from twonav_cli.mapping.scan import RangeSensor, Reading, StampedPose

SICK_LIMIT_M = 80.0
"""A SICK LMS measures up to here; 81.91 (or 8191) means that nothing was hit."""
NOTHING_SHARE = 0.005
"""In a log without such readings, a largest one that comes this often is another finder's mark for nothing."""

FIELD_OF_VIEW_RAD = math.pi
"""FLASER lines do not say it; the format's range finder looks half around."""

MOUNT_TOLERANCE_M, MOUNT_TOLERANCE_RAD = 0.01, math.radians(0.5)
MOUNT_SHARE = 0.9
"""Lines that must agree where the laser sits, to these tolerances."""

JUMP_M, JUMP_MPS, FARTHEST_M = 2.0, 5.0, 30.0
"""Odometry that goes farther than this from one scan to the next, and faster, was set anew in between; so it was,
however long that took, where the two scans can have nothing in common."""

FARTHEST_S = 3e9
"""From the middle one of all times, about a century: a clock that begins at 1970 is as near as that, milliseconds
among seconds are not."""

OTHER_BEAMS, FAR_IN_TIME, BACK_IN_TIME, NO_POSE = (
    "scans of another number of beams",
    "scans whose time is far from the others'",
    "scans whose time does not go on",
    "scans without a pose",
)
WARNED_SHARE = 0.1
"""Losing more of the scans than this for their time is a warning."""


@dataclass(frozen=True)
class LaserLog:
    """The scans of a log and what became of its lines.

    Attributes:
        sensor: What measured.
        readings: In the order of time.
        odometry: Poses of ODOM lines in the order of time; a log may have none, for scans carry odometry too.
        left_out: Lines that are not used, by what they are.
        warnings: Sentences about what is odd.
    """

    sensor: RangeSensor
    readings: list[Reading]
    odometry: list[StampedPose]
    left_out: dict[str, int]
    warnings: list[str]

    @property
    def duration_s(self) -> float:
        """Time from the first scan to the last."""
        return self.readings[-1].stamp_s - self.readings[0].stamp_s

    @property
    def driven_m(self) -> float:
        """Length of the way by odometry, from the ODOM lines where there are any: they are closer together."""
        way = [stamped.pose for stamped in self.odometry] or [reading.pose_odom for reading in self.readings]
        return sum(distance_m(a, b) for a, b in pairwise(way))

    def first(self, scans: int) -> LaserLog:
        """Return the log as if it had ended after so many scans."""
        kept = self.readings[:scans]
        odometry = [stamped for stamped in self.odometry if kept and stamped.stamp_s <= kept[-1].stamp_s]
        return replace(self, readings=kept, odometry=odometry)


def read_carmen(path: Path, mount: Pose | None = None) -> LaserLog:
    """Read a CARMEN log, plain or packed with gzip.

    FLASER lines are scans; their `ipc_timestamp` is the time. ODOM lines give the pose of scans that have none, or
    whose own never changes, and the length of the way. Everything else is counted.

    Args:
        path: The log.
        mount: Where the laser sits on the robot, when it is known better than the log tells.

    Raises:
        TwonavError: There is no such file, it is not a text log, or there is no scan in it.
    """
    lines = read_lines(path)
    if not lines.scans:
        raise TwonavError(f"{path} has no scans: {_what_it_has(lines)}; name a CARMEN log with FLASER lines")
    left_out, warnings = Counter(lines.others), [] if lines.whole else [CUT_OFF]
    odometry = _in_order(lines.odometry)
    near = _near_in_time(lines.scans)
    left_out[FAR_IN_TIME] = len(lines.scans) - len(near)
    posed = _with_poses(near, odometry, warnings)
    left_out[NO_POSE] = len(near) - len(posed)
    beams = _usual_beams(near)
    kept = [line for line in posed if len(line.ranges_m) == beams]
    left_out[OTHER_BEAMS] = len(posed) - len(kept)
    timely = _without_jumps(_going_on(kept), warnings)
    left_out[BACK_IN_TIME] = len(kept) - len(timely)
    if not timely:
        raise TwonavError(f"{path} has no scan that can be used: no pose in the FLASER lines, and no ODOM lines")
    warnings += _lost(left_out, len(lines.scans))
    ranges_m = np.stack([line.ranges_m for line in timely])
    warnings += _unmeasured(ranges_m)
    sensor = RangeSensor(beam_angles(beams), mount or _mount(near, warnings), nothing_from_m(ranges_m))
    measured_m = np.where(np.isfinite(ranges_m) & (ranges_m > 0.0), ranges_m, np.nan)
    readings = [Reading(line.stamp_s, line.pose_odom, row) for line, row in zip(timely, measured_m, strict=True)]
    return LaserLog(sensor, readings, odometry, {what: count for what, count in left_out.items() if count}, warnings)


def beam_angles(beams: int) -> FloatArray:
    """Return the directions [B] of the beams in the sensor's frame, from right to left.

    An odd number spans -90 to +90 degrees with both ends, an even one begins at -90 and leaves the last out: 181 and
    180 beams are both 1 degree apart.
    """
    spacing_rad = FIELD_OF_VIEW_RAD / (beams - beams % 2)
    return np.asarray(-FIELD_OF_VIEW_RAD / 2 + spacing_rad * np.arange(beams), dtype=np.float64)


def nothing_from_m(ranges_m: FloatArray) -> float:
    """Return the reading from which on nothing was hit, from all readings [n, B] of a log."""
    measured = ranges_m[ranges_m > 0.0]  # a comparison with NaN is False
    if not measured.size or measured.max() >= SICK_LIMIT_M:
        return SICK_LIMIT_M
    largest_m = float(measured.max())
    common = np.count_nonzero(measured == largest_m) >= max(NOTHING_SHARE * ranges_m.size, 2)
    return largest_m if common else SICK_LIMIT_M


def _what_it_has(lines: CarmenLines) -> str:
    found = [f"ODOM lines {len(lines.odometry)}"] * bool(lines.odometry)
    found += [f"{what} {count}" for what, count in lines.others.most_common(3)]
    return f"it holds {', '.join(found)}" if found else "it is empty"


def _near_in_time(scans: list[ScanLine]) -> list[ScanLine]:
    """Return the scans whose time is not absurdly far from that of the scan in the middle of all times."""
    middle_s = sorted(line.stamp_s for line in scans)[len(scans) // 2]
    return [line for line in scans if abs(line.stamp_s - middle_s) <= FARTHEST_S]


def _lost(left_out: Counter[str], scans: int) -> list[str]:
    """Return a sentence for every reason for which more than WARNED_SHARE of the scans are left out."""
    sentences = {
        FAR_IN_TIME: "their time is far from the others' (time must be in seconds)",
        BACK_IN_TIME: "their time does not go on (if the clock was set back, cut the log there and map each part)",
        OTHER_BEAMS: "they have another number of beams (map the log of each range finder by itself)",
        NO_POSE: "they have no pose, and no ODOM lines give one",
    }
    return [
        f"{left_out[what]} of {scans} scans are left out: {sentence}"
        for what, sentence in sentences.items()
        if left_out[what] > WARNED_SHARE * scans
    ] + [f"{left_out[BROKEN]} lines are broken"] * (left_out[BROKEN] > WARNED_SHARE * scans)


def _unmeasured(ranges_m: FloatArray) -> list[str]:
    """Return a sentence when some of the ranges [n, B] are no distances."""
    with np.errstate(invalid="ignore"):
        count = int(np.count_nonzero(~np.isfinite(ranges_m) | (ranges_m < 0.0)))
    return [f"{count} of {ranges_m.size} ranges are negative or not a number: taken as not measured"] if count else []


def _usual_beams(scans: list[ScanLine]) -> int:
    """Return the number of beams that most scans have, of equals the first one's."""
    return Counter(len(line.ranges_m) for line in scans).most_common(1)[0][0]


def _in_order(poses: list[StampedPose]) -> list[StampedPose]:
    return sorted(poses, key=lambda stamped: stamped.stamp_s)


def _with_poses(scans: list[ScanLine], odometry: list[StampedPose], warnings: list[str]) -> list[ScanLine]:
    """Return the scans that have a pose, of their own or between two ODOM lines."""
    standing = len({line.pose_odom for line in scans}) == 1 < len(scans)
    unused = standing and len({stamped.pose for stamped in odometry}) > 1
    if unused:
        warnings.append("the FLASER lines carry no odometry: it is taken from the ODOM lines")
    if not unused and all(is_place(line.pose_odom) for line in scans):
        return scans
    stamps_s = np.array([stamped.stamp_s for stamped in odometry])
    found = []
    for line in scans:
        pose = None if unused or not is_place(line.pose_odom) else line.pose_odom
        pose = pose or _pose_between(odometry, stamps_s, line.stamp_s)
        if pose is not None:
            found.append(line._replace(pose_odom=pose))
    return found


def _pose_between(odometry: list[StampedPose], stamps_s: FloatArray, stamp_s: float) -> Pose | None:
    """Return the pose at a moment on the straight way between two of odometry, None before the first or after."""
    after = int(np.searchsorted(stamps_s, stamp_s))
    if after == len(odometry) or stamp_s < stamps_s[0]:
        return None
    late = odometry[after]
    early = odometry[max(after - 1, 0)]
    share = (stamp_s - early.stamp_s) / (late.stamp_s - early.stamp_s) if late.stamp_s > early.stamp_s else 1.0
    a, b = early.pose, late.pose
    turn_rad = wrap_angle(b.theta_rad - a.theta_rad)
    return Pose(
        a.x_m + share * (b.x_m - a.x_m), a.y_m + share * (b.y_m - a.y_m), wrap_angle(a.theta_rad + share * turn_rad)
    )


def _going_on(scans: list[ScanLine]) -> list[ScanLine]:
    """Return the scans whose time is after that of the scan kept before.

    A time that lies ahead of both scans after it, while these go on, is wrong itself: it would cost all of them.
    """
    kept: list[ScanLine] = []
    last_s = -math.inf
    for index, line in enumerate(scans):
        following = [later.stamp_s for later in scans[index + 1 : index + 3]]
        ahead = len(following) == 2 and last_s < min(following) <= max(following) < line.stamp_s
        if line.stamp_s > last_s and not ahead:
            kept.append(line)
            last_s = line.stamp_s
    return kept


def _without_jumps(scans: list[ScanLine], warnings: list[str]) -> list[ScanLine]:
    """Return the scans as if the robot had stood still where its odometry was set anew."""
    joined: list[ScanLine] = []
    offset: Pose | None = None
    jumps: list[tuple[float, float]] = []
    for before, line in zip(scans[:1] + scans, scans, strict=False):
        away_m = distance_m(before.pose_odom, line.pose_odom)
        if away_m > min(max(JUMP_M, JUMP_MPS * (line.stamp_s - before.stamp_s)), FARTHEST_M):
            jumps.append((line.stamp_s, away_m))
            offset = compose(joined[-1].pose_odom, relative_pose(line.pose_odom, Pose(0.0, 0.0, 0.0)))
        pose = line.pose_odom if offset is None else compose(offset, line.pose_odom)
        joined.append(line._replace(pose_odom=pose))
    if jumps:
        first_s, away_m = jumps[0]
        warnings.append(
            f"odometry jumps by {away_m:.1f} m at time {first_s:.6f} (jumps in all: {len(jumps)}): there the robot is "
            "taken to stand still"
        )
    return joined


def _mount(scans: list[ScanLine], warnings: list[str]) -> Pose:
    """Return where the laser sits on the robot as most lines say, in the middle where they do not agree."""
    posed = [line for line in scans if is_place(line.pose_odom) and is_place(line.pose_laser)]
    seen = [relative_pose(line.pose_odom, line.pose_laser) for line in posed]
    if not seen:
        return Pose(0.0, 0.0, 0.0)
    mounts = np.array(seen)  # [n, 3]
    x_m, y_m = np.median(mounts[:, :2], axis=0)
    theta_rad = math.atan2(np.median(np.sin(mounts[:, 2])), np.median(np.cos(mounts[:, 2])))
    near = np.hypot(mounts[:, 0] - x_m, mounts[:, 1] - y_m) <= MOUNT_TOLERANCE_M
    near &= np.abs(wrap_angles(mounts[:, 2] - theta_rad)) <= MOUNT_TOLERANCE_RAD
    if near.mean() < MOUNT_SHARE:
        warnings.append(
            f"{np.count_nonzero(~near)} of {len(near)} scans say otherwise where the laser sits (poses that were "
            "corrected afterwards?): it is taken to sit in the middle of the robot"
        )
        return Pose(0.0, 0.0, 0.0)
    return Pose(float(x_m), float(y_m), theta_rad)
