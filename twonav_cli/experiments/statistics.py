"""Mean, deviation, and the interquartile mean with its bootstrap interval, as the field reports learning runs.

M mazes (strata), n repeats in each, B resamples. A run that gave up has no figure: it counts as infinitely many steps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from twonav_cli.rng import stream

FloatArray = NDArray[np.float64]

RESAMPLES = 2000
"""Resamples of the bootstrap (ours; the end points then move by well under a tenth of the interval's width)."""

BLOCK_VALUES = 2_000_000
"""Values resampled at once: 16 MB."""

DIGITS = 4
"""Decimals that a figure is rounded to, so that tables are equal on machines whose sums differ in the last bit."""


@dataclass(frozen=True)
class Summary:
    """The figures of a group of runs; None where there is none.

    Attributes:
        mean: Over all runs; None when one gave up, since a mean over the others would flatter.
        std: Sample standard deviation over all runs (n - 1); None for one run, or when one gave up.
        iqm: Interquartile mean (Agarwal et al. 2021); None when more than the trimmed quarter gave up.
        ci95: Its bootstrap interval; an end is None where the resamples hold too many runs that gave up, both are with
            one run per maze.
        runs: Number of runs.
        gave_up: Runs without a figure.
    """

    mean: float | None
    std: float | None
    iqm: float | None
    ci95: tuple[float | None, float | None]
    runs: int
    gave_up: int = 0

    def report(self) -> dict[str, Any]:
        """Return the figures as they go into JSON."""
        return {**asdict(self), "ci95": list(self.ci95)}


def interquartile_mean(values: ArrayLike) -> float:
    """Return the mean of the middle half of the values (Agarwal et al. 2021).

    A quarter of the values, rounded down, is left out at each end.
    """
    return float(_trimmed_means(np.asarray(values, dtype=np.float64).reshape(1, -1))[0])


def bootstrap_interval(values: FloatArray, rng: np.random.Generator, resamples: int = RESAMPLES) -> tuple[float, float]:
    """Return the 95 % percentile interval of the interquartile mean, resampled within each maze.

    The mazes stay the same in every resample, so the interval is about these mazes and not about others.

    Args:
        values: [M, n]; infinite where a run gave up. One run per maze cannot vary: both ends are NaN.
        rng: Stream "bootstrap".
        resamples: B.
    """
    if values.shape[1] == 1:
        return np.nan, np.nan
    mazes, repeats = values.shape
    per_block = max(1, BLOCK_VALUES // values.size)
    means = []
    for first in range(0, resamples, per_block):
        drawn = rng.integers(repeats, size=(min(per_block, resamples - first), mazes, repeats))
        taken = values[np.arange(mazes)[:, None], drawn]  # (B, M, n)
        means.append(_trimmed_means(taken.reshape(len(taken), -1)))
    in_order = np.sort(np.concatenate(means))
    # The nearest ranks, not interpolated ones: between a number and infinity there is nothing.
    low, high = (round(share * (resamples - 1)) for share in (0.025, 0.975))
    return float(in_order[low]), float(in_order[high])


def _trimmed_means(rows: FloatArray) -> FloatArray:
    """Return the interquartile mean of every row [B]."""
    size = rows.shape[1]
    cut = size // 4
    return np.asarray(np.sort(rows, axis=1)[:, cut : size - cut].mean(axis=1), dtype=np.float64)


def summary_of(values: ArrayLike, seed: int) -> Summary:
    """Return the figures of a group of runs.

    Args:
        values: [M, n] one figure per run, or [n] for one maze; infinite where a run gave up.
        seed: Of the resampling.
    """
    table = np.atleast_2d(np.asarray(values, dtype=np.float64))
    complete = bool(np.isfinite(table).all())
    low, high = bootstrap_interval(table, stream(seed, "bootstrap"))
    return Summary(
        mean=rounded(table.mean()) if complete else None,
        std=rounded(table.std(ddof=1)) if complete and table.size > 1 else None,
        iqm=rounded(interquartile_mean(table)),
        ci95=(rounded(low), rounded(high)),
        runs=table.size,
        gave_up=int((~np.isfinite(table)).sum()),
    )


def rounded(value: float | np.floating[Any]) -> float | None:
    """Return a figure as it goes into JSON: None when it is not finite."""
    return round(float(value), DIGITS) if np.isfinite(value) else None


def means_of(table: Sequence[Sequence[float]] | FloatArray) -> list[float | None]:
    """Return the mean of every row [M]; None for a maze in which a run gave up."""
    return [rounded(row.mean()) for row in np.asarray(table, dtype=np.float64)]
