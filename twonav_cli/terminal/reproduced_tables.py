"""The reproduced tables as a person reads them: in the paper's shape, with settings, errata and the command below."""

from __future__ import annotations

from typing import Any

from rich.table import Table

from twonav_cli.experiments.tables.report import Figures, Report
from twonav_cli.experiments.tables.request import SCENE
from twonav_cli.terminal.console import out

NONE = "-"
MAZES_SHOWN = 10
"""With more random mazes, their columns do not fit a terminal; the JSON holds them."""

ENDLESS = 1e9
"""A setting of this size or more switches something off."""

SETTING_NAMES = {
    "discount": "discount",
    "temperature": "T",
    "initial_q": "Q0",
    "trial_limit_steps": "trial limit",
    "replay_period_steps": "replay period",
    "goal_selection": "goals by",
    "cooling": "T cools",
}
"""Settings of the sentence below a table; the rest of them is in the JSON."""


def print_report(report: Report) -> None:
    """Print a table with everything that belongs to it."""
    console = out()
    console.print(f"\n[bold]{report.title}[/bold]" + ("" if report.unit == "trials" else f" ({_unit(report)})"))
    for table in _tables_of(report):
        console.print(table)
        console.print()
    if report.settings.get("scene", SCENE) != SCENE:
        console.print("the paper's figures are of its own apartment, with 10 goals", markup=False)
    for mark, erratum in zip(_marks(report), report.errata, strict=True):
        console.print(f"({mark}) {erratum['row']}: {erratum['text']}", markup=False)
    for line in (*_gave_up(report), *_settings(report.settings)):
        console.print(line, markup=False)
    # One line whatever the width is, so that it can be copied.
    console.print(report.settings["command"], markup=False, soft_wrap=True)


def _tables_of(report: Report) -> list[Table]:
    if report.table == "sensitivity":
        return [_sweep_table(report)]
    shape = {"table5": _maze_table, "table6": _maze_table, "table7": _goal_table, "table8": _goal_table}
    in_papers_shape = shape.get(report.table)
    first = [in_papers_shape(report)] if in_papers_shape and _fits(report) else []
    return [*first, _method_table(report)]


def _fits(report: Report) -> bool:
    return bool(report.settings.get("mazes", 0) <= MAZES_SHOWN)


def _in_thousands(report: Report) -> bool:
    return report.table not in ("table7", "table8")


def _unit(report: Report) -> str:
    return f"thousand {report.unit}" if _in_thousands(report) else report.unit


def _number(value: float | None, thousands: bool, digits: int = 1) -> str:
    if value is None:
        return NONE
    return f"{value / 1000 if thousands else value:.{digits}f}"


def _interval(ends: list[float | None], thousands: bool) -> str:
    low, high = (_number(end, thousands) for end in ends)
    return NONE if low == high == NONE else f"{low}–{high}"


def _new_table(*headings: str) -> Table:
    table = Table(box=None, pad_edge=False, padding=(0, 1, 0, 0), collapse_padding=True)
    for number, heading in enumerate(headings):
        table.add_column(heading, justify="right" if number else "left", vertical="bottom")
    return table


def _readable(method: str) -> str:
    """Return a method's name with spaces, where a narrow terminal may break it."""
    return method if "=" in method else method.replace("-", " ")


def _marks(report: Report) -> str:
    return "abcdefgh"[: len(report.errata)]


def _marks_of(report: Report, row: str) -> str:
    marks = zip(_marks(report), report.errata, strict=True)
    return " ".join(mark for mark, erratum in marks if erratum["row"] == row)


def _maze_table(report: Report) -> Table:
    """Return Table 5 or 6 as printed: a column per maze. The paper's mazes are others, drawn by the same rule."""
    mazes = max(len(row["per_maze"]) for rows in (report.ours, report.paper) for row in rows.values())
    table = _new_table("maze", *(str(number + 1) for number in range(mazes)), "mean")
    for method, ours in report.ours.items():
        for whose, row in (("paper", report.paper.get(method)), ("ours", ours)):
            if row is not None:
                cells = [_number(value, True, 0) for value in row["per_maze"]]
                cells += [""] * (mazes - len(cells))
                table.add_row(f"{_readable(method)}, {whose}", *cells, _number(row["mean"], True, 0))
    return table


def _goal_table(report: Report) -> Table:
    """Return Table 7 or 8 as printed: a row per goal, mean and deviation of every method, the paper's and ours."""
    columns = [(m, whose) for m in report.paper for whose in (report.paper, report.ours)]
    headings = []
    for method, whose in columns:
        headings += [f"{_readable(method)}\n{'paper' if whose is report.paper else 'ours'}", "±"]
    table = _new_table("goal", *headings)
    goals = max(len(whose[method]["goals"]) for method, whose in columns)
    for number in range(goals):
        cells = []
        for method, whose in columns:
            rows = whose[method]["goals"]
            cells += _mean_and_std(rows[number] if number < len(rows) else {"mean": None, "std": None})
        table.add_row(str(number + 1), *cells)
    averages = []
    for method, whose in columns:
        row = whose[method]
        averages += _mean_and_std({"mean": row["mean"], "std": row.get("std_of_goals", row["std"])})
    table.add_row("mean", *averages)
    return table


