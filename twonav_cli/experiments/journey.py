"""A journey: the goals a person asks for, one after another, driven by the agent, with a hand on the wheel.

The loop runs in any thread. What the person wants arrives through `wishes` between two actions (or control periods);
everything that happens leaves as events.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.events import (
    Clock,
    Event,
    GoalAdded,
    GoalChosen,
    Kidnapped,
    Note,
    QSnapshot,
    Sink,
    StepTaken,
    TrialEnded,
    TrialStarted,
)
from twonav_cli.experiments.failure_causes import Passed, failure_of
from twonav_cli.experiments.new_goal import GoalWish, add_goal
from twonav_cli.experiments.trials import tell_look
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import UNREACHABLE, Maze
from twonav_cli.navigation.outcomes import REACHED
from twonav_cli.stages.stage import Observation, Stage


class JourneyLeftError(Exception):
    """The person left."""


class Wishes(Protocol):
    """What a person may want during a journey; the play screen implements it with a queue."""

    def next_goal(self, wait: bool) -> str | None:
        """Return a newly asked-for goal, if any; with `wait`, block until the person wants anything or leaves."""

    def take_new_goal(self) -> GoalWish | None:
        """Return a goal that is to be added, once; no goal that is asked for after it comes before it."""

    def take_kidnap(self) -> bool:
        """Whether the robot is to be carried elsewhere, once."""

    def take_move(self) -> int | None:
        """Return an action that the person takes for the agent, once."""

    def wait_for_permission(self) -> None:
        """Block while paused."""

    def pace(self) -> float:
        """Return simulated seconds per second of watching; 0 for as fast as it goes."""

    def left(self) -> bool:
        """Whether the person has left."""


class NoWishes:
    """Nobody is watching: every goal in turn, as fast as it goes."""

    def __init__(self, stop: threading.Event | None = None) -> None:
        self._stop = stop or threading.Event()

    def next_goal(self, wait: bool) -> str | None:
        """Never a further goal."""
        return None

    def take_new_goal(self) -> GoalWish | None:
        """Never."""
        return None

    def take_kidnap(self) -> bool:
        """Never."""
        return False

    def take_move(self) -> int | None:
        """Never."""
        return None

    def wait_for_permission(self) -> None:
        """Go on at once."""

    def pace(self) -> float:
        """As fast as it goes."""
        return 0.0

    def left(self) -> bool:
        """Whether the run is to be broken off."""
        return self._stop.is_set()


@dataclass(frozen=True)
class Visit:
    """How the drive to one goal ended."""

    goal: str
    outcome: str
    steps: int
    shortest: int


class Journey:
    """Drives to goals in a stage, greedily, and keeps learning on the way (alpha 0.8 in 3D, §4.3)."""

    def __init__(
        self, stage: Stage, frame: GridFrame, agent: Agent, rng: np.random.Generator, sink: Sink, wishes: Wishes
    ) -> None:
        self.stage = stage
        self.frame = frame
        self.agent = agent
        self.maze: Maze = stage.maze
        self.visits: list[Visit] = []
        self._rng = rng
        self._sink = sink
        self._wishes = wishes
        self._trial = 0
        self._step = 0
        self._shown_until_s = 0.0
        self._seen: Observation

    def run(self, goals: Iterable[str], start: Cell, stay: bool) -> list[Visit]:
        """Visit goals in order, then (with `stay`) every goal the person asks for.

        Args:
            goals: Names of goals.
            start: Where the robot is put down.
            stay: Wait for further goals after the last one.

        Raises:
            TwonavError: A goal is unknown.
            JourneyLeftError: Never; leaving ends the run early and the visits so far are returned.
        """
        waiting = deque(goals)
        for name in waiting:
            if name not in self.agent.goal_names:
                raise unknown_name("goal", name, self.agent.goal_names)
        self._seen = self.stage.place(start)
        tell_look(self._seen, self._clock(), self._sink)
        self._sink(QSnapshot(self._clock(), self.agent.table(), self.agent.td_table()))
        try:
            while True:
                goal = waiting.popleft() if waiting else self._asked_for(wait=stay)
                if goal is not None:
                    self._visit(goal, waiting)
                elif not (stay and self._done_while_idle()):
                    return self.visits
        except JourneyLeftError:
            return self.visits

    def _visit(self, goal: str, waiting: deque[str]) -> None:
        index = self.agent.goal_names.index(goal)
        start, begun, shortest = self._seen.cell, self._step, self._shortest_to(goal)
        self._sink(GoalChosen(self._clock(), goal, "asked for", self.agent.td_error_of_goals()))
        self._sink(QSnapshot(self._clock(), self.agent.table(), self.agent.td_table()))
        self._sink(TrialStarted(self._clock(), goal, start, self._seen.pose_true))
        passed: list[Passed] = []
        outcome = "time-out"
        while True:
            asked = self._between_actions()
            if asked is not None and asked != goal:
                waiting.appendleft(asked)
            if self._seen.cell == self.maze.goals[goal]:
                outcome = REACHED if self._seen.true_cell == self.maze.goals[goal] else "false-arrival"
                break
            if asked is not None and asked != goal:
                outcome = "given-up"
                break
            if self._step - begun >= self.agent.config.trial_limit_steps:
                break
            passed.append(self._take_step(goal, index))
        self._end_trial(goal, start, outcome, self._step - begun, shortest, passed)

    def _take_step(self, goal: str, index: int) -> Passed:
        before = self._seen
        by_hand = self._wishes.take_move()
        action, greedy = self.agent.choose(before.cell, index, self._rng, explore=False)
        action = action if by_hand is None else by_hand
        values = self.agent.values(before.cell, index).copy()
        self._step += 1  # the ticks of an action carry its number, as in `run_trial`
        result = self.stage.act(action, self._clock(), self._paced)
        self._seen = result.observation
        blocked = result.outcome != REACHED or self._seen.cell == before.cell
        learning = self.agent.observe if result.plausible else self.agent.td_errors
        td_errors = learning(before.cell, action, self._seen.cell, blocked)
        step = StepTaken(
            self._clock(), goal, before.cell, action, self._seen.cell, result.outcome, values, td_errors, greedy,
            self._seen.true_cell, self._seen.pose_true, self._seen.pose_estimate, self._seen.image,
            self._seen.belief, self._seen.filtered,
        )  # fmt: skip
        self._paced(step)
        return Passed(self._seen.cell, blocked, self._seen.pose_true)

    def _end_trial(self, goal: str, start: Cell, outcome: str, steps: int, shortest: int, passed: list[Passed]) -> None:
        explained = "reached" if outcome == "given-up" else outcome
        cause, evidence = failure_of(explained, self._seen, self.maze.goals[goal], passed)
        self.visits.append(Visit(goal, outcome, steps, shortest))
        self._sink(
            TrialEnded(
                self._clock(), goal, start, outcome, steps, shortest, cause, evidence,
                self._seen.pose_true, self._seen.pose_estimate,
            )
        )  # fmt: skip
        self._trial += 1

    def _between_actions(self) -> str | None:
        """Do what the person wants done now; return the goal that was asked for, if any."""
        self._wishes.wait_for_permission()
        while self._new_goal_added():
            self._wishes.wait_for_permission()  # who is paused stays so
        if self._wishes.left():
            raise JourneyLeftError
        if self._wishes.take_kidnap():
            self._kidnap()
        return self._asked_for(wait=False)

    def _done_while_idle(self) -> bool:
        """Do what the person wants while the robot has no goal; return whether there was anything."""
        if self._wishes.left():
            return False
        if self._new_goal_added():
            return True
        if self._wishes.take_kidnap():
            self._kidnap()
            return True
        if self._wishes.take_move() is not None:
            self._sink(Note(self._clock(), "INFO", "name a goal first, then take the wheel"))
            return True
        return False

    def _new_goal_added(self) -> bool:
        """Add the goal that the person wants added, if any, or note why it cannot be; return whether there was one."""
        wish = self._wishes.take_new_goal()
        if wish is None:
            return False
        try:
            self.maze, sentence = add_goal(self.agent, self.maze, self.frame, wish, self._seen.cell)
        except TwonavError as error:
            self._sink(Note(self._clock(), "WARN", str(error)))
            return True
        self.stage.maze = self.maze
        self._sink(GoalAdded(self._clock(), wish.name, self.maze.goals[wish.name]))
        self._sink(QSnapshot(self._clock(), self.agent.table(), self.agent.td_table()))
        self._sink(Note(self._clock(), "INFO", sentence))
        return True

    def _asked_for(self, wait: bool) -> str | None:
        """Return the next goal that the person asks for; an unknown one is only noted."""
        while (name := self._wishes.next_goal(wait)) is not None:
            if name in self.agent.goal_names:
                return name
            self._sink(Note(self._clock(), "WARN", str(unknown_name("goal", name, self.agent.goal_names))))
        return None

    def _shortest_to(self, goal: str) -> int:
        """Return the length of the shortest way from where the robot is, or, in no free cell, believes to be."""
        distances = self.maze.distances_to(self.maze.goals[goal])
        true = int(distances[self._seen.true_cell])
        return int(distances[self._seen.cell]) if true == UNREACHABLE else true

    def _kidnap(self) -> None:
        """Carry the robot to another free cell at random, without telling it."""
        before = self._seen.pose_true or Pose(*self.frame.centre_of(self._seen.true_cell), 0.0)
        self._seen = self._carried_away()
        after = self._seen.pose_true or Pose(*self.frame.centre_of(self._seen.true_cell), 0.0)
        self._sink(Kidnapped(self._clock(), before, after))
        tell_look(self._seen, self._clock(), self._sink)
        self._sink(Note(self._clock(), "WARN", f"kidnapped: carried to ({after.x_m:.1f}, {after.y_m:.1f}) m"))

    def _carried_away(self) -> Observation:
        """Carry the robot to another free cell in which it fits, and return what it sees there."""
        free = [cell for cell in self.maze.free_cells if cell != self._seen.true_cell] or self.maze.free_cells
        while True:
            cell = free.pop(int(self._rng.integers(len(free))))
            try:
                return self.stage.carry(cell)
            except TwonavError:
                if not free:
                    raise

    def _paced(self, event: Event) -> None:
        """Hand an event on and let simulated time pass as fast as the person wants."""
        self._sink(event)
        if self._wishes.left():
            raise JourneyLeftError
        pace = self._wishes.pace()
        simulated_s = max(event.clock.time_s - self._shown_until_s, 0.0)
        self._shown_until_s = max(event.clock.time_s, self._shown_until_s)
        if pace > 0 and simulated_s > 0:
            time.sleep(min(simulated_s / pace, 1.0))

    def _clock(self) -> Clock:
        return Clock(self._trial, self._step, self.stage.time_s)
