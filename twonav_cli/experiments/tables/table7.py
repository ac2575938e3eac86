"""Table 7: trials from each start until a goal of the apartment's maze is learned (§4.4.2)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.paper_figures import TABLE_7
from twonav_cli.experiments.statistics import summary_of
from twonav_cli.experiments.tables.apartment import average_figures, goal_figures, paper_goals
from twonav_cli.experiments.tables.method_runs import EXPLORERS, Make, run_methods
from twonav_cli.experiments.tables.report import Report, report_of, settings_of
from twonav_cli.experiments.tables.request import TableRequest

METHODS = ("single", "multi", *EXPLORERS)


def table7(request: TableRequest, make: Make) -> Report:
    """Run the paper's two learners and the explorers on the scene's maze, and count trials."""
    maze = request.scene_maze()
    methods = {name: request.settings(name) for name in METHODS}
    runs = run_methods(methods, [maze], request.repeats, make)
    least, starts = methods["multi"].consecutive_successes, len(maze.starts)

    def trials(run: LearningRun) -> NDArray[np.float64]:
        return run.trials_of_goal / starts

    def above(run: LearningRun) -> NDArray[np.float64]:
        return trials(run) - least

    return report_of(
        request,
        "Table 7: trials from each start until a goal is learned, by order of training",
        "trials",
        {name: paper_goals(column) for name, column in TABLE_7.items()},
        goal_figures(runs, trials, request.seed),
        summary_of(np.full(request.repeats, least), request.seed).report(),
        average_figures(runs, above, request.seed),
        settings_of(request, methods, "multi", on_scene=True),
    )
