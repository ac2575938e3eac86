"""What Tables 7 and 8 share: a scene's maze, and figures of every goal in the order in which it was trained.

K goals, n repeats.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from numpy.typing import NDArray

from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.paper_figures import PerGoal
from twonav_cli.experiments.statistics import rounded, summary_of
from twonav_cli.experiments.tables.method_runs import Runs, by_goal
from twonav_cli.experiments.tables.report import Figures

FloatArray = NDArray[np.float64]


def goal_figures(runs: Mapping[str, Runs], value: Callable[[LearningRun], FloatArray], seed: int) -> Figures:
    """Return ours: the figures of each run's average over its goals, and of every goal by itself.

    "std_of_goals" is the paper's average row: its deviation is the mean of the goals' deviations.
    """
    ours = {}
    for name, of_method in runs.items():
        table = by_goal(of_method, value)  # (K, n)
        goals = [summary_of(row, seed).report() for row in table]
        stds = [goal["std"] for goal in goals]
        ours[name] = {
            **summary_of(table.mean(axis=0), seed).report(),
            "std_of_goals": None if None in stds else rounded(np.mean(stds)),
            "goals": goals,
        }
    return ours


def average_figures(runs: Mapping[str, Runs], value: Callable[[LearningRun], FloatArray], seed: int) -> Figures:
    """Return the figures of each run's average over its goals."""
    return {name: summary_of(by_goal(of, value).mean(axis=0), seed).report() for name, of in runs.items()}


def paper_goals(column: PerGoal) -> Figures:
    """Return a printed column pair."""
    goals = [{"mean": mean, "std": std} for mean, std in zip(column.means, column.stds, strict=True)]
    return {"mean": column.average_mean, "std": column.average_std, "goals": goals}
