"""Everything that can be reproduced, by name, and making a table about learning."""

from __future__ import annotations

from collections.abc import Callable

from twonav_cli.errors import unknown_name
from twonav_cli.experiments.localizer_tables.request import PRINTED
from twonav_cli.experiments.tables.fig8 import fig8
from twonav_cli.experiments.tables.method_runs import Make
from twonav_cli.experiments.tables.report import Report
from twonav_cli.experiments.tables.request import REPEATS, SWEEP_REPEATS, TableRequest
from twonav_cli.experiments.tables.sensitivity import sensitivity
from twonav_cli.experiments.tables.table5 import table5
from twonav_cli.experiments.tables.table6 import table6
from twonav_cli.experiments.tables.table7 import table7
from twonav_cli.experiments.tables.table8 import table8
from twonav_cli.experiments.transfer.request import TABLES as TRANSFERS

TABLES: dict[str, Callable[[TableRequest, Make], Report]] = {
    "table5": table5,
    "table6": table6,
    "table7": table7,
    "table8": table8,
    "fig8": fig8,
    "sensitivity": sensitivity,
}
"""Those about learning in mazes."""

LOCALIZER_TABLES = tuple(PRINTED)
"""Those about localizers, whose trainings take hours: they are made by name only."""

TRANSFER_TABLES = TRANSFERS
"""Those about agents that learn in 2D and 3D, which takes hours: by name only as well."""

WRONG_PLACES = "fig9"
"""The figure about places where the camera's pose is wrong."""

EVERY_TABLE = "all"


def tables_named(name: str) -> list[str]:
    """Return the tables that a name stands for: itself, or every one about learning for "all".

    Raises:
        TwonavError: There is no such table.
    """
    if name == EVERY_TABLE:
        return list(TABLES)
    known = (*LOCALIZER_TABLES, *TABLES, *TRANSFER_TABLES, WRONG_PLACES)
    if name not in known:
        raise unknown_name("table", name, [*known, EVERY_TABLE])
    return [name]


def default_repeats(table: str) -> int:
    """Return how often each method of a table runs on each maze when nobody says so."""
    return SWEEP_REPEATS if table == "sensitivity" else REPEATS


def make_table(request: TableRequest, make: Make) -> Report:
    """Make a table about learning.

    Args:
        request: Which, and from what.
        make: Makes the runs.

    Raises:
        TwonavError: The request cannot be fulfilled.
    """
    request.check()
    return TABLES[request.table](request, make)
