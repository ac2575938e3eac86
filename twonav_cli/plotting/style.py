"""How every picture looks: size, colours told apart by colour-blind readers (Okabe-Ito), and a marker for each line."""

from __future__ import annotations

import io
from typing import NamedTuple

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

WIDTH_IN, DOTS_PER_INCH = 8.4, 105
"""882 pixels: the width of a page on GitHub."""

PAPER_COLOUR = "#333333"
FLOOR_COLOUR = "#888888"


class Look(NamedTuple):
    """Colour and marker of a line."""

    colour: str
    marker: str


LOOKS: dict[str, Look] = {
    "single": Look("#D55E00", "o"),
    "multi": Look("#0072B2", "s"),
    "multi-random": Look("#56B4E9", "X"),
    "optimistic": Look("#009E73", "D"),
    "prioritized-sweeping": Look("#CC79A7", "v"),
    "nearest-untried": Look("#E69F00", "^"),
    "oracle": Look("#F0E442", "P"),
    "random": Look("#E69F00", "o"),
    "td-error": Look("#0072B2", "s"),
    "sequential": Look("#009E73", "D"),
}
"""Method, or goal selection, to its look."""


def look_of(method: str) -> Look:
    """Return the look of a method; its first word decides when it is not in the table."""
    return LOOKS.get(method) or LOOKS.get(method.split()[0]) or Look(PAPER_COLOUR, "o")


def new_figure(height_in: float) -> Figure:
    """Return an empty figure of the page's width, which needs no display."""
    return Figure(figsize=(WIDTH_IN, height_in), dpi=DOTS_PER_INCH, layout="constrained")


def tidy(axes: Axes) -> None:
    """Take away the frame's upper and right side and draw a faint grid behind the data."""
    axes.spines[["top", "right"]].set_visible(False)
    axes.grid(True, color="#DDDDDD", linewidth=0.6)
    axes.set_axisbelow(True)


def in_thousands(value: float, position: int | None = None) -> str:
    """Return an axis label in thousands."""
    return f"{value / 1000:g}k" if value else "0"


THOUSANDS = FuncFormatter(in_thousands)


def png_bytes(figure: Figure) -> bytes:
    """Return a figure as a PNG file; the same figure gives the same bytes."""
    file = io.BytesIO()
    figure.savefig(file, format="png", metadata={"Software": None})
    return file.getvalue()
