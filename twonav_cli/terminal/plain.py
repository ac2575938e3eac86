"""The game without a terminal: one line per action, one per trial, and a summary."""

from __future__ import annotations

import math
from typing import TextIO

from twonav_cli.events import Event, Kidnapped, Note, RunEnded, RunStarted, StepTaken, TrialEnded, TrialStarted
from twonav_cli.grid import Cell
from twonav_cli.maze import Action
from twonav_cli.terminal.screen.game import GameState, advance, headline, pose_error, tally


class PlainPrinter:
    """A sink that prints to a stream; every line is written out at once, so that a pipe can be watched."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._state = GameState()
        self._actions = 0
        self._spl_sum = 0.0

    def __call__(self, event: Event) -> None:
        """Print what the event says, if it says anything to a reader."""
        self._state = advance(self._state, event)
        self._count(event)
        line = self._line(event)
        if line:
            self._stream.write(line + "\n")
            self._stream.flush()

    def _count(self, event: Event) -> None:
        """Keep what the summary needs; SPL = mean of S * shortest / max(taken, shortest) (Anderson et al. 2018)."""
        if isinstance(event, StepTaken):
            self._actions += 1
        elif isinstance(event, TrialEnded) and event.outcome == "reached":
            longer = max(event.steps, event.shortest)
            self._spl_sum += event.shortest / longer if longer else 1.0

    def _line(self, event: Event) -> str:
        match event:
            case RunStarted():
                return f"{event.command} {event.scene}, stage {event.stage}, seed {event.seed}"
            case TrialStarted():
                bound = f", shortest {self._state.shortest} actions" if self._state.shortest is not None else ""
                return f"trial {event.clock.trial}: to {event.goal} from {_cell(event.start)}{bound}"
            case StepTaken():
                return step_line(self._state, event)
            case TrialEnded() | Kidnapped():
                return f"trial {event.clock.trial}: {self._state.log[-1].text}"
            case Note():
                return f"{event.level.lower()}: {event.text}"
            case RunEnded():
                return self._summary(event)
        return ""

    def _summary(self, event: RunEnded) -> str:
        trials = sum(self._state.outcomes.values())
        spl = f", SPL {self._spl_sum / trials:.2f}" if trials else ""
        last = f"; last: {headline(self._state)}" if trials else ""
        return (
            f"summary: {event.outcome}; {tally(self._state)}{spl}; {self._actions} actions, "
            f"{event.clock.time_s:.1f} s simulated{last}"
        )


def step_line(state: GameState, event: StepTaken) -> str:
    """Return the line of one action, given the state after it."""
    error = pose_error(state)
    true = event.true_cell if event.true_cell is not None else event.next_cell
    parts = [
        f"  {event.clock.trial}.{state.trial_steps:<3d}",
        f"{_cell(event.cell)} {Action(event.action).name.lower():<5}{' ' if event.greedy else '*'}",
        f"{event.outcome:<9}",
        f"true {_cell(true)}",
    ]
    if error is not None and event.pose_estimate is not None:
        parts.append(f"error {error[0] * 100:5.1f} cm {math.degrees(error[1]):5.1f} deg")
    parts.append(f"Q {event.q_values[event.action]:7.2f}")
    if state.td_error is not None:
        parts.append(f"TD {state.td_error:9.3g}")
    return "  ".join(parts)


def _cell(cell: Cell) -> str:
    return f"({cell.row:2d},{cell.col:2d})"
