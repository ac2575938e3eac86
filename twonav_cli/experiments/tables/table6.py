"""Table 6: goals selected by TD error or at random, under a relaxed criterion (§4.4.2); in order is our row."""

from __future__ import annotations

from twonav_cli.config import LearningConfig
from twonav_cli.experiments.paper_figures import TABLE_6
from twonav_cli.experiments.tables.method_runs import Make, run_methods
from twonav_cli.experiments.tables.report import Report, report_of, settings_of, step_figures
from twonav_cli.experiments.tables.request import TableRequest
from twonav_cli.experiments.tables.table5 import paper_row, with_mazes

STARTING_VALUES = ((1.0, 0.0), (2.0, 80.0))
"""Starting temperature and first Q value (Table 6)."""

SELECTIONS = ("random", "td-error", "sequential")

SUCCESSES = 15
"""Trials in a row that must succeed from each start (§4.3)."""

NO_STEP_CRITERION = 1e9
"""Mean difference in actions that nothing exceeds (§4.3: the criterion is dropped here)."""


def table6(request: TableRequest, make: Make) -> Report:
    """Run the multi-goal learner with each selection from both starting values."""
    methods = {
        row_name(*row): relaxed(request, *row)
        for row in [(temperature, q, rule) for temperature, q in STARTING_VALUES for rule in SELECTIONS]
    }
    runs = run_methods(methods, request.random_mazes(), request.repeats, make)
    ours, floor, excess = step_figures(runs, request.seed)
    return report_of(
        request,
        "Table 6: actions until every goal is learned, by goal selection (relaxed criterion)",
        "actions",
        {row_name(*row): paper_row(figures) for row, figures in TABLE_6.items()},
        with_mazes(ours, runs),
        floor,
        excess,
        settings_of(request, methods, row_name(2.0, 80.0, "td-error")),
    )


def relaxed(request: TableRequest, temperature: float, initial_q: float, selection: str) -> LearningConfig:
    """Return the settings of a row."""
    return request.settings(
        "multi",
        temperature=temperature,
        initial_q=initial_q,
        goal_selection=selection,
        consecutive_successes=SUCCESSES,
        max_step_difference=NO_STEP_CRITERION,
    )


def row_name(temperature: float, initial_q: float, selection: str) -> str:
    """Return the name of a row."""
    return f"{selection} T={temperature:g} Q0={initial_q:g}"
