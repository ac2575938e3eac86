"""Rounds of compiled trials: one trial from each start, whose means can be compared from round to round.

S starts, n trials, k rounds.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.events import TrialBatch

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


class Rounds:
    """Gathers trials into rounds; a goal that is turned to begins a new one."""

    def __init__(self, starts: int) -> None:
        self._starts = starts
        self._goal = -1
        self._rest: IntArray = np.zeros((0, 4), dtype=np.int64)

    def add(self, batch: TrialBatch) -> tuple[IntArray, FloatArray]:
        """Return the rounds that a batch of trials completes.

        Returns:
            Number and last action of each round's last trial [k, 2], mean (taken, shortest) actions [k, 2].
        """
        if len(batch.goal) == 0:
            return np.zeros((0, 2), dtype=np.int64), np.zeros((0, 2))
        if batch.goal[0] != self._goal:
            self._rest = self._rest[:0]
        self._goal = int(batch.goal[-1])
        numbers = batch.clock.trial - len(batch.steps) + 1 + np.arange(len(batch.steps))
        rows = np.stack([numbers, batch.last_step, batch.steps, batch.shortest], axis=1)  # (n, 4)
        rows = np.concatenate([self._rest, rows])
        whole = len(rows) // self._starts * self._starts
        self._rest = rows[whole:]
        rounds = rows[:whole].reshape(-1, self._starts, 4)
        return rounds[:, -1, :2], rounds[:, :, 2:].mean(axis=1)
