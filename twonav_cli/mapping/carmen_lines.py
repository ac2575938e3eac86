"""The lines of a CARMEN log: scans, odometry, and what happened to every other line.

A line is a message: its name, its fields, then `ipc_timestamp host logger_timestamp`
(https://carmen.sourceforge.net/logger_playback.html). B beams.
"""

from __future__ import annotations

import gzip
import math
import re
import zlib
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO, NamedTuple

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.mapping.scan import StampedPose

MAX_BYTES = 1_000_000_000
"""Of a log, unpacked: a day of scans has a tenth of it."""
MIN_BEAMS = 2
POSE_LIMIT_M = 1e6
"""A pose farther away than this is no pose."""
GZIP_MAGIC = b"\x1f\x8b"

COMMENT, BROKEN, UNKNOWN = "comments", "broken lines", "unknown lines"
CUT_OFF = "the compressed log is cut off or damaged: what could be read of it is used"

_MESSAGE = re.compile(r"[A-Z][A-Z0-9_]{1,23}")
_ODOMETRY_STAMP = 7


class ScanLine(NamedTuple):
    """A FLASER line."""

    stamp_s: float
    ranges_m: FloatArray
    """[B] as the line gives them."""
    pose_laser: Pose
    pose_odom: Pose


@dataclass
class CarmenLines:
    """The lines of a log in their order.

    Attributes:
        scans: Of FLASER lines; poses may be no numbers.
        odometry: Of ODOM lines.
        others: What the other lines were, and how many.
        whole: Whether the file could be read to its end.
    """

    scans: list[ScanLine] = field(default_factory=list)
    odometry: list[StampedPose] = field(default_factory=list)
    others: Counter[str] = field(default_factory=Counter)
    whole: bool = True


def read_lines(path: Path) -> CarmenLines:
    """Read a log, packed with gzip or not, as its content says.

    Raises:
        TwonavError: There is no such file, it cannot be read, is not text, or is larger than MAX_BYTES.
    """
    content, whole = _content(path)
    if b"\0" in content[:4096]:
        raise TwonavError(f"{path} is not a text log: name a CARMEN log with FLASER lines (.clf, .log, .gz)")
    lines = CarmenLines(whole=whole)
    for line in content.splitlines():
        if words := line.split():
            _take(lines, words)
    return lines


def _content(path: Path) -> tuple[bytes, bool]:
    """Return the text of a log and whether it is all of it."""
    try:
        with path.open("rb") as file:
            packed = file.read(len(GZIP_MAGIC)) == GZIP_MAGIC
            file.seek(0)
            content, whole = _unpacked(file) if packed else (file.read(MAX_BYTES + 1), True)
    except FileNotFoundError:
        raise TwonavError(f"there is no log at {path}: name a CARMEN log (.clf, .log or .gz)") from None
    except OSError as error:
        raise TwonavError(f"cannot read the log {path}: {error.strerror or error}") from error
    if len(content) > MAX_BYTES:
        raise TwonavError(f"{path} holds more than {MAX_BYTES / 1e9:.0f} GB of text: cut the log into parts")
    return content, whole


def _unpacked(file: BinaryIO) -> tuple[bytes, bool]:
    """Return what a gzip file holds, as far as it goes, and whether it ends as it should."""
    parts: list[bytes] = []
    length = 0
    unpacking = gzip.GzipFile(fileobj=file)
    try:
        while length <= MAX_BYTES and (part := unpacking.read1(1 << 20)):
            parts.append(part)
            length += len(part)
    except (EOFError, zlib.error, gzip.BadGzipFile):
        return b"".join(parts), False
    return b"".join(parts), True


def _take(lines: CarmenLines, words: list[bytes]) -> None:
    """Put one line where it belongs."""
    try:
        if words[0] == b"FLASER":
            lines.scans.append(_scan(words))
        elif words[0] == b"ODOM":
            lines.odometry.append(_odometry(words))
        else:
            lines.others[_kind(words[0])] += 1
    except (ValueError, IndexError):
        lines.others[BROKEN] += 1


def _scan(words: list[bytes]) -> ScanLine:
    """Return `FLASER num_readings [ranges] x y theta odom_x odom_y odom_theta ipc_timestamp ...` as a scan.

    Raises:
        ValueError: A field is no number, or there are too few.
        IndexError: There are too few.
    """
    count = int(words[1])
    rest = words[2 + count :] if MIN_BEAMS <= count < len(words) else []
    ranges_m = np.array(words[2 : 2 + count], dtype=np.float64)
    return ScanLine(_stamp(rest[6]), ranges_m, _pose(rest[:3]), _pose(rest[3:6]))


def _odometry(words: list[bytes]) -> StampedPose:
    """Return `ODOM x y theta tv rv accel ipc_timestamp ...` as a pose.

    Raises:
        ValueError: A field is no finite number.
        IndexError: There are too few.
    """
    pose = _pose(words[1:4])
    if not is_place(pose):
        raise ValueError("no pose")
    return StampedPose(_stamp(words[_ODOMETRY_STAMP]), pose)


def is_place(pose: Pose) -> bool:
    """Whether a pose is one: finite, and not absurdly far away."""
    return all(map(math.isfinite, pose)) and max(abs(pose.x_m), abs(pose.y_m)) < POSE_LIMIT_M


def _pose(words: list[bytes]) -> Pose:
    x_m, y_m, theta_rad = map(float, words)
    return Pose(x_m, y_m, theta_rad)


def _stamp(word: bytes) -> float:
    stamp_s = float(word)
    if not math.isfinite(stamp_s):
        raise ValueError("no time")
    return stamp_s


def _kind(word: bytes) -> str:
    """Return what a line is that is neither a scan nor odometry."""
    if word.startswith((b"#", b'"')):
        return COMMENT
    name = word.decode("ascii", errors="replace")
    return f"{name} lines" if _MESSAGE.fullmatch(name) else UNKNOWN
