"""Learning in the maze with the compiled loop, driven from outside: whole batches of trials, or single actions.

G goals, n trials. Both ways send the same events and leave the same agent: a batch of trials is only sent once it is
whole, however small the pieces that it was made of.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from twonav_cli.events import QSnapshot, Sink, TrialBatch
from twonav_cli.experiments.learning_progress import (
    LearningOutcome,
    after_trials,
    check_learnable,
    choose_goal_if_none,
    clock_of,
    outcome_of,
)
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.maze_kernel import Columns
from twonav_cli.learner.maze_loop import NO_LIMIT, Advance, MazeLoop
from twonav_cli.maze import Maze

TRIALS_PER_BATCH = 500
"""Trials at one goal after which they are sent, and the limit of actions is looked at (ours)."""

SNAPSHOT_TRIALS = 5000
"""Trials between two snapshots of the table (ours); one more is taken when a goal is learned."""

EARLY_SNAPSHOTS = (1, 2, 3, 5, 8, 12, 20, 30, 50, 80, 120, 200, 300, 450)
"""Trials of a run after which one more is taken (ours): most of what the tables hold is learned in these."""

MAZE_STEPS_AT_MOST = 20_000_000
"""Actions after which learning gives up (ours): about a hundred times what the apartment takes."""


class MazeLearning:
    """A learning run in a maze that somebody else moves on.

    Attributes:
        agent: Changed in place; its progress says where the run stands.
        maze: The agent's.
        loop: The compiled loop.
    """

    def __init__(
        self,
        agent: Agent,
        maze: Maze,
        seed: int,
        sink: Sink,
        steps_at_most: int = MAZE_STEPS_AT_MOST,
        trials_per_batch: int = TRIALS_PER_BATCH,
    ) -> None:
        """Begin a run, or go on with the one that the agent's progress tells of.

        Args:
            agent: Learns.
            maze: The agent's.
            seed: Of a run that begins; one that goes on has its own.
            sink: Gets GoalChosen, TrialBatch, GoalLearned and QSnapshot.
            steps_at_most: Actions after which the run gives up, at the end of the batch then under way.
            trials_per_batch: Trials at one goal in a TrialBatch.

        Raises:
            TwonavError: The agent does not fit the maze, or a goal cannot be reached.
        """
        check_learnable(agent, maze)
        self.agent, self.maze = agent, maze
        self.loop = MazeLoop(agent, maze, seed, trials_per_batch)
        self._seed, self._sink = seed, sink
        self._steps_at_most, self._trials_per_batch = steps_at_most, trials_per_batch
        self._waiting: list[Columns] = []
        self._steps_in_trial = 0
        self._trials_before = agent.progress.trial
        self._steps_before = agent.progress.step
        if not self.outcome:
            sink(QSnapshot(clock_of(agent), agent.table(), agent.td_table()))

    @property
    def outcome(self) -> str:
        """How the run ended: "learned" or "gave-up" (the limit of actions), empty while something is left to do."""
        if self.agent.progress.learned.all():
            return "learned"
        between_batches = not self._waiting and not self._steps_in_trial
        return "gave-up" if between_batches and self.agent.progress.step >= self._steps_at_most else ""

    def choose_goal(self) -> None:
        """Choose the next goal, unless one is under way or the run is over."""
        if not self.outcome:
            choose_goal_if_none(self.agent, self._seed, self._sink)

    def advance(self, actions: int = NO_LIMIT, trials: int = TRIALS_PER_BATCH) -> Advance:
        """Take at most so many actions and end at most so many trials, of the current goal (§4.3).

        Args:
            actions: May end inside a trial, which the next call goes on with.
            trials: A batch that is full ends the call too.
        """
        self.choose_goal()
        room = self._trials_to_batch()
        made = self.loop.advance(actions, min(trials, room))
        self._steps_in_trial = made.steps_in_trial
        if len(made.rows.steps):
            self._waiting.append(made.rows)
        if made.learned or len(made.rows.steps) == room:
            self._send(made.learned)
        return made

    def finish_trial(self) -> None:
        """Bring the trial under way to its end and send what waits: here the run can be saved and go on later."""
        if self._steps_in_trial:
            self.advance(trials=1)
        if self._waiting:
            self._send(learned=False)

    def close(self) -> LearningOutcome:
        """Hand the experiences back to the agent, and return how the run went."""
        self.loop.close()
        return outcome_of(self.outcome or "stopped", self.agent)

    def _trials_to_batch(self) -> int:
        """Return the trials that are left until the batch is full, or cut short by an early snapshot."""
        trial = self.agent.progress.trial
        due = next((early for early in EARLY_SNAPSHOTS if early > trial), NO_LIMIT)
        return min(self._trials_per_batch - sum(len(rows.steps) for rows in self._waiting), due - trial)

    def _send(self, learned: bool) -> None:
        """Send the trials that wait, and what their end brings about."""
        rows = Columns(*(np.concatenate(column) for column in zip(*self._waiting, strict=True)))
        self._sink(_batch_of(rows, self.loop, self._steps_before))
        period = 1 if self.agent.progress.trial in EARLY_SNAPSHOTS else SNAPSHOT_TRIALS
        after_trials(self.agent, learned, self._trials_before, period, 0.0, self._sink)
        self._waiting.clear()
        self._trials_before, self._steps_before = self.agent.progress.trial, self.agent.progress.step


def _batch_of(rows: Columns, loop: MazeLoop, steps_before: int) -> TrialBatch:
    goal = loop.agent.progress.goal
    return TrialBatch(
        clock=clock_of(loop.agent),
        goal=np.full(len(rows.steps), goal, dtype=np.int64),
        start=rows.start,
        steps=rows.steps,
        reached=rows.reached,
        shortest=loop.ways.shortest[rows.start, goal],
        td_errors=rows.td_errors,
        last_step=steps_before + np.cumsum(rows.steps),
    )


def learn_maze(
    agent: Agent,
    maze: Maze,
    seed: int,
    sink: Sink,
    should_stop: Callable[[], bool],
    steps_at_most: int = MAZE_STEPS_AT_MOST,
) -> LearningOutcome:
    """Learn every goal of a maze (§4.3); a run that was stopped goes on where it was.

    Args:
        agent: Changed in place; its progress says where the run stands.
        maze: The agent's.
        seed: Of a run that begins; one that goes on has its own.
        sink: Gets GoalChosen, TrialBatch, GoalLearned and QSnapshot.
        should_stop: Asked every few hundred trials.
        steps_at_most: Actions after which the run gives up, at the end of the batch then under way.

    Raises:
        TwonavError: The agent does not fit the maze, or a goal cannot be reached.
    """
    learning = MazeLearning(agent, maze, seed, sink, steps_at_most)
    while not learning.outcome and not should_stop():
        learning.advance()
    return learning.close()
