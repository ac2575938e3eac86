"""What is printed outside the play screen: the two consoles, the one red line of an error, progress bars, tables."""

from __future__ import annotations

import os
import sys
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress
    from rich.table import Table


@lru_cache(maxsize=1)
def out() -> Console:
    """Return the console of standard output; rich itself honours NO_COLOR, TERM=dumb and pipes."""
    from rich.console import Console

    return Console(highlight=False, emoji=False)


@lru_cache(maxsize=1)
def err() -> Console:
    """Return the console of standard error."""
    from rich.console import Console

    return Console(stderr=True, highlight=False, emoji=False)


def new_table(*headings: str) -> Table:
    """Return a table of figures: names in the first column, numbers in the others; headings stand at the bottom."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), collapse_padding=True)
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="right" if number else "left", vertical="bottom")
    return table


def fail(message: str) -> None:
    """Print an error as one red line on standard error."""
    err().print(f"error: {' '.join(message.split())}", style="bold red", markup=False, soft_wrap=True)


def in_colour() -> bool:
    """Whether standard output shows colours: a terminal that is not dumb, and NO_COLOR is not set."""
    return sys.stdout.isatty() and not colour_refused()


def colour_refused() -> bool:
    """Whether the surroundings ask for no colour (NO_COLOR, TERM=dumb)."""
    return bool(os.environ.get("NO_COLOR")) or dumb()


def dumb() -> bool:
    """Whether the terminal cannot move its cursor."""
    return os.environ.get("TERM", "").lower() in ("dumb", "unknown")


def screen_possible() -> bool:
    """Whether a play screen can be shown: both ends are a terminal, and it is not dumb."""
    return sys.stdin.isatty() and sys.stdout.isatty() and not dumb()


def progress() -> Progress:
    """Return a progress bar on standard error: what, how far, how long still, and the numbers that matter.

    Tasks are added with `result=""`; updates put the numbers there. Where no bar can be drawn, only lines are printed.
    """
    from rich.progress import (
        BarColumn,
        MofNCompleteColumn,
        Progress,
        TextColumn,
        TimeElapsedColumn,
        TimeRemainingColumn,
    )

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=30, complete_style="cyan", finished_style="cyan"),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        TimeRemainingColumn(),
        TextColumn("{task.fields[result]}"),
        console=err(),
        disable=not err().is_terminal,
    )
