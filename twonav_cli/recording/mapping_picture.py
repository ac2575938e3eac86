"""The growing picture of the map: on a canvas larger than the map, so that it rarely changes its size.

The viewer takes the encoded pictures of one entity for a film, whose frames must be of one size and which cannot be
cleared: every canvas is an entity of its own, covers the one before it and is drawn over it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.events import MapDrawn
from twonav_cli.grid import GridFrame
from twonav_cli.recording.rrd_file import RrdFile
from twonav_cli.recording.scenery import image_transform

ENTITY = "mapping/map/picture"
LOWEST_ORDER = -1000.0
"""Draw order of the first canvas; each is drawn over the one before."""
ROOM = 1.25
"""Edge of a canvas to that of the map it was begun for."""

OCCUPIED, UNKNOWN, FREE = 0, 205, 254
OCCUPIED_GREY, UNKNOWN_GREY, FREE_GREY = 16, 118, 238
_GREY_OF = np.full(256, UNKNOWN_GREY, dtype=np.uint8)
_GREY_OF[OCCUPIED], _GREY_OF[FREE] = OCCUPIED_GREY, FREE_GREY
"""Value of a map's pixel to the grey it is drawn in."""


class GrowingPicture:
    """Writes the map's pictures, each canvas under a name of its own."""

    def __init__(self, file: RrdFile) -> None:
        self._file = file
        self._canvases: list[GridFrame] = []

    def draw(self, event: MapDrawn) -> GridFrame | None:
        """Write a picture as a PNG, a fiftieth of its pixels; return the canvas when it is a new one."""
        import cv2

        new = None
        seen, pixels = without_border(event.frame, event.pixels)
        if not self._canvases or not holds(self._canvases[-1], seen):
            new = covering(around(seen, ROOM), self._canvases[-1:])
            self._begin(new)
        pixels = on_canvas(pixels, seen, self._canvases[-1])
        encoded = cv2.imencode(".png", _GREY_OF[pixels])[1]
        columns = rr.EncodedImage.columns(blob=[encoded.tobytes()], media_type=["image/png"])
        self._file.send(self._entity(), [event.clock], columns)
        return new

    def _begin(self, canvas: GridFrame) -> None:
        """Say where a new canvas lies, and that it is drawn over the others."""
        self._canvases.append(canvas)
        order = rr.EncodedImage.from_fields(draw_order=LOWEST_ORDER + len(self._canvases))
        self._file.always(self._entity(), image_transform(canvas), order)

    def _entity(self) -> str:
        return f"{ENTITY}/{len(self._canvases):02d}"


def without_border(frame: GridFrame, pixels: NDArray[np.uint8]) -> tuple[GridFrame, NDArray[np.uint8]]:
    """Return the part of a map that holds all that is known, or all of it where nothing is."""
    rows, cols = (np.flatnonzero((pixels != UNKNOWN).any(axis=axis)) for axis in (1, 0))
    if not rows.size:
        return frame, pixels
    top, bottom, left, right = rows[0], rows[-1] + 1, cols[0], cols[-1] + 1
    corner = frame.x_min_m + left * frame.resolution_m, frame.y_min_m + (frame.rows - bottom) * frame.resolution_m
    part = GridFrame(float(corner[0]), float(corner[1]), frame.resolution_m, int(bottom - top), int(right - left))
    return part, pixels[top:bottom, left:right]


def on_canvas(pixels: NDArray[np.uint8], frame: GridFrame, canvas: GridFrame) -> NDArray[np.uint8]:
    """Return the pixels of a map [rows, cols] on a canvas that holds it, unknown around it."""
    whole = np.full(canvas.shape, UNKNOWN, dtype=np.uint8)
    top = round((canvas.y_max_m - frame.y_max_m) / frame.resolution_m)
    left = round((frame.x_min_m - canvas.x_min_m) / frame.resolution_m)
    whole[top : top + frame.rows, left : left + frame.cols] = pixels
    return whole


def around(frame: GridFrame, factor: float) -> GridFrame:
    """Return the same cells with others around them, so that every edge grows by a factor."""
    rows, cols = round(frame.rows * (factor - 1.0) / 2), round(frame.cols * (factor - 1.0) / 2)
    x_min_m, y_min_m = frame.x_min_m - cols * frame.resolution_m, frame.y_min_m - rows * frame.resolution_m
    return GridFrame(x_min_m, y_min_m, frame.resolution_m, frame.rows + 2 * rows, frame.cols + 2 * cols)


def covering(frame: GridFrame, others: Sequence[GridFrame]) -> GridFrame:
    """Return the smallest grid that holds a grid and others of the same cells."""
    frames = [frame, *others]
    x_min_m, y_min_m = (min(getattr(f, name) for f in frames) for name in ("x_min_m", "y_min_m"))
    cols = round((max(f.x_max_m for f in frames) - x_min_m) / frame.resolution_m)
    rows = round((max(f.y_max_m for f in frames) - y_min_m) / frame.resolution_m)
    return GridFrame(x_min_m, y_min_m, frame.resolution_m, rows, cols)


def holds(outer: GridFrame, inner: GridFrame) -> bool:
    """Whether a grid covers another."""
    rounding_m = 1e-6
    across = outer.x_min_m <= inner.x_min_m + rounding_m and inner.x_max_m <= outer.x_max_m + rounding_m
    return across and outer.y_min_m <= inner.y_min_m + rounding_m and inner.y_max_m <= outer.y_max_m + rounding_m
