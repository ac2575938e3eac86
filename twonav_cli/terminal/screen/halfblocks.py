"""A camera image in characters: coloured half-blocks, or shades of ASCII where there is no colour."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.terminal.screen.picture import Picture, picture_of_glyphs, picture_of_pixels

if TYPE_CHECKING:
    from rich.text import Text

SHADES = np.array(list(" .:-=+*#%@"))
LUMINANCE = np.array([0.299, 0.587, 0.114])


def resized(image: NDArray[np.uint8], rows: int, cols: int) -> NDArray[np.uint8]:
    """Return an image [H, W, 3] as [rows, cols, 3]; each new pixel is the mean of the area it covers."""
    sums = image.astype(np.float64)
    for axis, size in ((0, rows), (1, cols)):
        sums = _averaged(sums, axis, size)
    return np.asarray(sums + 0.5, dtype=np.uint8)


def _averaged(values: NDArray[np.float64], axis: int, size: int) -> NDArray[np.float64]:
    """Return the values with one axis cut or stretched to `size`, by differences of the running sum."""
    length = values.shape[axis]
    moved = np.moveaxis(values, axis, 0)
    running = np.concatenate([np.zeros((1, *moved.shape[1:])), np.cumsum(moved, axis=0)])
    edges = np.arange(size + 1) * (length / size)
    whole = np.minimum(edges.astype(np.int64), length - 1)
    share = (edges - whole).reshape(-1, *([1] * (moved.ndim - 1)))
    at_edges = running[whole] * (1 - share) + running[whole + 1] * share
    return np.moveaxis(np.diff(at_edges, axis=0) * (size / length), 0, axis)


def image_picture(image: NDArray[np.uint8], rows: int, cols: int, coloured: bool = True) -> Picture:
    """Return an image [H, W, 3] as a picture of `rows` x `cols` characters; 84 x 84 fits 21 x 42 when halved."""
    if coloured:
        return picture_of_pixels(resized(image, 2 * rows, cols))
    brightness = resized(image, rows, cols) @ LUMINANCE
    return picture_of_glyphs(SHADES[(brightness * (len(SHADES) / 256)).astype(np.int64)])


def image_text(image: NDArray[np.uint8], rows: int, cols: int, coloured: bool = True) -> Text:
    """Return an image [H, W, 3] as rich text of `rows` x `cols` characters."""
    return image_picture(image, rows, cols, coloured).text()
