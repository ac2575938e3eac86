"""Moves a learning run on for a screen: so many actions, or for so long; what happened comes back as events."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import replace

from twonav_cli.events import Event, GoalChosen, GoalLearned, RunEnded, Sink, to_all
from twonav_cli.experiments.learning_progress import LearningOutcome, clock_of
from twonav_cli.experiments.maze_learning import TRIALS_PER_BATCH, MazeLearning
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.maze_kernel import Columns
from twonav_cli.maze import Maze
from twonav_cli.terminal.screen.watch_keys import END, GOAL, TRIAL
from twonav_cli.terminal.screen.watch_state import TRAIL_CELLS, Trial, Walked

PIECE_ACTIONS = 2_000
"""Actions between two looks at the clock: a fraction of a frame, whichever the learner."""


class Walk:
    """A learning run that goes on as it is asked to.

    The last actions of a call are taken one at a time, so that the cells that they lead through are known.
    """

    def __init__(
        self,
        agent: Agent,
        maze: Maze,
        seed: int,
        sink: Sink,
        save_due: Callable[[], bool] = lambda: False,
        save: Callable[[], None] = lambda: None,
    ) -> None:
        """Begin a run, or go on with one; nothing happens yet.

        Args:
            agent: Learns.
            maze: The agent's.
            seed: Of a run that begins.
            sink: Gets what it would get without a screen.
            save_due: Asked often.
            save: Writes the agent; called when it is due, at the end of a trial, and when the run is over.

        Raises:
            TwonavError: The agent does not fit the maze, or a goal cannot be reached.
        """
        self.agent, self.maze = agent, maze
        self.learning = MazeLearning(agent, maze, seed, to_all(sink, self._note))
        self._save_due, self._save = save_due, save
        self._start_names = list(maze.starts)
        self._happened: list[Event] = []

    @property
    def over(self) -> bool:
        """Whether there is nothing left to do."""
        return bool(self.learning.outcome)

    def take(self, actions: int) -> list[Event]:
        """Take so many actions, fewer when the run is over before; 0 chooses the first goal and compiles the loop."""
        left = actions
        while left > TRAIL_CELLS and not self.over:
            left -= self._go(left - TRAIL_CELLS)
        self._go_slowly(left)
        if actions == 0 and not self.over:
            self._go(0)
        return self._taken()

    def run(self, until: str, budget_s: float) -> list[Event]:
        """Run as fast as it goes, until a TRIAL or a GOAL has ended, the run is over (END), or the time is used up."""
        deadline = time.monotonic() + budget_s
        while not self.over and not self.has_ended(until, self._happened) and time.monotonic() < deadline:
            self._go(1 if until == TRIAL else PIECE_ACTIONS)
        if not self.has_ended(until, self._happened):
            self._go_slowly(TRAIL_CELLS if until != TRIAL else 0)
        return self._taken()

    def has_ended(self, until: str, events: list[Event]) -> bool:
        """Return whether what was skipped to is among the events, or the run is over."""
        if until == TRIAL and any(isinstance(event, Walked) and event.trials for event in events):
            return True
        if until == GOAL and any(isinstance(event, GoalLearned) for event in events):
            return True
        return until in (TRIAL, GOAL, END) and self.over

    def close(self) -> LearningOutcome:
        """End the run where it stands, at the end of the trial under way, so that it can be saved and go on."""
        self.learning.finish_trial()
        return self.learning.close()

    def _go_slowly(self, actions: int) -> None:
        for _ in range(actions):
            if not self.over:
                self._go(1)

    def _go(self, actions: int) -> int:
        """Take at most so many actions of one goal, choose the next when it is learned; return how many it were."""
        progress, before = self.agent.progress, self.agent.progress.step
        self.learning.choose_goal()
        place, goal = len(self._happened), progress.goal
        due = self._save_due()
        made = self.learning.advance(actions, 1 if due else TRIALS_PER_BATCH)
        trials = self._trials_of(made.rows, goal)
        walked = Walked(
            clock_of(self.agent), made.cell, made.start, made.steps_in_trial, trials, self.agent.temperature
        )
        self._happened.insert(place, walked)
        if (due or self.over) and not self.learning.loop.in_trial:
            self._save_agent()
        if self.over:
            self._happened.append(RunEnded(walked.clock, self.learning.outcome))
        elif made.learned:
            self._go(0)
        return progress.step - before

    def _save_agent(self) -> None:
        """Save the agent between two trials."""
        self.learning.loop.hand_over_replay()
        self._save()

    def _trials_of(self, rows: Columns, goal: int) -> tuple[Trial, ...]:
        shortest = self.learning.loop.ways.shortest
        return tuple(
            Trial(self._start_names[start], steps, int(shortest[start, goal]), reached)
            for start, steps, reached in zip(
                rows.start.tolist(), rows.steps.tolist(), rows.reached.tolist(), strict=True
            )
        )

    def _note(self, event: Event) -> None:
        if isinstance(event, GoalChosen | GoalLearned):
            self._happened.append(event)

    def _taken(self) -> list[Event]:
        """Return what happened since the last call; TD errors stand in its end only, for they cost many actions."""
        taken, self._happened = self._happened, []
        for place in range(len(taken) - 1, -1, -1):
            event = taken[place]
            if isinstance(event, Walked):
                taken[place] = replace(event, td_errors=self.agent.td_error_of_goals())
                break
        return taken
