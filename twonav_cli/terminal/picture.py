"""A picture made of characters: a glyph, its ink and its paper in every place of a terminal.

R rows and C columns are places of the terminal here. Half a place is one square pixel: two pixels stand above each
other in a place, drawn as an upper half block whose ink is the upper and whose paper is the lower pixel.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from rich.style import Style
    from rich.text import Text

HALF_BLOCK = "▀"

Pixels = NDArray[np.uint8]


@dataclass(eq=False)
class Picture:
    """Characters with their colours.

    Attributes:
        glyphs: [R, C] one character each.
        ink: [R, C, 3] RGB of the characters.
        paper: [R, C, 3] RGB behind them.
        bold: [R, C] bool.
        coloured: False for a picture that must be readable without any colour.
    """

    glyphs: NDArray[np.str_]
    ink: Pixels
    paper: Pixels
    bold: NDArray[np.bool_]
    coloured: bool = True

    @property
    def rows(self) -> int:
        """Height in characters."""
        return int(self.glyphs.shape[0])

    @property
    def cols(self) -> int:
        """Width in characters."""
        return int(self.glyphs.shape[1])

    def put(
        self,
        row: int,
        col: int,
        text: str,
        ink: tuple[int, int, int] | None = None,
        paper: tuple[int, int, int] | None = None,
        bold: bool = False,
    ) -> None:
        """Write a text from a place to the right; what lies outside is cut, a colour of None stays as it is."""
        if not 0 <= row < self.rows:
            return
        for at, glyph in enumerate(text, start=col):
            if 0 <= at < self.cols:
                self.glyphs[row, at] = glyph
                self.bold[row, at] = bold
                if ink is not None:
                    self.ink[row, at] = ink
                if paper is not None:
                    self.paper[row, at] = paper

    def runs(self, row: int) -> Iterator[tuple[str, Style | None]]:
        """Yield the pieces of one row that share a style, from left to right."""
        glyphs = self.glyphs[row]
        if not self.coloured:
            yield "".join(glyphs), None
            return
        keys = _style_keys(self.ink[row], self.paper[row], self.bold[row])
        starts = [0, *(np.flatnonzero(keys[1:] != keys[:-1]) + 1).tolist(), self.cols]
        for first, end in pairwise(starts):
            yield "".join(glyphs[first:end]), style_of(int(keys[first]))

    def text(self) -> Text:
        """Return the picture as rich text, one line per row."""
        from rich.text import Text

        text = Text(no_wrap=True, end="")
        for row in range(self.rows):
            for piece, style in self.runs(row):
                text.append(piece, style)
            if row + 1 < self.rows:
                text.append("\n")
        return text


def picture_of_pixels(pixels: Pixels) -> Picture:
    """Return the half-block picture [R, C] of pixels [2 R, C, 3]."""
    rows, cols = pixels.shape[0] // 2, pixels.shape[1]
    glyphs = np.full((rows, cols), HALF_BLOCK, dtype="<U1")
    bold = np.zeros((rows, cols), dtype=np.bool_)
    return Picture(glyphs, pixels[0 : 2 * rows : 2].copy(), pixels[1 : 2 * rows : 2].copy(), bold)


def picture_of_glyphs(glyphs: NDArray[np.str_]) -> Picture:
    """Return a picture [R, C] that has no colours."""
    blank = np.zeros((*glyphs.shape, 3), dtype=np.uint8)
    return Picture(glyphs, blank, blank.copy(), np.zeros(glyphs.shape, dtype=np.bool_), coloured=False)


def _style_keys(ink: Pixels, paper: Pixels, bold: NDArray[np.bool_]) -> NDArray[np.int64]:
    """Return one number per place [C] that holds both colours, each channel cut to 6 bits, and bold.

    Making a style costs 10 us, looking one up 0.1 us: 6 bits keep the number of styles small and are not seen.
    """
    channels = np.concatenate([ink, paper], axis=-1).astype(np.int64) >> 2
    keys = bold.astype(np.int64)
    for channel in range(6):
        keys = (keys << 6) | channels[:, channel]
    return keys


@lru_cache(maxsize=65_536)
def style_of(key: int) -> Style:
    """Return the style that a number of `_style_keys` stands for."""
    from rich.style import Style

    ink, paper = _colour_of(key >> 18 & 0x3FFFF), _colour_of(key & 0x3FFFF)
    return Style(color=ink, bgcolor=paper, bold=bool(key >> 36))


@lru_cache(maxsize=65_536)
def _colour_of(code: int) -> str:
    """Return #rrggbb of three channels of 6 bits."""
    channels = (code >> 12 & 63, code >> 6 & 63, code & 63)
    return "#" + "".join(f"{channel << 2 | channel >> 4:02x}" for channel in channels)