def _mean_and_std(row: Figures) -> list[str]:
    return [_number(row["mean"], False), _number(row["std"], False)]


def _method_table(report: Report) -> Table:
    """Return the figures of every method: the paper's, ours with the interval, floor, excess and errata."""
    thousands = _in_thousands(report)
    with_optimal = any("optimal_at" in row for row in report.ours.values())
    headings = ["method", "paper", "mean", "std", "IQM", "95 %", "floor", "excess"]
    table = _new_table(*headings, *(["all pairs\noptimal\nafter"] if with_optimal else []), "errata")
    for method, row in report.ours.items():
        paper = report.paper.get(method, {}).get("mean")
        cells = [_number(value, thousands) for value in (paper, row["mean"], row["std"], row["iqm"])]
        cells.append(_interval(row["ci95"], thousands))
        cells += [_number(report.floor["iqm"], thousands), _number(report.excess[method]["iqm"], thousands)]
        cells += [_optimal(row["optimal_at"])] if with_optimal else []
        table.add_row(_readable(method), *cells, _marks_of(report, method))
    return table


def _optimal(figures: Figures) -> str:
    """Return the interquartile mean, or in how many runs it happened at all where those are too few for one."""
    if figures["iqm"] is not None:
        return _number(figures["iqm"], True)
    return f"{figures['runs'] - figures['gave_up']} of {figures['runs']}"


def _sweep_table(report: Report) -> Table:
    """Return the sensitivity sweep: a row per value, the interquartile mean and excess of both methods."""
    methods = list(report.ours)
    table = _new_table("setting", *(text for m in methods for text in (f"{m}\nIQM", "95 %", "excess")), "gave up")
    papers = [_number(report.paper[method]["mean"], True) for method in methods]
    table.add_row("paper", *(cell for paper in papers for cell in (paper, "", "")), "")
    for setting, values in report.settings["sweeps"].items():
        table.add_row()
        for place, value in enumerate(values):
            points = [report.ours[method]["sweeps"][setting][place] for method in methods]
            name = f"{SETTING_NAMES[setting]} {value:g}" + (" *" if value == report.settings[setting] else "")
            gave_up = " ".join(f"{point['gave_up']}/{point['runs']}" for point in points)
            table.add_row(
                name,
                *(cell for point in points for cell in _sweep_cells(point)),
                gave_up if any(point["gave_up"] for point in points) else NONE,
            )
    return table


def _sweep_cells(point: Figures) -> list[str]:
    return [_number(point["iqm"], True), _interval(point["ci95"], True), _number(point["excess"]["iqm"], True)]


def _gave_up(report: Report) -> list[str]:
    """Return a sentence about the runs that gave up, if there are any."""
    found = [f"{name} {row['gave_up']} of {row['runs']}" for name, row in report.ours.items() if row["gave_up"]]
    counted = "such a run counts as longer than any other, so there is no mean, and no IQM if over a quarter are"
    return [f"Gave up: {', '.join(found)}; {counted}."] if found else []


def _settings(settings: Figures) -> list[str]:
    chosen = ", ".join(_setting(key, settings[key]) for key in SETTING_NAMES)
    where = f"scene {settings['scene']}" if "scene" in settings else _counted(settings["mazes"], "random maze")
    difference = settings["max_step_difference"]
    criterion = f"criterion: {settings['consecutive_successes']} successes in a row from each start, " + (
        f"steps differing by less than {difference:g}" if difference < ENDLESS else "any number of steps"
    )
    versions = ", ".join(f"{name} {number}" for name, number in settings["versions"].items())
    lines = [
        f"{where}, {_counted(settings['repeats'], 'repeat')}, seed {settings['seed']}; {chosen}; {criterion}.",
        *(f"{name}: {_differences(found)}." for name, found in settings["methods"].items() if _own(found)),
        f"IQM: interquartile mean; 95 %: bootstrap within each maze. A run gives up after "
        f"{settings['steps_at_most']:,} actions.",
    ]
    lines += ["* the preset."] if "sweeps" in settings else []
    lines += [f"Panels: {settings['panels']}."] if "panels" in settings else []
    return [*lines, f"Versions: {versions}."]


def _counted(number: int, thing: str) -> str:
    return f"{number} {thing}{'s' * (number != 1)}"


def _own(differences: Figures) -> bool:
    """Whether a method's settings differ in more than the name of the learner."""
    return bool(differences.keys() - {"learner"})


def _differences(found: Figures) -> str:
    return ", ".join(_setting(key, value) for key, value in found.items() if key != "learner")


def _setting(key: str, value: Any) -> str:
    if key == "replay_period_steps" and value >= ENDLESS:
        return "no replay"
    name = SETTING_NAMES.get(key, key.replace("_", " "))
    return f"{name} {value}" if isinstance(value, str) else f"{name} {value:,g}"
