"""Table 5: actions until every goal of a random maze is learned, one goal at a time against all at once (§4.4.2)."""

from __future__ import annotations

from twonav_cli.experiments.paper_figures import TABLE_5, PerMaze
from twonav_cli.experiments.statistics import means_of
from twonav_cli.experiments.tables.method_runs import EXPLORERS, Make, Runs, run_methods, steps_of, values_of
from twonav_cli.experiments.tables.report import Figures, Report, report_of, settings_of, step_figures
from twonav_cli.experiments.tables.request import TableRequest

METHODS = ("single", "multi", *EXPLORERS)


def table5(request: TableRequest, make: Make) -> Report:
    """Run the paper's two learners and the explorers on the random mazes."""
    methods = {name: request.settings(name) for name in METHODS}
    runs = run_methods(methods, request.random_mazes(), request.repeats, make)
    ours, floor, excess = step_figures(runs, request.seed)
    return report_of(
        request,
        "Table 5: actions until every goal of a random maze is learned",
        "actions",
        {name: paper_row(row) for name, row in TABLE_5.items()},
        with_mazes(ours, runs),
        floor,
        excess,
        settings_of(request, methods, "multi"),
    )


def paper_row(row: PerMaze) -> Figures:
    """Return a printed row in actions."""
    return {"mean": 1000 * row.average_thousands, "per_maze": [1000 * value for value in row.thousands]}


def with_mazes(ours: Figures, runs: dict[str, Runs]) -> Figures:
    """Return the figures with the mean of every maze beside them."""
    return {name: {**ours[name], "per_maze": means_of(values_of(runs[name], steps_of))} for name in ours}
