"""`twonav reproduce`: the paper's tables and figures, made again beside the printed ones; here those about mazes."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.experiments.repeats import Item, make_runs
from twonav_cli.experiments.tables.catalog import (
    EVERY_TABLE,
    LOCALIZER_TABLES,
    TABLES,
    TRANSFER_TABLES,
    WRONG_PLACES,
    default_repeats,
    make_table,
    tables_named,
)
from twonav_cli.experiments.tables.report import Report
from twonav_cli.experiments.tables.request import MAZES, SCENE, TableRequest
from twonav_cli.experiments.transfer.request import AGENTS, QUICK_AGENTS, TransferRequest
from twonav_cli.files import writable, write_whole
from twonav_cli.mapping.floor import read_floor
from twonav_cli.maze import Maze
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.map_source import tell_source
from twonav_cli.worker_pool import StoppedError, processors

if TYPE_CHECKING:
    from twonav_cli.terminal.reproduce_fig9 import Fig9Request

OF_RANDOM_MAZES, OF_A_SCENE = ("table5", "table6", "sensitivity"), ("table7", "table8", "fig8")
"""Which tables are about random mazes, and which about a scene's."""

COOLING = "per-goal"


@dataclass(frozen=True)
class ReproduceRequest:
    """Everything the command line says about tables to make; None is the default."""

    table: str
    repeats: int | None = None
    seed: int = 0
    discount: float | None = None
    mazes: int | None = None
    scene: str | None = None
    processes: int | None = None
    as_json: bool = False
    out: Path | None = None
    cooling: str | None = None
    map_from: str | None = None
    quick: bool = False
    images: int | None = None
    device: str | None = None
    networks: str | None = None
    only_finished: bool = False
    localizer: str | None = None
    base: str | None = None

    @property
    def of_transfer(self) -> bool:
        """Whether the table is about transfer."""
        return self.table in TRANSFER_TABLES

    @property
    def of_localizers(self) -> bool:
        """Whether the table is about localizers."""
        return self.table in LOCALIZER_TABLES

    @property
    def folder(self) -> Path:
        """Where the table goes."""
        return self.out or runs_dir() / "reproduce"

    def table_request(self, table: str) -> TableRequest:
        """Return what is asked of one table about learning."""
        repeats = default_repeats(table) if self.repeats is None else self.repeats
        mazes = MAZES if self.mazes is None else self.mazes
        cooling, scene = self.cooling or COOLING, self.scene or SCENE
        return TableRequest(table, repeats, self.seed, self.discount, mazes, scene, cooling, self.map_from)

    def localizer_request(self) -> LocalizerRequest:
        """Return what is asked of a table about localizers.

        Raises:
            TwonavError: Networks are asked for and none is named.
        """
        networks = tuple(name.strip() for name in (self.networks or "").split(",") if name.strip())
        if self.networks is not None and not networks:
            raise TwonavError("--networks names no network: name some, as in cnn-7,inception-9, or leave it out")
        device = self.device or "auto"
        return LocalizerRequest(
            self.table, self.seed, self.quick, self.images, device, self.scene, networks, self.map_from,
            self.only_finished,
        )  # fmt: skip

    def fig9_request(self) -> Fig9Request:
        """Return what is asked of Fig. 9.

        Raises:
            TwonavError: There is no network of the name that was given.
        """
        from twonav_cli.localizer.networks import network_spec
        from twonav_cli.terminal.reproduce_fig9 import Fig9Request

        if self.networks is not None:
            network_spec(self.networks)
        return Fig9Request(self.scene or SCENE, self.seed, self.networks, self.quick, self.map_from)

    def transfer_request(self) -> TransferRequest:
        """Return what is asked of a table about transfer."""
        agents = QUICK_AGENTS if self.quick else AGENTS
        return TransferRequest(
            self.table, agents if self.repeats is None else self.repeats, self.seed, self.scene or SCENE,
            self.localizer or "raw", self.base or "omni", processors() if self.processes is None else self.processes,
            self.quick, self.map_from,
            self.only_finished,
        )  # fmt: skip

    def check(self) -> None:
        """Refuse what cannot be, and what the table would not look at, before anything is made.

        Raises:
            TwonavError: Says what to leave out or to name instead.
        """
        names = tables_named(self.table)
        for option, given, users in self._options():
            if given and not any(name in users for name in names):
                raise TwonavError(f"{option} is for {', '.join(users)}: {self.table} does not use it, so leave it out")
        if self.of_localizers:
            self.localizer_request().check()
            return
        if self.of_transfer:
            self.transfer_request().check()
            return
        if self.table == WRONG_PLACES:
            self.fig9_request()
            return
        tables = [self.table_request(name) for name in names]
        for table in tables:
            table.check()
        if len(tables) > 1 and (self.scene is not None or self.map_from is not None):
            tables[0].scene_maze()  # else it would be missed only after the tables before
        if self.processes is not None and self.processes < 1:
            raise TwonavError(f"--processes must be at least 1: {self.processes} was given")

    def _options(self) -> list[tuple[str, bool, tuple[str, ...]]]:
        """Return every option that not all tables use, whether it was given, and the tables that do."""
        learning, slow = tuple(TABLES), (*LOCALIZER_TABLES, *TRANSFER_TABLES)
        with_scene = (*LOCALIZER_TABLES, *OF_A_SCENE, *TRANSFER_TABLES, WRONG_PLACES)
        return [
            ("--mazes", self.mazes is not None, OF_RANDOM_MAZES),
            ("--scene", self.scene is not None, with_scene),
            ("--map-from", self.map_from is not None, with_scene),
            ("--repeats", self.repeats is not None, (*learning, *TRANSFER_TABLES)),
            ("--discount", self.discount is not None, learning),
            ("--cooling", self.cooling is not None, learning),
            ("--processes", self.processes is not None, (*learning, *TRANSFER_TABLES)),
            ("--quick", self.quick, (*slow, WRONG_PLACES)),
            ("--images", self.images is not None, LOCALIZER_TABLES),
            ("--device", self.device is not None, LOCALIZER_TABLES),
            ("--networks", self.networks is not None, (*LOCALIZER_TABLES, WRONG_PLACES)),
            ("--only-finished", self.only_finished, slow),
            ("--localizer", self.localizer is not None, TRANSFER_TABLES),
            ("--base", self.base is not None, TRANSFER_TABLES),
        ]


