"""The story of a learning run as its recording tells it: one entry per goal, in the order of training."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple

LARGEST = "its TD error is the largest"
"""Reason of the rule that takes the first of equals (§3.1.2); a recording sees no learner, so the words stand here."""

NOT_WRITTEN = "why it was chosen was not written"
"""Reason of a goal of which the recording has trials and no choice."""


class Walked(NamedTuple):
    """Where a recorded trial lies in the run."""

    goal: str
    trials: int
    """Trials of the run when it ended."""
    first_step: int
    last_step: int
    """Actions of the run when it began and when it ended."""


@dataclass(frozen=True)
class TrainedGoal:
    """A goal's turn."""

    goal: str
    first_trial: int
    last_trial: int
    """Number of the last trial; one less than the first when there was none."""
    trials: int
    actions: int
    reason: str
    """Why it was chosen."""
    td_error: float | None
    """Its TD error when it was chosen, where recorded."""
    rival: str
    """The goal with the next largest TD error of those not learned; empty for the last one."""
    rival_td_error: float | None
    learned_at_trial: int | None
    """Trials of the run when it met the criterion, None when it did not."""
    learned_at_step: int | None
    """Actions of the run at that moment."""


def plain(td_error: float, digits: int = 4) -> str:
    """Return a TD error as it is read: no powers of ten."""
    if td_error <= 0.0:
        return "0"
    text = f"{td_error:,.{max(digits - 1 - math.floor(math.log10(td_error)), 0)}f}"
    return text.rstrip("0").rstrip(".") if "." in text else text


def apart(own: float, other: float) -> tuple[str, str]:
    """Return two TD errors with as many digits as it takes to tell them apart."""
    digits = next((n for n in range(4, 16) if own == other or plain(own, n) != plain(other, n)), 16)
    return plain(own, digits), plain(other, digits)


def why_chosen(reason: str, own: float, rival: tuple[str, float] | None) -> str:
    """Return the rule's reason with the numbers behind it.

    Args:
        reason: The rule's.
        own: TD error of the chosen goal.
        rival: The goal with the next largest TD error of those that could have been chosen, and that error.
    """
    if rival is None:
        return f"{reason} ({plain(own)}, and no other goal is left)"
    name, other = rival
    if other == own:
        first = "; the first of equals" if reason == LARGEST else ""
        return f"{reason} ({plain(own)}, as that of {name}{first})"
    mine, next_largest = apart(own, other)
    return f"{reason} ({mine}; that of {name} is {next_largest})"


def trained_goals(
    choices: Iterable[dict[str, Any]],
    learned: Iterable[dict[str, Any]],
    trials: Iterable[Walked],
    end: tuple[int, int],
    first_number: int,
) -> tuple[TrainedGoal, ...]:
    """Return the turns of the goals.

    Args:
        choices: Rows of `/choices`.
        learned: Rows of `/learned`.
        trials: In their order; a turn has only those of its goal, whichever choices were lost.
        end: Trials and actions of the run when the recording ends.
        first_number: Number of a run's first trial: 1 where it was compiled, else 0.
    """
    turns = _with_lost_choices(sorted(choices, key=_moment), trials)
    ends = [*(_moment(row) for row in turns[1:]), end][: len(turns)]
    done = {row["goal"]: _moment(row) for row in learned}
    return tuple(
        _turn(row, ending, done.get(row["goal"], (None, None)), first_number)
        for row, ending in zip(turns, ends, strict=True)
    )


def _moment(row: dict[str, Any]) -> tuple[int, int]:
    return row["after_trials"], row["after_steps"]


def _with_lost_choices(choices: list[dict[str, Any]], trials: Iterable[Walked]) -> list[dict[str, Any]]:
    """Return the choices, sorted, with one more wherever the trials of a turn go over to another goal."""
    turns: list[dict[str, Any]] = []
    waiting = deque(choices)
    before: Walked | None = None
    for trial in trials:
        while waiting and waiting[0]["after_trials"] < trial.trials:
            turns.append(waiting.popleft())
            before = None
        if not turns or turns[-1]["goal"] != trial.goal:
            # Rows are thinned, but a goal's last trial has one: the turn begins where the row before it ends.
            begun = (before.trials, before.last_step) if before else (trial.trials - 1, trial.first_step)
            turns.append(_lost_choice(trial.goal, *begun))
        before = trial
    return [*turns, *waiting]


def _lost_choice(goal: str, trials: int, steps: int) -> dict[str, Any]:
    unknown = {"td_error": math.nan, "rival": "", "rival_td_error": math.nan}
    return {"goal": goal, "reason": NOT_WRITTEN, "after_trials": trials, "after_steps": steps, **unknown}


def _turn(
    row: dict[str, Any], end: tuple[int, int], learned: tuple[int | None, int | None], first_number: int
) -> TrainedGoal:
    trial, step = learned if learned[0] is not None and learned[0] <= end[0] else (None, None)
    return TrainedGoal(
        goal=row["goal"],
        first_trial=row["after_trials"] + first_number,
        last_trial=end[0] - 1 + first_number,
        trials=end[0] - row["after_trials"],
        actions=end[1] - row["after_steps"],
        reason=row["reason"],
        td_error=_number(row["td_error"]),
        rival=row["rival"],
        rival_td_error=_number(row["rival_td_error"]),
        learned_at_trial=trial,
        learned_at_step=step,
    )


def _number(value: float) -> float | None:
    return None if math.isnan(value) else value
