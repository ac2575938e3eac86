"""What the goals ask for: their rewards, when one counts as learned, and which comes next.

G goals, S starts, W trials of the confirmation window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import Rewards
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

GOAL_SELECTIONS = {
    "td-error": "its TD error is the largest",
    "random": "drawn at random",
    "sequential": "next in order",
}
"""Rule of goal selection (§3.1.2) to the reason it gives."""

NO_GOAL = -1


def goals_at(cell: Cell, goal_cells: Sequence[Cell]) -> BoolArray:
    """Return for every goal [G] whether it lies in `cell`."""
    return np.array([cell == goal for goal in goal_cells], dtype=np.bool_)


def rewards_of_goals(
    rewards: Rewards, cell: Cell, next_cell: Cell, blocked: bool, goal_cells: Sequence[Cell]
) -> FloatArray:
    """Return what one action earns toward every goal [G] (§4.3).

    Entering a goal's cell earns the goal's reward even when the stage calls the action blocked; staying in it does not.
    """
    earned = np.full(len(goal_cells), rewards.blocked if blocked else rewards.step)
    if next_cell != cell:
        earned[goals_at(next_cell, goal_cells)] = rewards.goal
    return earned


@compiled
def record_trial(consecutive: IntArray, window: IntArray, start: int, steps: int, reached: bool) -> None:
    """Note how a trial from a start ended; a failure starts that start's count again.

    Args:
        consecutive: [S] successes in a row from each start, changed in place.
        window: [S, W] actions of the latest successes, a ring per start, changed in place.
        start: Index of the start.
        steps: Actions taken.
        reached: Whether the goal was reached.
    """
    if reached:
        window[start, consecutive[start] % window.shape[1]] = steps
        consecutive[start] += 1
    else:
        consecutive[start] = 0


@compiled
def is_learned(consecutive: IntArray, window: IntArray, max_step_difference: float) -> bool:
    """Return whether a goal counts as learned (§4.3).

    Our reading: the last W trials from each of the S starts all succeeded, and the number of actions differs between
    one trial and the next from the same start by less than `max_step_difference`, in the mean of the absolute
    differences over those trials and over all starts.
    """
    starts, length = window.shape
    for start in range(starts):
        if consecutive[start] < length:
            return False
    total = 0
    for start in range(starts):
        oldest = consecutive[start] % length
        for i in range(length - 1):
            total += abs(window[start, (oldest + i + 1) % length] - window[start, (oldest + i) % length])
    differences = starts * (length - 1)
    return bool(differences == 0 or total / differences < max_step_difference)


@dataclass
class Progress:
    """Where a learning run stands: everything besides the tables that it needs to go on as if unbroken."""

    learned: BoolArray
    """[G] goals that met the criterion."""
    consecutive: IntArray
    """[S] successes in a row from each start, for the current goal."""
    window: IntArray
    """[S, W] actions of the latest successes."""
    goal: int = NO_GOAL
    trial: int = 0
    step: int = 0
    next_start: int = 0
    explore_state: int = 0
    """State of the compiled loop's random numbers; 0 before the first trial."""
    optimal_at: int = -1
    """Actions of the run after which the greedy way from every start to every goal was first a shortest one; -1 before
    that. Only the compiled loop of the maze looks for it."""
    trials_of_goal: list[int] = field(default_factory=list)
    """[G] trials spent on each goal."""
    steps_of_goal: list[int] = field(default_factory=list)
    """[G] actions spent on each goal."""

    @classmethod
    def fresh(cls, goals: int, starts: int, window: int) -> Progress:
        """Return the progress of a run that has not begun."""
        return cls(
            learned=np.zeros(goals, dtype=np.bool_),
            consecutive=np.zeros(starts, dtype=np.int64),
            window=np.zeros((starts, window), dtype=np.int64),
            trials_of_goal=[0] * goals,
            steps_of_goal=[0] * goals,
        )

    def begin_goal(self, goal: int) -> None:
        """Make a goal the current one: its confirmation starts at zero, from the first start."""
        self.goal, self.next_start = goal, 0
        self.consecutive[:] = 0
        self.window[:] = 0

    def finish_goal(self) -> None:
        """Mark the current goal as learned."""
        self.learned[self.goal] = True
        self.goal = NO_GOAL


def next_goal(rule: str, td_errors: FloatArray, learned: BoolArray, rng: np.random.Generator) -> int:
    """Return the goal to train on next, among those not learned (§3.1.2).

    Args:
        rule: A key of `GOAL_SELECTIONS`.
        td_errors: [G] TD error of every goal; the first of equals is taken.
        learned: [G] goals that are done.
        rng: Drawn from only by "random".

    Raises:
        TwonavError: No such rule, or every goal is learned.
    """
    if rule not in GOAL_SELECTIONS:
        raise unknown_name("goal selection", rule, GOAL_SELECTIONS)
    left = np.flatnonzero(~learned)
    if len(left) == 0:
        raise TwonavError("every goal is learned: add a goal or start a new agent")
    if rule == "td-error":
        return int(left[np.argmax(td_errors[left])])
    return int(rng.choice(left) if rule == "random" else left[0])