def run_reproduce(request: ReproduceRequest) -> int:
    """Make, print and write the tables; returns 0, or 130 when interrupted (what is finished is kept)."""
    request.check()
    folder = writable(request.folder)
    if request.of_localizers:
        from twonav_cli.terminal.reproduce_localizers import run_localizers

        return run_localizers(request.localizer_request(), folder, request.as_json)
    if request.table == WRONG_PLACES:
        from twonav_cli.terminal.reproduce_fig9 import run_fig9

        return run_fig9(request.fig9_request(), folder, request.as_json)
    if request.of_transfer:
        from twonav_cli.terminal.reproduce_transfer import run_transfer

        return run_transfer(request.transfer_request(), folder, request.as_json)
    return _run_tables(request, folder)


def _run_tables(request: ReproduceRequest, folder: Path) -> int:
    """Make, print and write tables about learning."""
    wanted = [request.table_request(name) for name in tables_named(request.table)]
    processes = request.processes or processors()
    reports: dict[str, Any] = {}
    kept = "tables that are finished are kept" if len(wanted) > 1 else "nothing is kept"
    with StopOnInterrupt(f"stopping: {kept}") as stop:
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
    if any(table.table in OF_A_SCENE for table in wanted):
        scene = request.scene or SCENE
        tell_source(read_floor(scene, request.map_from), scene, request.map_from)
    if request.as_json:
        print(json.dumps(reports if request.table == EVERY_TABLE else reports[request.table], allow_nan=False))
    return 0


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
