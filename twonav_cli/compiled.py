"""The decorator of hot loops. Only modules with a hot loop import this one: it brings numba."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

import numba

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """Compile a function at its first call and keep the result on disk beside the module."""
    return cast(F, numba.njit(cache=True)(function))


def inlined(function: F) -> F:
    """Compile a function so that it vanishes into the compiled loop that calls it: no call, no reference counts."""
    return cast(F, numba.njit(cache=True, forceinline=True)(function))
