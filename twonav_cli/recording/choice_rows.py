"""Rows about the choice of goals: which one, why, what it was preferred to, and when it was learned. G goals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.events import Clock, GoalAdded, GoalChosen, GoalLearned, TrialBatch, TrialStarted
from twonav_cli.recording.columns import goal_errors, log10_error
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.palette import LEARNED_COLOUR, WAITING_COLOUR, goal_colours, packed
from twonav_cli.recording.rrd_file import RrdFile
from twonav_cli.recording.trained_goals import plain, why_chosen

WAITING, CURRENT, LEARNED = "waiting", "current", "learned"
"""States of a goal: a lane each in the viewer."""

GOES_ON = "the run goes on with it"
"""Reason of a goal that was chosen before this recording began."""


def rival_of(event: GoalChosen, goals: GoalList) -> int | None:
    """Return the index of the goal with the largest TD error among the others that could have been chosen."""
    if event.learned is None or event.td_errors is None or event.goal not in goals:
        return None
    errors = np.where(event.learned, -np.inf, event.td_errors)
    errors[goals.names.index(event.goal)] = -np.inf
    rival = int(errors.argmax())
    return rival if np.isfinite(errors[rival]) else None


def choice_sentence(event: GoalChosen, goals: GoalList) -> str:
    """Return which goal was chosen, by which rule, and the numbers behind it."""
    if event.learned is None or event.td_errors is None or event.goal not in goals:
        return f"goal {event.goal}: {event.reason}"
    own, rival = float(event.td_errors[goals.names.index(event.goal)]), rival_of(event, goals)
    other = None if rival is None else (goals.name_of(rival), float(event.td_errors[rival]))
    return f"after {event.clock.trial} trials, goal {event.goal}: {why_chosen(event.reason, own, other)}"


class ChoiceRows:
    """Turns choices of goals into a log, a lane per goal, a table of reasons, and rows for programs."""

    def __init__(self, file: RrdFile, goals: GoalList, begun: Clock) -> None:
        """Begin with every goal waiting.

        Args:
            file: Where to.
            goals: Grows when a goal is added.
            begun: When the recording begins.
        """
        self._file, self._goals = file, goals
        self._counts = dict.fromkeys(goals.names, 0)
        self._states: dict[str, str] = {}
        self._chosen_at = begun
        self.current = ""
        for index, name in enumerate(goals.names):
            self._add_lane(index, name, begun)

    def _add_lane(self, index: int, name: str, clock: Clock) -> None:
        colours = packed([WAITING_COLOUR, int(goal_colours(index + 1)[index]), LEARNED_COLOUR])
        self._file.always(_lane(index, name), rr.StateConfiguration(values=[WAITING, CURRENT, LEARNED], colors=colours))
        self._turn(name, WAITING, clock)

    def _turn(self, name: str, state: str, clock: Clock) -> None:
        if name in self._goals and self._states.get(name) != state:
            self._states[name] = state
            lane = _lane(self._goals.names.index(name), name)
            self._file.send(lane, [clock], rr.StateChange.columns(state=[state]))

    def goal_chosen(self, event: GoalChosen) -> None:
        """Write the choice, its reason, and the TD errors behind it."""
        put, clock, known = self._file.put, event.clock, event.goal in self._goals
        self._counts[event.goal] = self._counts.get(event.goal, 0) + 1
        self._pass_turn_to(event.goal, clock, event.learned)
        put("log", ("INFO", choice_sentence(event, self._goals)), clock, Detail.TRIAL)
        put("choices", self._row(event), clock, Detail.TRIAL)
        if event.td_errors is not None:
            put("learning/td_error", goal_errors(self._goals.at_start, event.td_errors), clock, Detail.TRIAL)
        if event.td_errors is not None and known:
            index = self._goals.names.index(event.goal)
            mark = (float(log10_error(event.td_errors[index])), int(goal_colours(index + 1)[index]))
            put("learning/chosen", mark, clock, Detail.TRIAL)
        document = rr.TextDocument(self._text(event), media_type="text/markdown")
        self._file.now("learning/choice", document, clock)

    def _pass_turn_to(self, goal: str, clock: Clock, learned: NDArray[np.bool_] | None) -> None:
        for index, done in enumerate(learned if learned is not None else ()):
            if done:
                self._turn(self._goals.name_of(index), LEARNED, clock)
        if self._states.get(self.current) == CURRENT and self.current != goal:
            self._turn(self.current, WAITING, clock)
        self.current, self._chosen_at = goal, clock
        self._turn(goal, CURRENT, clock)

    def trial_started(self, event: TrialStarted) -> None:
        """Look whether the trial's goal was chosen."""
        self._go_on(event.goal, event.clock)

    def batch(self, event: TrialBatch) -> None:
        """Look whether the goal of compiled trials was chosen."""
        if len(event.goal):
            begun = Clock(event.clock.trial - len(event.steps), int(event.last_step[0] - event.steps[0]))
            self._go_on(self._goals.name_of(int(event.goal[0])), begun)

    def _go_on(self, goal: str, clock: Clock) -> None:
        """Note a goal that was chosen before the recording began."""
        if goal != self.current:
            self._pass_turn_to(goal, clock, None)
            self._file.put("log", ("INFO", f"goal {goal}: {GOES_ON}"), clock, Detail.TRIAL)
            self._file.put("choices", self._row(GoalChosen(clock, goal, GOES_ON)), clock, Detail.TRIAL)

    def _row(self, event: GoalChosen) -> dict[str, Any]:
        rival, errors = rival_of(event, self._goals), event.td_errors
        own = float("nan")
        if errors is not None and event.goal in self._goals:
            own = float(errors[self._goals.names.index(event.goal)])
        return {
            "goal": event.goal,
            "reason": event.reason,
            "after_trials": event.clock.trial,
            "after_steps": event.clock.step,
            "td_error": own,
            "rival": "" if rival is None else self._goals.name_of(rival),
            "rival_td_error": math.nan if rival is None or errors is None else float(errors[rival]),
        }

    def _text(self, event: GoalChosen) -> str:
        rival, rows = rival_of(event, self._goals), []
        for index, name in enumerate(self._goals.names):
            errors = event.td_errors
            error = plain(float(errors[index])) if errors is not None and index < len(errors) else ""
            chosen, state = name == event.goal, self._states.get(name, "")
            state = "**chosen**" if chosen else "next largest" if index == rival else state
            rows.append(f"| {'**' + name + '**' if chosen else name} | {error} | {state} | {self._counts[name]} |")
        head = "| goal | TD error | | chosen |\n|---|---|---|---|\n"
        sentence = choice_sentence(event, self._goals).split(": ", 1)[-1]
        return f"**{event.goal}**: {sentence}\n\n{head}" + "\n".join(rows)

    def goal_learned(self, event: GoalLearned) -> None:
        """Write that a goal met the criterion, and what it took."""
        clock, begun = event.clock, self._chosen_at
        took = f"{clock.trial - begun.trial} trials and {clock.step - begun.step:,} actions of its own"
        said = f"after {clock.trial} trials, goal {event.goal} is learned: {took}"
        self._turn(event.goal, LEARNED, clock)
        self._file.put("log", ("INFO", said), clock, Detail.TRIAL)
        row = {"goal": event.goal, "after_trials": clock.trial, "after_steps": clock.step}
        self._file.put("learned", row, clock, Detail.TRIAL)

    def goal_added(self, event: GoalAdded) -> None:
        """Give a new goal its lane, its curve and its sentence; the list of goals has it already."""
        index = len(self._goals) - 1
        self._counts[event.name] = 0
        self._add_lane(index, event.name, event.clock)
        colour = goal_colours(index + 1)[index:]
        for entity in ("learning/td_error", "metrics/td_error"):
            line = rr.SeriesLines(names=event.name, colors=colour, widths=1.6)
            self._file.always(f"{entity}/goal_{index:02d}", line)
        said = f"goal {event.name} was added in cell {tuple(event.cell)}"
        self._file.put("log", ("INFO", said), event.clock, Detail.TRIAL)
        row = {"goal": event.name, "row": event.cell.row, "col": event.cell.col, "at_trial": event.clock.trial}
        self._file.put("added", row, event.clock, Detail.TRIAL)


def _lane(index: int, name: str) -> str:
    """Return the entity of a goal's lane; lanes are sorted by their entities."""
    return "goals" + str(rr.new_entity_path([f"{index + 1:02d}", name]))
