"""A widget that shows a picture in the middle of its frame."""

from __future__ import annotations

from rich.segment import Segment
from rich.style import Style
from textual.strip import Strip
from textual.widget import Widget

from twonav_cli.terminal.screen.picture import Picture


class PicturePanel(Widget):
    """Shows the picture it was last given; much cheaper than markup, for a picture changes with every frame."""

    def __init__(self, title: str, waiting: str, panel_id: str) -> None:
        super().__init__(id=panel_id)
        self.border_title = title
        self._waiting = waiting
        self._picture: Picture | None = None

    def show(self, picture: Picture | None) -> None:
        """Show a picture from the next frame on."""
        if picture is not None or self._picture is not None:
            self._picture = picture
            self.refresh()

    def render_line(self, y: int) -> Strip:
        """Return one line of the inside of the frame."""
        cols, rows = self.size.width, self.size.height
        if self._picture is None:
            text = self._waiting if y == rows // 2 else ""
            return Strip([Segment(text.center(cols)[:cols], self.rich_style)], cols)
        row = y - (rows - self._picture.rows) // 2
        if not 0 <= row < self._picture.rows:
            return Strip([Segment(" " * cols, self.rich_style)], cols)
        segments = [Segment(text, style or Style.null()) for text, style in self._picture.runs(row)]
        left = max((cols - self._picture.cols) // 2, 0)
        right = max(cols - left - self._picture.cols, 0)
        blank = self.rich_style
        whole = [Segment(" " * left, blank), *segments, Segment(" " * right, blank)]
        return Strip(whole, left + self._picture.cols + right).crop(0, cols)
