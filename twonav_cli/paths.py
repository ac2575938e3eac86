"""Where things lie: what is shipped with the package, and what a run writes."""

from __future__ import annotations

import os
from pathlib import Path

PACKAGE = Path(__file__).resolve().parent
CHECKOUT = PACKAGE.parent


def _in_checkout() -> bool:
    return (CHECKOUT / "pyproject.toml").is_file() and (CHECKOUT / "scenes").is_dir()


def scenes_dir() -> Path:
    """Return the folder of the shipped scenes: beside the package in a checkout, inside it when installed."""
    return CHECKOUT / "scenes" if _in_checkout() else PACKAGE / "shipped" / "scenes"


def checkpoints_dir() -> Path:
    """Return the folder of the shipped checkpoints: beside the package in a checkout, inside it when installed."""
    return CHECKOUT / "checkpoints" if _in_checkout() else PACKAGE / "shipped" / "checkpoints"


def runs_dir() -> Path:
    """Return the folder that runs write to.

    `$TWONAV_RUNS` when set, else `runs/` of the checkout, else the user's data folder.
    """
    chosen = os.environ.get("TWONAV_RUNS")
    if chosen:
        return Path(chosen)
    if _in_checkout():
        return CHECKOUT / "runs"
    import platformdirs

    return Path(platformdirs.user_data_dir("twonav", appauthor=False)) / "runs"
