"""What a table says, ready for JSON, for the terminal and for a picture."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from twonav_cli.config import LearningConfig
from twonav_cli.experiments.paper_errata import errata_of
from twonav_cli.experiments.repeats import STEPS_AT_MOST
from twonav_cli.experiments.statistics import RESAMPLES, summary_of
from twonav_cli.experiments.tables.method_runs import Runs, excess_of, floor_of, optimal_after, steps_of, values_of
from twonav_cli.experiments.tables.request import TableRequest

Figures = dict[str, Any]
"""Names to numbers, lists and further names: what JSON can hold."""


@dataclass(frozen=True)
class Report:
    """A table or figure of the paper, and ours.

    Attributes:
        table: A key of TABLES.
        title: One line.
        unit: What the figures count.
        paper: Method to the printed figures.
        ours: Method to "mean", "std", "iqm", "ci95", "runs", "gave_up", and what the table has besides.
        floor: What the criterion costs without any learning, with the same names.
        excess: Method to what lies above the floor, with the same names.
        errata: The paper's slips: "row" and "text".
        settings: Everything that decides the figures, the command and the versions.
    """

    table: str
    title: str
    unit: str
    paper: Figures
    ours: Figures
    floor: Figures
    excess: Figures
    errata: list[dict[str, str]]
    settings: Figures


def report_of(
    request: TableRequest,
    title: str,
    unit: str,
    paper: Figures,
    ours: Figures,
    floor: Figures,
    excess: Figures,
    settings: Figures,
) -> Report:
    """Return the report of a request, with the errata of its table."""
    errata = [asdict(erratum) for erratum in errata_of(request.table)]
    return Report(request.table, title, unit, paper, ours, floor, excess, errata, settings)


def settings_of(
    request: TableRequest, methods: Mapping[str, LearningConfig], reference: str, on_scene: bool = False
) -> Figures:
    """Return everything that decides the figures.

    Args:
        request: What was asked.
        methods: The settings of every method.
        reference: The method whose settings are given in full; of the others only what differs.
        on_scene: Whether the table is about a scene's maze and not about random ones.
    """
    full = asdict(methods[reference])
    where = {"scene": request.scene} if on_scene else {"mazes": request.mazes}
    differences = {
        name: {key: value for key, value in asdict(config).items() if value != full[key]}
        for name, config in methods.items()
    }
    return {
        **{key: value for key, value in full.items() if key != "learner"},
        **where,
        "repeats": request.repeats,
        "seed": request.seed,
        "steps_at_most": STEPS_AT_MOST,
        "bootstrap_resamples": RESAMPLES,
        "methods": differences,
        "command": request.command(on_scene),
        "versions": versions(),
    }


def versions() -> dict[str, str]:
    """Return the versions of what the figures depend on."""
    found = {"python": platform.python_version()}
    for package in ("twonav", "numpy", "numba"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:  # run from a checkout that is not installed
            found[package] = "unknown"
    return found


def step_figures(runs: Mapping[str, Runs], seed: int) -> tuple[Figures, Figures, Figures]:
    """Return ours, floor and excess of the actions until every goal is learned."""
    ours = {
        name: {
            **summary_of(values_of(of_method, steps_of), seed).report(),
            "optimal_at": summary_of(optimal_after(of_method), seed).report(),
        }
        for name, of_method in runs.items()
    }
    excess = {name: summary_of(values_of(of_method, excess_of), seed).report() for name, of_method in runs.items()}
    return ours, floor_figures(next(iter(runs.values())), seed), excess


def floor_figures(runs: Runs, seed: int) -> Figures:
    """Return the floor of the mazes; it is the same for every method and every run."""
    return summary_of([[floor_of(run) for run in row] for row in runs], seed).report()
