"""`twonav reproduce`: the paper's tables and figures about the maze, made again beside the printed ones."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.repeats import Item, StoppedError, make_runs, processors
from twonav_cli.experiments.tables.catalog import EVERY_TABLE, default_repeats, make_table, tables_named
from twonav_cli.experiments.tables.report import Report
from twonav_cli.experiments.tables.request import MAZES, SCENE, TableRequest
from twonav_cli.files import write_whole
from twonav_cli.maze import Maze
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.interrupt import StopOnInterrupt


@dataclass(frozen=True)
class ReproduceRequest:
    """Everything the command line says about tables to make; None is the default."""

    table: str
    repeats: int | None = None
    seed: int = 0
    discount: float | None = None
    mazes: int = MAZES
    scene: str = SCENE
    processes: int | None = None
    as_json: bool = False
    out: Path | None = None
    cooling: str = "per-goal"

    def table_request(self, table: str) -> TableRequest:
        """Return what is asked of one table."""
        repeats = default_repeats(table) if self.repeats is None else self.repeats
        return TableRequest(table, repeats, self.seed, self.discount, self.mazes, self.scene, self.cooling)


def run_reproduce(request: ReproduceRequest) -> int:
    """Make, print and write the tables; returns 0, or 130 when interrupted (finished tables are kept)."""
    wanted = [request.table_request(name) for name in tables_named(request.table)]
    for table in wanted:
        table.check()
    processes = processors() if request.processes is None else request.processes
    if processes < 1:
        raise TwonavError(f"--processes must be at least 1: {processes} was given")
    folder = writable(request.out or runs_dir() / "reproduce")
    reports: dict[str, Any] = {}
    with StopOnInterrupt("stopping: what is finished is kept") as stop:
        for table in wanted:
            try:
                report = _made(table, processes, stop)
            except StoppedError:
                print(f"stopped: nothing is written of {table.table}", file=sys.stderr)
                return 130
            reports[table.table] = asdict(report)
            if not request.as_json:
                from twonav_cli.terminal.reproduced_tables import print_report

                print_report(report)
            _write(report, folder)
    if request.as_json:
        print(json.dumps(reports if request.table == EVERY_TABLE else reports[request.table], allow_nan=False))
    return 0


def writable(folder: Path) -> Path:
    """Return a folder that exists and can be written, before minutes are spent on what goes there.

    Raises:
        TwonavError: It cannot.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TwonavError(f"cannot write into {folder} ({error.strerror or error}): name another --out") from error
    if not os.access(folder, os.W_OK | os.X_OK):
        raise TwonavError(f"cannot write into {folder}: name another --out")
    return folder


def _made(table: TableRequest, processes: int, should_stop: Callable[[], bool]) -> Report:
    """Make one table, with a progress bar while its runs are made."""

    def make(items: Sequence[Item], mazes: Sequence[Maze]) -> list[LearningRun]:
        with progress() as bar:
            task = bar.add_task(table.table, total=len(items), result="")
            gave_up = 0

            def show(run: LearningRun) -> None:
                nonlocal gave_up
                gave_up += run.outcome == "gave-up"
                bar.update(task, advance=1, result=f"{gave_up} gave up" if gave_up else "")

            return make_runs(items, mazes, table.seed, processes, should_stop, show)

    return make_table(table, make)


def _write(report: Report, folder: Path) -> None:
    """Write NAME.json and NAME.png, and print their paths."""
    from twonav_cli.plotting.pictures import picture_of

    text = json.dumps(asdict(report), indent=1, allow_nan=False) + "\n"
    for path, content in ((f"{report.table}.json", text), (f"{report.table}.png", picture_of(report))):
        print(write_whole(folder / path, content), file=sys.stderr)
