"""Why the paper's table moves: one setting at a time around the paper's preset, on the random mazes of Table 5 (ours).

M mazes, n repeats.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from twonav_cli.config import LearningConfig
from twonav_cli.experiments.paper_figures import TABLE_5
from twonav_cli.experiments.statistics import summary_of
from twonav_cli.experiments.tables.method_runs import Make, Runs, excess_of, run_methods, steps_of, values_of
from twonav_cli.experiments.tables.report import Figures, Report, floor_figures, report_of, settings_of
from twonav_cli.experiments.tables.request import TableRequest
from twonav_cli.experiments.tables.table5 import paper_row

METHODS = ("single", "multi")

SWEEPS: dict[str, tuple[float, ...]] = {
    "discount": (0.8, 0.9, 0.95, 0.99, 0.995),
    "initial_q": (0.0, 50.0, 80.0, 100.0, 120.0),
    "temperature": (0.5, 1.0, 2.0, 4.0),
    "trial_limit_steps": (100, 200, 500, 1000, 2000),
}
"""Setting to the values it takes while the others stay (ours)."""


class Point(NamedTuple):
    """A method with one setting changed."""

    method: str
    field: str
    value: float


PRESET = Point("multi", "", 0.0)
"""Nothing changed."""


def sensitivity(request: TableRequest, make: Make) -> Report:
    """Run both of the paper's learners over every sweep."""
    methods = {name: request.settings(name) for name in METHODS}
    points: dict[Point, LearningConfig] = {PRESET._replace(method=name): config for name, config in methods.items()}
    for name in METHODS:
        for field, values in SWEEPS.items():
            points |= {Point(name, field, value): request.settings(name, **{field: value}) for value in values}
    runs = run_methods(points, request.random_mazes(), request.repeats, make)
    ours = {name: figures_of(runs[PRESET._replace(method=name)], request.seed) for name in METHODS}
    for name in METHODS:
        ours[name]["sweeps"] = sweeps_of(name, runs, request.seed)
    settings = settings_of(request, methods, "multi")
    settings["sweeps"] = {field: list(values) for field, values in SWEEPS.items()}
    return report_of(
        request,
        "Sensitivity: actions until every goal of a random maze is learned, one setting changed at a time",
        "actions",
        {name: paper_row(row) for name, row in TABLE_5.items()},
        ours,
        floor_figures(runs[PRESET], request.seed),
        {name: ours[name].pop("excess") for name in METHODS},
        settings,
    )


def figures_of(runs: Runs, seed: int) -> Figures:
    """Return the actions of some runs, and their excess over the floor."""
    totals = summary_of(values_of(runs, steps_of), seed)
    excess = summary_of(values_of(runs, excess_of), seed)
    share = totals.gave_up / totals.runs
    return {**totals.report(), "gave_up_share": round(share, 4), "excess": excess.report()}


def sweeps_of(name: str, runs: Mapping[Point, Runs], seed: int) -> Figures:
    """Return for every setting the figures at each of its values."""
    return {
        field: [{"value": value, **figures_of(runs[Point(name, field, value)], seed)} for value in values]
        for field, values in SWEEPS.items()
    }
