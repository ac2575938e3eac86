"""How the space of the terminal is shared among plan, camera and numbers."""

from __future__ import annotations

from dataclasses import dataclass

FRAME = 2
"""Rows and columns that a panel's border takes."""

LINES_BELOW = 2
"""Prompt and status."""

NUMBER_ROWS = 5
"""Rows the numbers need inside their border."""

PANELS = ("plan", "camera", "numbers")


@dataclass(frozen=True)
class Layout:
    """Outer sizes in characters; a height of 0 hides a panel."""

    plan: tuple[int, int]
    """(columns, rows)."""
    camera: tuple[int, int]
    numbers_rows: int
    columns: int
    """Columns of numbers: 2 (values, poses), 3 (and goals) or 4 (and log)."""


def layout(cols: int, rows: int, aspect: float, alone: str = "", camera: bool = True) -> Layout:
    """Share `cols` x `rows` characters: plan and camera side by side as high as they can be, the numbers below.

    A plan of `aspect` (width over height) of n rows is 2 n aspect columns wide, a square camera image 2 n.

    Args:
        cols: Width of the terminal.
        rows: Height of the terminal.
        aspect: Of the floor plan.
        alone: The one of `PANELS` that has the screen to itself, empty for all three.
        camera: False where the robot has none: the plan has its room too.
    """
    high = max(rows - LINES_BELOW, 1)
    columns = 4 if cols >= 112 else 3 if cols >= 76 else 2
    if alone:
        sizes = {name: (cols, high) if name == alone else (0, 0) for name in PANELS}
        return Layout(sizes["plan"], sizes["camera"], sizes["numbers"][1], columns)
    at_most = int((cols - 2 * FRAME) / (2 * aspect + 2)) if camera else int((cols - FRAME) / (2 * aspect))
    inside = max(min(high - NUMBER_ROWS - 2 * FRAME, at_most), 1)
    if not camera:
        return Layout((cols, inside + FRAME), (0, 0), high - inside - FRAME, columns)
    camera_cols = min(2 * inside + FRAME, cols // 2)
    return Layout((cols - camera_cols, inside + FRAME), (camera_cols, inside + FRAME), high - inside - FRAME, columns)
