"""Occupancy maps as ROS map_server keeps them: a picture (PGM) and a few lines about it (YAML).

Row 0 of the picture is the top; the origin is the lower left corner of the lower left pixel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.files import digest_of, write_whole
from twonav_cli.grid import GridFrame

OCCUPIED, UNKNOWN, FREE = 0, 205, 254
OCCUPIED_THRESHOLD = 0.65
FREE_THRESHOLD = 0.196
"""With 0.25 an unknown pixel (205) would read as free."""

MAX_PIXELS = 100_000_000
KEYS = ("image", "resolution", "origin")


@dataclass(frozen=True)
class OccupancyMap:
    """A map whose pixels are occupied, unknown or free.

    Attributes:
        frame: Where it lies.
        pixels: [rows, cols] uint8: 0 occupied, 205 unknown, 254 free.
    """

    frame: GridFrame
    pixels: NDArray[np.uint8]

    def __post_init__(self) -> None:
        if self.pixels.shape != self.frame.shape:
            raise TwonavError(f"a map of {self.frame.shape} pixels was given {self.pixels.shape}: make it again")

    @classmethod
    def from_occupied(cls, occupied: NDArray[np.bool_], frame: GridFrame) -> OccupancyMap:
        """Return the map of a scene that is known everywhere, from occupied pixels [rows, cols]."""
        return cls(frame, np.where(occupied, OCCUPIED, FREE).astype(np.uint8))

    @property
    def occupied(self) -> NDArray[np.bool_]:
        """[rows, cols] where something stands."""
        return np.asarray(self.pixels == OCCUPIED)

    @property
    def free(self) -> NDArray[np.bool_]:
        """[rows, cols] where nothing stands; neither this nor occupied is unknown."""
        return np.asarray(self.pixels == FREE)

    @property
    def digest(self) -> str:
        """Digest of pixels and frame: the `map_digest` of a checkpoint."""
        frame = self.frame
        place = f"{frame.x_min_m:.6f} {frame.y_min_m:.6f} {frame.resolution_m:.6f} {frame.rows} {frame.cols}"
        return digest_of([place.encode(), np.ascontiguousarray(self.pixels).tobytes()])


def save_map(map_: OccupancyMap, yaml_path: Path) -> Path:
    """Write the picture beside the YAML file, under the same name, and return the YAML file's path.

    Raises:
        TwonavError: The folder cannot be written.
    """
    frame = map_.frame
    image_path = yaml_path.with_suffix(".pgm")
    header = f"P5\n{frame.cols} {frame.rows}\n255\n".encode()
    write_whole(image_path, header + np.ascontiguousarray(map_.pixels).tobytes())
    lines = (
        f"image: {image_path.name}",
        f"resolution: {frame.resolution_m!r}",
        f"origin: [{frame.x_min_m!r}, {frame.y_min_m!r}, 0.0]",
        "negate: 0",
        f"occupied_thresh: {OCCUPIED_THRESHOLD}",
        f"free_thresh: {FREE_THRESHOLD}",
    )
    return write_whole(yaml_path, "\n".join(lines) + "\n")


def load_map(yaml_path: Path) -> OccupancyMap:
    """Read a map that `save_map` or ROS wrote.

    Raises:
        TwonavError: A file is missing or not what it should be, its thresholds overlap, or no pixel is free.
    """
    settings = _read_settings(yaml_path)
    resolution_m = _number(yaml_path, settings, "resolution", None)
    origin = _origin(yaml_path, settings["origin"])
    grey = _read_pgm(yaml_path.parent / settings["image"])
    if not 1e-3 <= resolution_m <= 100:
        raise TwonavError(f"{yaml_path} has a resolution of {resolution_m} m: give metres per pixel, such as 0.05")
    frame = GridFrame(origin[0], origin[1], resolution_m, *grey.shape)
    dark = grey / 255.0 if _number(yaml_path, settings, "negate", 0.0) else (255.0 - grey) / 255.0
    occupied_from = _number(yaml_path, settings, "occupied_thresh", OCCUPIED_THRESHOLD)
    free_below = _number(yaml_path, settings, "free_thresh", FREE_THRESHOLD)
    if occupied_from < free_below:
        below = f"occupied_thresh ({occupied_from:g}) is below free_thresh ({free_below:g})"
        raise TwonavError(f"{yaml_path}: {below}, so pixels would be both: set it above")
    occupied, free = dark > occupied_from, dark < free_below
    if not free.any():
        raise TwonavError(f"{yaml_path} has no free pixel: check negate and free_thresh, or make the map again")
    pixels = np.full(grey.shape, UNKNOWN, dtype=np.uint8)
    pixels[free] = FREE
    pixels[occupied] = OCCUPIED
    return OccupancyMap(frame, pixels)


def _read_settings(path: Path) -> dict[str, str]:
    """Return the `key: value` lines of a map's YAML file."""
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise TwonavError(f"there is no map at {path}: make one, or name another file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise TwonavError(f"{path} cannot be read as a map: {str(error).splitlines()[0]}") from error
    settings: dict[str, str] = {}
    for line in text.splitlines():
        key, colon, value = line.partition(":")
        if colon and not key.lstrip().startswith("#"):
            settings[key.strip()] = value.split(" #")[0].strip().strip("\"'")
    missing = [key for key in KEYS if not settings.get(key)]
    if missing:
        raise TwonavError(f"{path} is not a map's YAML file: the line `{missing[0]}: ...` is missing")
    return settings


def _number(path: Path, settings: dict[str, str], key: str, default: float | None) -> float:
    """Return a finite number of the settings, or its default where it is not given."""
    if default is not None and key not in settings:
        return default
    try:
        value = float(settings[key])
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise TwonavError(f"{path}: {key} must be a number, it is {settings[key]!r}")
    return value


def _origin(path: Path, text: str) -> tuple[float, float]:
    """Return x and y of an origin such as [-2.4, -0.1, 0.0]."""
    try:
        x_m, y_m, *rest = (float(part) for part in text.strip("[]").split(","))
    except ValueError:
        x_m, y_m, rest = math.nan, math.nan, []
    if not (math.isfinite(x_m) and math.isfinite(y_m)):
        raise TwonavError(f"{path}: origin must be [x, y, yaw], it is {text!r}")
    if rest and abs(rest[0]) > 1e-6:
        raise TwonavError(f"{path}: the map is turned by {rest[0]} rad: turn the picture upright and set yaw to 0")
    return x_m, y_m


def _read_pgm(path: Path) -> NDArray[np.uint8]:
    """Return the pixels [rows, cols] of a binary PGM file of one byte per pixel."""
    try:
        content = path.read_bytes()
    except FileNotFoundError:
        raise TwonavError(f"the map's picture {path} is missing: put it beside the YAML file") from None
    except OSError as error:
        raise TwonavError(f"{path} cannot be read: {error.strerror}") from error
    words, start = _pgm_header(content)
    if len(words) < 4 or words[0] != b"P5" or not all(word.isdigit() for word in words[1:]):
        raise TwonavError(f"{path} is not a binary PGM picture (P5): convert it, for example with ImageMagick")
    cols, rows, white = (int(word) for word in words[1:])
    if not (0 < white < 256 and 0 < rows * cols <= MAX_PIXELS):
        raise TwonavError(f"{path} has {cols} x {rows} pixels of up to {white}: one byte per pixel is needed")
    if len(content) < start + rows * cols:
        raise TwonavError(f"{path} is cut short: {len(content) - start} of {rows * cols} pixels; restore it")
    return np.frombuffer(content, dtype=np.uint8, count=rows * cols, offset=start).reshape(rows, cols)


def _pgm_header(content: bytes) -> tuple[list[bytes], int]:
    """Return the four words of a PGM header, comments left out, and where the pixels start."""
    words: list[bytes] = []
    at = 0
    while len(words) < 4 and at < min(len(content), 4096):
        if content[at : at + 1] == b"#":
            end = content.find(b"\n", at)
            at = end + 1 if end >= 0 else len(content)
        elif content[at : at + 1].isspace():
            at += 1
        else:
            end = at
            while end < len(content) and end - at < 20 and not content[end : end + 1].isspace():
                end += 1
            words.append(content[at:end])
            at = end
    return words, at + 1
