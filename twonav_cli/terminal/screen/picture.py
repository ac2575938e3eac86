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
    from rich.color import Color
    from rich.style import Style
    from rich.text import Text

HALF_BLOCK = "▀"
CHANNEL_SHIFTS = np.array([1 << 10, 1 << 5, 1])
"""Where red, green and blue of 5 bits lie in a number."""

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
        glyphs = "".join(self.glyphs[row].tolist())
        if not self.coloured:
            yield glyphs, None
            return
        keys = _style_keys(self.ink[row], self.paper[row], self.bold[row])
        starts = [0, *(np.flatnonzero(keys[1:] != keys[:-1]) + 1).tolist(), self.cols]
        for (first, end), key in zip(pairwise(starts), keys[starts[:-1]].tolist(), strict=True):
            yield glyphs[first:end], style_of(key)

    def text(self) -> Text:
        """Return the picture as rich text, one line per row."""
        from rich.text import Span, Text

        pieces: list[str] = []
        spans: list[Span] = []
        at = 0
        for row in range(self.rows):
            for piece, style in self.runs(row):
                pieces.append(piece)
                if style is not None:
                    spans.append(Span(at, at + len(piece), style))
                at += len(piece)
            pieces.append("\n")
            at += 1
        return Text("".join(pieces[:-1]), no_wrap=True, end="", spans=spans)


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
    """Return one number per place [C] that holds both colours, each channel cut to 5 bits, and bold.

    Making a style costs a hundred times what looking one up does: 5 bits keep their number small and are hardly seen.
    """
    inks, papers = ((colour.astype(np.int64) >> 3) @ CHANNEL_SHIFTS for colour in (ink, paper))
    return np.asarray((bold.astype(np.int64) << 30) | (inks << 15) | papers, dtype=np.int64)


@lru_cache(maxsize=65_536)
def style_of(key: int) -> Style:
    """Return the style that a number of `_style_keys` stands for."""
    from rich.style import Style

    style = Style.from_color(_colour_of(key >> 15 & 0x7FFF), _colour_of(key & 0x7FFF))
    return style + Style(bold=True) if key >> 30 else style


@lru_cache(maxsize=32_768)
def _colour_of(code: int) -> Color:
    """Return the colour of three channels of 5 bits."""
    from rich.color import Color

    red, green, blue = ((code >> shift & 31) << 3 | (code >> shift & 31) >> 2 for shift in (10, 5, 0))
    return Color.from_rgb(red, green, blue)
