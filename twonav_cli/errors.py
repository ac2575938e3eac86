"""The one exception a user is meant to see, and the sentence that answers a wrong name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class TwonavError(Exception):
    """Something from outside is wrong (scene, map, checkpoint, argument); one line that says what to do."""


def unknown_name(kind: str, name: str, known: Iterable[str]) -> TwonavError:
    """Return the error for a name that is not in a table: the nearest match first, then every right one."""
    right = list(known)
    near = difflib.get_close_matches(name.lower(), [r.lower() for r in right], n=1, cutoff=0.5)
    hint = f"; did you mean {next(r for r in right if r.lower() == near[0])!r}?" if near else "."
    return TwonavError(f"unknown {kind} {name!r}{hint} Known: {', '.join(right) or 'none'}")
