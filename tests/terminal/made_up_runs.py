"""Made-up learning runs with recognisable numbers: what the tests of tables, pictures and their printing use."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from twonav_cli.experiments.learning_run import LearningRun, shortest_ways
from twonav_cli.experiments.repeats import Item
from twonav_cli.maze import Maze


def made_up_run(item: Item, maze: Maze, rounds: int = 60, trial_steps: int = 30) -> LearningRun:
    """Return a run that trained the goals from the last to the first.

    Every goal got `rounds` trials from each start and one more for each repeat; each trial took `trial_steps` actions
    and as many more as its goal's rank.
    """
    goals, starts = len(maze.goals), len(maze.starts)
    order = np.arange(goals)[::-1]
    trials = np.full(goals, (rounds + item.repeat) * starts)
    ranks = np.repeat(np.arange(goals), trials)
    shortest = shortest_ways(maze)
    return LearningRun(
        learner=item.config.learner,
        outcome="learned",
        steps=int((trial_steps + ranks).sum()),
        trials=int(trials.sum()),
        floor_steps=item.config.consecutive_successes * int(shortest.sum()),
        optimal_at=1000 + item.repeat,
        goal_order=order,
        trials_of_goal=trials,
        steps_of_goal=trials * (trial_steps + np.arange(goals)),
        shortest_of_goal=shortest.mean(axis=1)[order],
        trial_steps=(trial_steps + ranks).astype(np.int32),
        trial_goal_rank=ranks.astype(np.int16),
    )


def make_up(items: Sequence[Item], mazes: Sequence[Maze]) -> list[LearningRun]:
    """Make up every run."""
    return [made_up_run(item, mazes[item.maze]) for item in items]


def gave_up(run: LearningRun) -> LearningRun:
    """Return the run as one that gave up while it trained the second goal."""
    return replace(
        run, outcome="gave-up", optimal_at=-1, goal_order=run.goal_order[:2], trials_of_goal=run.trials_of_goal[:2],
        steps_of_goal=run.steps_of_goal[:2], shortest_of_goal=run.shortest_of_goal[:2],
    )  # fmt: skip


def make_up_where(given_up: Callable[[Item], bool]) -> Callable[[Sequence[Item], Sequence[Maze]], list[LearningRun]]:
    """Return a maker of runs of which some gave up."""

    def make(items: Sequence[Item], mazes: Sequence[Maze]) -> list[LearningRun]:
        runs = zip(items, make_up(items, mazes), strict=True)
        return [gave_up(run) if given_up(item) else run for item, run in runs]

    return make
