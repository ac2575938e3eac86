"""Table 8: actions of a trial while a goal of the apartment's maze is being learned (§4.4.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.experiments.learning_run import LearningRun, shortest_ways
from twonav_cli.experiments.paper_figures import TABLE_8
from twonav_cli.experiments.statistics import summary_of
from twonav_cli.experiments.tables.apartment import average_figures, goal_figures, paper_goals
from twonav_cli.experiments.tables.method_runs import EXPLORERS, Make, run_methods
from twonav_cli.experiments.tables.report import Report, report_of, settings_of
from twonav_cli.experiments.tables.request import TableRequest


def table8(request: TableRequest, make: Make) -> Report:
    """Run the paper's two learners, multi-goal also with goals at random, and the explorers; count actions."""
    methods = {
        "single": request.settings("single"),
        "multi": request.settings("multi"),
        "multi-random": request.settings("multi", goal_selection="random"),
        **{name: request.settings(name) for name in EXPLORERS},
    }
    maze = request.scene_maze()
    runs = run_methods(methods, [maze], request.repeats, make)
    shortest = float(shortest_ways(maze).mean())
    return report_of(
        request,
        "Table 8: actions of a trial while a goal is being learned, by order of training",
        "actions",
        {name: paper_goals(column) for name, column in TABLE_8.items()},
        goal_figures(runs, actions, request.seed),
        summary_of(np.full(request.repeats, shortest), request.seed).report(),
        average_figures(runs, actions_above, request.seed),
        settings_of(request, methods, "multi", on_scene=True),
    )


def actions(run: LearningRun) -> NDArray[np.float64]:
    """Return the mean actions of a trial for each goal [K]."""
    return run.steps_of_goal / run.trials_of_goal


def actions_above(run: LearningRun) -> NDArray[np.float64]:
    """Return how far they lie above the shortest ways [K]."""
    return actions(run) - run.shortest_of_goal
