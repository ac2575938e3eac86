"""The flight recorder's rule: which trials are kept in full, and when the file is full.

A trial is buffered anyway, so the choice is made when its outcome is known.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

NOT_FAILED = ("reached", "given-up")
"""Outcomes that nobody has to explain: the goal was reached, or a person chose another one."""


class Detail(IntEnum):
    """How much of a trial a row belongs to; a trial is written up to one level."""

    TRIAL = 0
    """One row per trial: outcomes, causes, learning curves, the log."""
    POSES = 1
    """Where the robot was, once per action or so."""
    FULL = 2
    """Everything: camera, scans, candidates, cost maps, every tick."""


def has_failed(outcome: str) -> bool:
    """Return whether a trial with this outcome counts as failed."""
    return outcome not in NOT_FAILED


@dataclass(frozen=True)
class FlightRule:
    """What to keep.

    Attributes:
        every_trial: Keep every trial in full, as when a person plays.
        first: Trials at the start that are kept in full.
        every: After those, one trial in this many is kept in full; failed ones always are.
        budget_bytes: File size after which only rows of level TRIAL are written.
    """

    every_trial: bool = True
    first: int = 5
    every: int = 20
    budget_bytes: int = 200_000_000

    def level(self, trials_seen: int, failed: bool, file_bytes: int) -> Detail:
        """Return how much of a trial to write.

        Args:
            trials_seen: Trials before this one in this recording.
            failed: Whether it ended otherwise than at its goal.
            file_bytes: Size of the file so far.
        """
        if file_bytes >= self.budget_bytes:
            return Detail.TRIAL
        chosen = self.every_trial or failed or trials_seen < self.first or trials_seen % self.every == 0
        return Detail.FULL if chosen else Detail.POSES
