"""Tables 9 and 10 as a person reads them: the paper's figures beside ours, the effort and the settings below."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from rich.table import Table

from twonav_cli.experiments.transfer.request import FROM_NOTHING, TRANSFERRED
from twonav_cli.experiments.transfer.tables import Figures, TransferReport
from twonav_cli.terminal.console import new_table, out

NONE = "-"

MEANS = {
    "table9": "Means are over agents, starts and goals that were reached; ± is the deviation from agent to agent, "
    "averaged over the pairs.",
    "table10": "Means and deviations (±) are over the agents that learned the goal; the actions to it are the mean "
    "over the starts from which it was reached afterwards.",
}
"""What the figures of each table are."""


def print_transfer(report: TransferReport) -> None:
    """Print a table with everything that belongs to it."""
    console = out()
    console.print(f"\n[bold]{report.title}[/bold]")
    for table in _tables_9(report) if report.table == "table9" else _tables_10(report):
        console.print(table)
        console.print()
    for erratum in report.errata:
        console.print(f"{erratum['row']}: {erratum['text']}", markup=False)
    for line in _settings(report):
        console.print(line, markup=False)
    # One line whatever the width is, so that it can be copied.
    console.print(report.settings["command"], markup=False, soft_wrap=True)


def _tables_9(report: TransferReport) -> Iterable[Table]:
    """Return the goals' actions, and what the agents of either stage took and how they drove."""
    goals = new_table("goal", "2D", "±", "shortest", "reached", "3D", "±", "shortest", "reached")
    for row in report.goals:
        goals.add_row(row["goal"], *_of_stages([row.get(name, {}) for name in ("2d", "3d")]))
    ours = [report.ours.get(name, {}) for name in ("2d", "3d")]
    goals.add_row("all, ours", *_of_stages(ours))
    paper = [report.paper[name] for name in ("2d", "3d")]
    printed = [(_number(column["mean"], 1), _number(column["std"], 1), NONE, NONE) for column in paper]
    goals.add_row("all, the paper's", *(cell for cells in printed for cell in cells))
    yield goals
    yield _effort_table({"2D": ours[0], "3D": ours[1]})


def _of_stages(stages: list[Figures]) -> list[str]:
    """Return actions, their deviation, the shortest ways of the same pairs and how many were reached, of each stage."""
    keys = ("actions_mean", "actions_std", "shortest_mean")
    return [cell for stage in stages for cell in (*(_number(stage.get(key), 1) for key in keys), _share(stage))]


def _share(stage: Figures) -> str:
    return f"{stage['successes']} of {stage['pairs']}" if stage.get("pairs") else NONE


def _tables_10(report: TransferReport) -> Iterable[Table]:
    """Return what each place in the order of training took, and either way's effort."""
    table = new_table(
        "goal no.", "trials\npaper", "±", "ours", "±", "actions\npaper", "±", "ours", "±", "not learned\npaper", "ours"
    )
    paper = report.paper
    for number, row in enumerate(report.goals):
        printed = [paper[name]["goals"][number] if number < 10 else {} for name in ("trials", "actions")]
        cells = []
        for column, name in zip(printed, ("trials", "actions"), strict=True):
            cells += [_number(column.get(key), 1) for key in ("mean", "std")]
            cells += [_number(row[name][key], 1) for key in ("mean", "std")]
        not_reached = str(paper["not_reached"][number]) if number < 10 else NONE
        table.add_row(str(row["place"]), *cells, not_reached, str(row["not_learned"]))
    yield table
    ways = {"from nothing": report.ours[FROM_NOTHING], "transferred": report.ours[TRANSFERRED]}
    yield _effort_table(ways)


def _effort_table(ways: dict[str, Figures]) -> Table:
    """Return what learning took and how the agents drove afterwards."""
    table = new_table(
        "", "agents that\nlearned all", "trials", "actions", "minutes", "success", "SPL", "collisions\nper 100",
        "wrong\ncells\nper 100",
    )  # fmt: skip
    for name, way in ways.items():
        driven = way.get("driven", way)
        effort = [
            _number(way.get(key, {}).get("mean"), digits)
            for key, digits in (("trials", 0), ("steps", 0), ("minutes", 1))
        ]
        rates = [_number(driven.get(f"{key}_per_100_actions"), 2) for key in ("collisions", "wrong_cells")]
        quality = [_number(driven.get(key), 3) for key in ("success_rate", "spl")]
        learned = f"{way.get('learned_all', 0)} of {way.get('agents', 0)}"
        table.add_row(name, learned, *effort, *quality, *rates)
    return table


def _settings(report: TransferReport) -> list[str]:
    settings = report.settings
    lines = [
        f"{settings['scene']}, seed {settings['seed']}, {settings['agents']} agents, {settings['base']} base, "
        f"3D poses: {settings['localizer']}, map of the {settings['map']}.",
        MEANS[report.table],
        f"Learned: {settings['learning']['2d']['consecutive_successes']} successes in a row from each start in 2D, "
        f"{settings['learning']['3d']['consecutive_successes']} in 3D.",
    ]
    before = report.ours.get(TRANSFERRED, {}).get("minutes_before")
    lines += [] if settings["scene"] == "apartment" else ["The paper's figures are of its own apartment."]
    lines += [] if not before else [f"Before 3D the transferred agents learned {before:.1f} min in maze and 2D."]
    lines += ["A quick run, which shows no more than that everything works."] if settings["quick"] else []
    versions = ", ".join(f"{name} {number}" for name, number in settings["versions"].items())
    return [*lines, f"Versions: {versions}."]


def _number(value: Any, digits: int) -> str:
    return NONE if value is None else f"{value:,.{digits}f}"
