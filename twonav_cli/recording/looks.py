"""How often the robot took itself for somewhere else, and how sure it was then: from the rows of its looks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from typing import Any

WRONG_M = 0.5
"""Error from which a look counts as wrong (ours)."""

ERROR, CONFIDENCE = "/metrics/position_error/estimate", "/metrics/confidence/estimate"
"""Entities that tell the error and the confidence of every look."""


@dataclass(frozen=True)
class LookSummary:
    """All looks of a recording whose confidence is known."""

    looks: int
    wrong: int
    """Those whose pose was more than WRONG_M off."""
    confidence_wrong: float | None
    """Median confidence of the wrong ones, None without any."""
    confidence_right: float | None
    """Median confidence of the others."""

    @property
    def wrong_share(self) -> float:
        """Share of the looks that were wrong."""
        return self.wrong / self.looks


def look_summary(errors: Sequence[Any], confidences: Sequence[Any]) -> LookSummary | None:
    """Return the summary of record batches of both entities; None where no look has a confidence."""
    error_at, sure_at = _by_moment(errors), _by_moment(confidences)
    looks = [(error_at[moment], sure) for moment, sure in sure_at.items() if moment in error_at]
    if not looks:
        return None
    wrong = [sure for error_m, sure in looks if error_m > WRONG_M]
    right = [sure for error_m, sure in looks if error_m <= WRONG_M]
    return LookSummary(len(looks), len(wrong), *(median(part) if part else None for part in (wrong, right)))


def _by_moment(batches: Sequence[Any]) -> dict[tuple[Any, ...], float]:
    """Return the values of an entity of scalars by (step, time); of two looks at one moment the later one."""
    found: dict[tuple[Any, ...], float] = {}
    for batch in batches:
        if "step" in batch.schema.names:
            # As plain nanoseconds: the arithmetic of a clock in seconds leaves some that no timedelta holds.
            times = batch["sim_time"].cast("int64").to_pylist()
            columns = batch["step"].to_pylist(), times, batch["Scalars:scalars"].to_pylist()
            found |= {(step, time): float(value[0]) for step, time, value in zip(*columns, strict=True) if value}
    return found
