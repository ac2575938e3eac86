"""Watching an agent learn, as a state machine: events go in, a new state comes out; nothing here knows a terminal.

G goals, n trials.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import LearningConfig
from twonav_cli.events import Clock, Event, GoalChosen, GoalLearned, RunEnded, RunStarted
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.goals import GOAL_SELECTIONS, NO_GOAL
from twonav_cli.maze import Maze

FloatArray = NDArray[np.float64]

TRAIL_CELLS = 60
RECENT_TRIALS = 100
CURVE_TRIALS = 2000


@dataclass(frozen=True)
class Trial:
    """How a trial ended."""

    start: str
    steps: int
    shortest: int
    reached: bool


@dataclass(frozen=True)
class Walked(Event):
    """The agent has gone on by some actions: perhaps none, perhaps many trials."""

    cell: Cell
    """Where it is: between two trials, where the next one begins."""
    start: Cell
    """Where the trial began that is under way, or the next one will."""
    steps_in_trial: int
    trials: tuple[Trial, ...]
    """Those that ended meanwhile."""
    temperature: float
    td_errors: FloatArray | None = None
    """[G] mean squared TD error of every goal over the free entries, where somebody looked."""


@dataclass(frozen=True, eq=False)
class WatchState:
    """Everything the watching screen shows, after some events.

    Attributes:
        run: What stays the same.
        config: How the agent learns.
        floor_steps: Actions that the criterion costs by itself: every trial it asks for, by a shortest way (ours).
        clock: Trials and actions of the run.
        goal: The current goal, empty before the first and after the last.
        why: Why it was chosen, with the numbers that decided.
        learned: Goals that met the criterion, in order.
        td_errors: [G] now.
        cell: Where the agent is.
        start: Where its trial began.
        steps_in_trial: Actions of the trial under way.
        trail: The latest cells of the trial under way, or of the last one when none is.
        last_trial: The one that ended last, None before.
        between: Whether no trial is under way.
        recent: Successes of the latest trials.
        curve: Actions of the trials of the current goal, from the first of a round (one from every start) on.
        temperature: Of Eq. 6, now.
        ended: How the run ended, empty while it goes on.
    """

    run: RunStarted
    config: LearningConfig
    floor_steps: int
    clock: Clock = field(default_factory=Clock)
    goal: str = ""
    why: str = ""
    learned: tuple[str, ...] = ()
    td_errors: FloatArray | None = None
    cell: Cell | None = None
    start: Cell | None = None
    steps_in_trial: int = 0
    trail: tuple[Cell, ...] = ()
    last_trial: Trial | None = None
    between: bool = True
    recent: tuple[bool, ...] = ()
    curve: tuple[int, ...] = ()
    temperature: float = 0.0
    ended: str = ""

    @property
    def maze(self) -> Maze:
        """The maze of the run."""
        assert self.run.maze is not None, "a run in a maze has one"
        return self.run.maze

    @property
    def goal_names(self) -> list[str]:
        """Names of the goals in table order."""
        return self.maze.goal_names

    @property
    def start_name(self) -> str:
        """Name of the start of the trial under way."""
        return next((name for name, cell in self.maze.starts.items() if cell == self.start), "")


def first_state(run: RunStarted, agent: Agent) -> WatchState:
    """Return the state before anything happened, of a run that begins or goes on."""
    assert run.maze is not None, "a run in a maze has one"
    progress, names = agent.progress, agent.goal_names
    ways = [int(run.maze.distances_to(goal)[s]) for goal in run.maze.goals.values() for s in run.maze.starts.values()]
    return WatchState(
        run=run,
        config=agent.config,
        floor_steps=agent.config.consecutive_successes * sum(ways),
        clock=run.clock,
        goal=names[progress.goal] if progress.goal != NO_GOAL else "",
        why="taken up again where the run was stopped" if progress.goal != NO_GOAL else "",
        learned=tuple(name for name, done in zip(names, progress.learned, strict=True) if done),
        td_errors=agent.td_error_of_goals(),
        temperature=agent.temperature,
        ended="learned" if progress.learned.all() else "",
    )


def advance(state: WatchState, event: Event) -> WatchState:
    """Return the state after one event; what the screen does not show changes only the clock."""
    rule = RULES.get(type(event))
    state = replace(state, clock=event.clock)
    return rule(state, event) if rule is not None else state


def why_chosen(event: GoalChosen, names: list[str], learned: tuple[str, ...]) -> str:
    """Return the reason of a choice with the numbers that decided (§3.1.2)."""
    left = [name for name in names if name not in learned]
    if len(left) == 1:
        return "it is the last one left"
    if event.td_errors is None or event.reason != GOAL_SELECTIONS["td-error"]:
        return event.reason
    errors = dict(zip(names, event.td_errors.tolist(), strict=True))
    own, second = errors[event.goal], max((n for n in left if n != event.goal), key=lambda name: errors[name])
    if errors[second] == own:
        return f"{event.reason} ({number(own)}), first of equals"
    digits = next((d for d in range(3, 9) if number(own, d) != number(errors[second], d)), 9)
    return f"{event.reason} ({number(own, digits)}; next {called(second)}, {number(errors[second], digits)})"


def called(name: str, kind: str = "goal") -> str:
    """Return how a goal or a start is spoken of: those of random mazes are numbers."""
    return f"{kind} {name}" if name.isdigit() else name


def number(value: float, digits: int = 3) -> str:
    """Return a number with at least so many digits that count."""
    decimals = max(digits - len(str(int(abs(value)))), 0)
    return f"{value:,.{decimals}f}" if abs(value) >= 100 else f"{value:.{digits}g}"


def _goal_chosen(state: WatchState, event: GoalChosen) -> WatchState:
    why = why_chosen(event, state.goal_names, state.learned)
    td = event.td_errors if event.td_errors is not None else state.td_errors
    return replace(state, goal=event.goal, why=why, td_errors=td, curve=(), last_trial=None, trail=(), between=True)


def _walked(state: WatchState, event: Walked) -> WatchState:
    td = event.td_errors if event.td_errors is not None else state.td_errors
    state = replace(state, temperature=event.temperature, td_errors=td)
    if event.trials:
        state = _with_trials(state, event.trials)
    if event.steps_in_trial == 0:
        # The agent is shown where its last trial ended until the next one begins.
        return state if state.last_trial else replace(state, cell=event.cell, start=event.start)
    return replace(
        state,
        cell=event.cell,
        start=event.start,
        steps_in_trial=event.steps_in_trial,
        trail=(*_known_trail(state, event.start, event.steps_in_trial), event.cell)[-TRAIL_CELLS:],
        between=False,
    )


def _with_trials(state: WatchState, trials: tuple[Trial, ...]) -> WatchState:
    """Count trials that ended; the agent of one that reached its goal stands there."""
    last, start = trials[-1], state.maze.starts[trials[-1].start]
    cell = state.maze.goals[state.goal] if last.reached else state.cell
    trail = _known_trail(state, start, last.steps) if len(trials) == 1 else ()
    return replace(
        state,
        recent=(*state.recent, *(trial.reached for trial in trials))[-RECENT_TRIALS:],
        curve=_with_curve(state, tuple(trial.steps for trial in trials)),
        last_trial=last,
        between=True,
        steps_in_trial=0,
        cell=cell,
        start=start,
        trail=(*trail, cell)[-TRAIL_CELLS:] if last.reached and cell is not None else trail,
    )


def _with_curve(state: WatchState, steps: tuple[int, ...]) -> tuple[int, ...]:
    """Return the curve with further trials; when it grows too long, whole rounds are forgotten from its beginning."""
    curve, size = (*state.curve, *steps), len(state.maze.starts)
    over = max(len(curve) - CURVE_TRIALS, 0)
    return curve[-(-over // size) * size :]


def _known_trail(state: WatchState, start: Cell, steps: int) -> tuple[Cell, ...]:
    """Return the cells before the last of so many actions from a start, as far as they were seen one by one."""
    if steps == 1:
        return (start,)
    return state.trail if not state.between and steps == state.steps_in_trial + 1 else ()


def _goal_learned(state: WatchState, event: GoalLearned) -> WatchState:
    return replace(state, learned=(*state.learned, event.goal))


def _run_ended(state: WatchState, event: RunEnded) -> WatchState:
    return replace(state, ended=event.outcome)


RULES: dict[type[Event], Callable[[WatchState, Any], WatchState]] = {
    GoalChosen: _goal_chosen,
    Walked: _walked,
    GoalLearned: _goal_learned,
    RunEnded: _run_ended,
}
