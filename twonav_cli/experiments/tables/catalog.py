"""The tables by name, and making one of them."""

from __future__ import annotations

from collections.abc import Callable

from twonav_cli.errors import unknown_name
from twonav_cli.experiments.tables.fig8 import fig8
from twonav_cli.experiments.tables.method_runs import Make
from twonav_cli.experiments.tables.report import Report
from twonav_cli.experiments.tables.request import REPEATS, SWEEP_REPEATS, TableRequest
from twonav_cli.experiments.tables.sensitivity import sensitivity
from twonav_cli.experiments.tables.table5 import table5
from twonav_cli.experiments.tables.table6 import table6
from twonav_cli.experiments.tables.table7 import table7
from twonav_cli.experiments.tables.table8 import table8

TABLES: dict[str, Callable[[TableRequest, Make], Report]] = {
    "table5": table5,
    "table6": table6,
    "table7": table7,
    "table8": table8,
    "fig8": fig8,
    "sensitivity": sensitivity,
}

EVERY_TABLE = "all"


def tables_named(name: str) -> list[str]:
    """Return the tables that a name stands for: itself, or every one for "all".

    Raises:
        TwonavError: There is no such table.
    """
    if name == EVERY_TABLE:
        return list(TABLES)
    if name not in TABLES:
        raise unknown_name("table", name, [*TABLES, EVERY_TABLE])
    return [name]


def default_repeats(table: str) -> int:
    """Return how often each method of a table runs on each maze when nobody says so."""
    return SWEEP_REPEATS if table == "sensitivity" else REPEATS


def make_table(request: TableRequest, make: Make) -> Report:
    """Make a table.

    Args:
        request: Which, and from what.
        make: Makes the runs.

    Raises:
        TwonavError: The request cannot be fulfilled.
    """
    request.check()
    return TABLES[request.table](request, make)
