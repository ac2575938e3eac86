"""The runs that a table compares: every method on every maze, as often as asked.

M mazes, n repeats, K goals in order of training.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import LearningConfig
from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.repeats import Item
from twonav_cli.maze import Maze

FloatArray = NDArray[np.float64]
Name = TypeVar("Name")

Make = Callable[[Sequence[Item], Sequence[Maze]], list[LearningRun]]
"""Makes runs and returns them in the order of the items."""

Runs = list[list[LearningRun]]
"""[M][n] runs of one method."""

EXPLORERS = ("optimistic", "prioritized-sweeping", "nearest-untried", "oracle")
"""The learners beside the paper's two."""


def run_methods(
    methods: Mapping[Name, LearningConfig], mazes: Sequence[Maze], repeats: int, make: Make
) -> dict[Name, Runs]:
    """Run every method on every maze; methods of equal settings share their runs."""
    wanted = list(dict.fromkeys(methods.values()))
    items = [Item(c, maze, repeat) for c in wanted for maze in range(len(mazes)) for repeat in range(repeats)]
    made = iter(make(items, mazes))
    by_config = {config: [[next(made) for _ in range(repeats)] for _ in mazes] for config in wanted}
    return {name: by_config[config] for name, config in methods.items()}


def values_of(runs: Runs, value: Callable[[LearningRun], float]) -> FloatArray:
    """Return a figure of every run [M, n]; infinite for a run that gave up."""
    return np.array([[value(run) if run.learned else np.inf for run in row] for row in runs], dtype=np.float64)


def steps_of(run: LearningRun) -> float:
    """Return the actions until every goal is learned, confirmation included."""
    return run.steps


def floor_of(run: LearningRun) -> float:
    """Return the actions of the confirmation trials alone, were every one a shortest way."""
    return run.floor_steps


def excess_of(run: LearningRun) -> float:
    """Return the actions over the floor: what learning costs."""
    return run.steps - run.floor_steps


def optimal_after(runs: Runs) -> FloatArray:
    """Return the actions after which the ways of all pairs were shortest [M, n]; infinite for a run without."""
    return np.array(
        [[run.optimal_at if run.optimal_at >= 0 else np.inf for run in row] for row in runs], dtype=np.float64
    )


def by_goal(runs: Runs, value: Callable[[LearningRun], FloatArray]) -> FloatArray:
    """Return a figure of every goal in order of training, for every run [K, n] of one maze; infinite as above."""
    goals = max(len(run.goal_order) for run in runs[0])
    nothing = np.full(goals, np.inf)
    return np.stack([value(run) if run.learned else nothing for run in runs[0]], axis=1)
