"""The decorators of hot loops. Only modules with a hot loop import this one: it brings numba."""

from __future__ import annotations

import os
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

from twonav_cli.files import digest_of_files
from twonav_cli.paths import PACKAGE

F = TypeVar("F", bound=Callable[..., Any])

CACHES = PACKAGE / "__pycache__"
"""Where compiled code is kept, one folder per state of the sources."""


def sources_of_loops(package: Path = PACKAGE) -> list[Path]:
    """Return every file that compiled code can depend on: those of all folders that hold a hot loop, and the ground."""
    marked = {file.parent for file in package.rglob("*.py") if b"twonav_cli.compiled import" in file.read_bytes()}
    return sorted(file for folder in marked | {package} for file in folder.glob("*.py"))


def keep_cache_apart() -> None:
    """Give this state of the sources a folder of its own for compiled code, unless the user has named one.

    numba looks only at the file of the function that is called, so a change in a function that was compiled into it
    would go unseen: the old code would run on.
    """
    if "NUMBA_CACHE_DIR" in os.environ:
        return
    folder = CACHES / f"numba-{digest_of_files(sources_of_loops())}"
    for other in CACHES.glob("numba-*"):
        if other != folder:
            shutil.rmtree(other, ignore_errors=True)
    os.environ["NUMBA_CACHE_DIR"] = str(folder)


keep_cache_apart()
import numba  # noqa: E402  # it reads the folder when it is imported


def compiled(function: F) -> F:
    """Compile a function at its first call and keep the result on disk."""
    return cast(F, numba.njit(cache=True)(function))


def inlined(function: F) -> F:
    """Compile a function so that it vanishes into the compiled loop that calls it: no call, no reference counts."""
    return cast(F, numba.njit(cache=True, forceinline=True)(function))
