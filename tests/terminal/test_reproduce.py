"""`twonav reproduce` of the tables about mazes: a table, its files, one object for scripts, one line for mistakes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from made_up_runs import gave_up, made_up_run

from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.repeats import Item
from twonav_cli.experiments.tables.catalog import TABLES
from twonav_cli.experiments.tables.request import TableRequest
from twonav_cli.maze import Maze
from twonav_cli.random_maze import random_maze
from twonav_cli.terminal import app, console, reproduce
from twonav_cli.worker_pool import StoppedError


class Ended(NamedTuple):
    """How a command ended."""

    code: int
    out: str
    err: str


Run = Callable[..., Ended]

WITH_SCENE = "table3, table4, fig7, table7, table8, fig8, table9, table10, fig9"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Iterator[Run]:
    """Return a function that runs `twonav reproduce` here, with made-up runs, on a terminal of 80 columns."""
    before = signal.getsignal(signal.SIGTERM)
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path / "runs"))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setattr(reproduce, "make_runs", made_up)
    console.out.cache_clear()
    console.err.cache_clear()

    def run_command(*arguments: str | Path) -> Ended:
        monkeypatch.setattr(sys, "argv", ["twonav", "reproduce", *map(str, arguments)])
        capsys.readouterr()
        with pytest.raises(SystemExit) as ended:
            app.main()
        code = ended.value.code
        return Ended(code if isinstance(code, int) else 0, *capsys.readouterr())

    yield run_command
    signal.signal(signal.SIGTERM, before)
    console.out.cache_clear()
    console.err.cache_clear()


@pytest.fixture
def small_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put a random maze in place of the apartment's."""

    def scene_maze(request: TableRequest) -> Maze:
        return random_maze(0, 0)

    monkeypatch.setattr(TableRequest, "scene_maze", scene_maze)


def made_up(
    items: Sequence[Item],
    mazes: Sequence[Maze],
    seed: int,
    processes: int,
    should_stop: Callable[[], bool],
    on_run: Callable[[LearningRun], None],
) -> list[LearningRun]:
    runs = [made_up_run(item, mazes[item.maze]) for item in items]
    for one in runs:
        on_run(one)
    return runs


def only_object(ended: Ended) -> Any:
    """Return the one JSON object on standard output, which must hold no NaN."""

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    (line,) = ended.out.splitlines()
    return json.loads(line, parse_constant=refuse)


@pytest.mark.usefixtures("small_scene")
@pytest.mark.parametrize("name", TABLES)
def test_a_table_fits_80_columns_and_is_written_beside_its_picture(run: Run, tmp_path: Path, name: str) -> None:
    ended = run(name, "--repeats", "2", "--out", tmp_path / "out")
    assert ended.code == 0
    lines = ended.out.splitlines()
    assert max(len(line) for line in lines) <= 80
    assert lines[-1].startswith(f"twonav reproduce {name} --repeats 2 --seed 0")
    assert "IQM" in ended.out
    assert "…" not in ended.out
    for ending in ("json", "png"):
        assert str(tmp_path / "out" / f"{name}.{ending}") in ended.err.splitlines()
    assert {path.name for path in (tmp_path / "out").iterdir()} == {f"{name}.json", f"{name}.png"}
    assert json.loads((tmp_path / "out" / f"{name}.json").read_text())["table"] == name


def test_table_5_shows_the_papers_figures_errata_floor_excess_and_settings(run: Run) -> None:
    out = " ".join(run("table5", "--mazes", "2").out.split())
    for expected in ("201", "84", "(a) multi: Maze 5 prints 10k", "floor", "excess", "discount 0.99", "T 2", "Q0 80",
                     "trial limit 500", "replay period 500", "T cools per-goal", "50 successes in a row",
                     "2 random mazes, 10 repeats", "seed 0", "python ", "numba "):  # fmt: skip
        assert expected in out


def test_json_is_the_only_thing_on_standard_output_and_equals_the_file(run: Run, tmp_path: Path) -> None:
    ended = run("table5", "--repeats", "1", "--mazes", "1", "--json")
    report = only_object(ended)
    assert report == json.loads((tmp_path / "runs" / "reproduce" / "table5.json").read_text())
    assert {"table", "paper", "ours", "floor", "excess", "errata", "settings"} <= set(report)
    for row in (*report["ours"].values(), report["floor"], *report["excess"].values()):
        assert {"mean", "std", "iqm", "ci95"} <= set(row)
        assert len(row["ci95"]) == 2


@pytest.mark.usefixtures("small_scene")
def test_all_makes_every_table_into_one_object(run: Run) -> None:
    reports = only_object(run("all", "--mazes", "1", "--json"))
    assert list(reports) == list(TABLES)
    assert [report["settings"]["repeats"] for report in reports.values()] == [10, 10, 10, 10, 10, 3]


def test_more_mazes_than_columns_are_left_to_the_json(run: Run) -> None:
    ended = run("table5", "--repeats", "1", "--mazes", "11")
    assert max(map(len, ended.out.splitlines())) <= 80
    assert "multi, ours" not in ended.out


def test_runs_that_gave_up_are_named_and_have_no_mean(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    def with_one_given_up(items: Sequence[Item], mazes: Sequence[Maze], *rest: Any) -> list[LearningRun]:
        runs = made_up(items, mazes, *rest)
        return [gave_up(one) if one.learner == "single" else one for one in runs]

    monkeypatch.setattr(reproduce, "make_runs", with_one_given_up)
    out = run("table5", "--repeats", "2", "--mazes", "1").out
    assert "Gave up: single 2 of 2;" in out
    assert "nan" not in out
    assert "inf" not in out


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["tabel5"], "unknown table 'tabel5'; did you mean 'table5'? Known: table3, table4, fig7, table5, table6,"),
        (["table5", "--repeats", "0"], "--repeats must be at least 1: 0 was given"),
        (["table5", "--mazes", "0"], "--mazes must be at least 1: 0 was given"),
        (["table5", "--processes", "0"], "--processes must be at least 1: 0 was given"),
        (["table5", "--discount", "1.5"], "discount must be at least 0 and below 1: 1.5 was given"),
        (["all", "--discount", "nan"], "discount must be at least 0 and below 1: nan was given"),
        (["table7", "--scene", "nowhere"], "unknown scene 'nowhere'"),
        (["all", "--scene", "nowhere"], "unknown scene 'nowhere'"),
        (["all", "--mazes", "0"], "--mazes must be at least 1"),
        (["table5", "--scene", "nowhere"], f"--scene is for {WITH_SCENE}: table5 does not use it"),
        (["sensitivity", "--scene", "apartment"], f"--scene is for {WITH_SCENE}: sensitivity does not use it"),
        (["table5", "--quick"], "--quick is for table3, table4, fig7, table9, table10, fig9: table5 does not use it"),
        (["all", "--images", "5"], "--images is for table3, table4, fig7: all does not use it"),
        (["fig8", "--device", "cpu"], "--device is for table3, table4, fig7: fig8 does not use it"),
        (["table6", "--networks", "cnn-7"], "--networks is for table3, table4, fig7, fig9: table6 does not use it"),
        (
            ["all", "--only-finished"],
            "--only-finished is for table3, table4, fig7, table9, table10: all",
        ),
        (["table8", "--mazes", "3"], "--mazes is for table5, table6, sensitivity: table8 does not use it"),
    ],
)
def test_a_mistake_is_one_line(run: Run, arguments: list[str], complaint: str) -> None:
    ended = run(*arguments)
    assert (ended.code, ended.out) == (1, "")
    assert ended.err.startswith(f"error: {complaint}")
    assert len(ended.err.splitlines()) == 1


def test_a_seed_below_zero_is_wrong_usage(run: Run) -> None:
    assert run("table5", "--seed", "-1").code == 2


def test_a_folder_that_cannot_be_written_is_said_before_anything_runs(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def not_called(*_: Any) -> None:
        raise AssertionError("something was run")

    monkeypatch.setattr(reproduce, "make_runs", not_called)
    (tmp_path / "file").write_text("in the way")
    ended = run("table5", "--out", tmp_path / "file" / "out")
    assert ended.code == 1
    assert ended.err.startswith("error: cannot write into")
    assert len(ended.err.splitlines()) == 1


@pytest.mark.usefixtures("small_scene")
def test_stopping_keeps_what_is_finished_and_writes_nothing_of_the_rest(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made: list[int] = []

    def stopped_in_third(*arguments: Any) -> list[LearningRun]:
        made.append(1)
        if len(made) == 3:
            raise StoppedError
        return made_up(*arguments)

    monkeypatch.setattr(reproduce, "make_runs", stopped_in_third)
    ended = run("all", "--repeats", "1", "--mazes", "1", "--out", tmp_path / "out")
    assert ended.code == 130
    assert "nothing is written of table7" in ended.err
    files = {path.name for path in (tmp_path / "out").iterdir()}
    assert files == {"table5.json", "table5.png", "table6.json", "table6.png"}


def test_ctrl_c_ends_the_workers_and_leaves_no_trace(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "twonav_cli", "reproduce", "table5", "--repeats", "100", "--processes", "2"]
    terminal = subprocess.Popen(
        [*command, "--out", tmp_path / "out"], stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        start_new_session=True, env={**os.environ, "COLUMNS": "80"},
    )  # fmt: skip
    while not (tmp_path / "out").is_dir() and terminal.poll() is None:
        time.sleep(0.05)
    time.sleep(2.0)  # into the runs, wherever they are by then
    os.killpg(terminal.pid, signal.SIGINT)
    # It returns when nobody holds the other end any more, so no worker is left. The limit allows for compiling.
    out, err = terminal.communicate(timeout=180)
    assert (terminal.returncode, out) == (130, "")
    assert "Traceback" not in err
    assert "nothing is written of table5" in err
    assert list((tmp_path / "out").iterdir()) == []


@pytest.mark.usefixtures("small_scene")
@pytest.mark.parametrize(("scene", "said"), [("kitchen", True), ("apartment", False)])
@pytest.mark.parametrize("name", ["table7", "table8"])
def test_another_scene_is_not_the_papers_and_that_is_said(run: Run, name: str, scene: str, said: bool) -> None:
    out = run(name, "--repeats", "2", "--scene", scene).out
    assert ("the paper's figures are of its own apartment, with 10 goals" in out.splitlines()) == said


@pytest.mark.usefixtures("small_scene")
@pytest.mark.parametrize("name", TABLES)
def test_one_run_has_no_interval_and_is_drawn_all_the_same(run: Run, tmp_path: Path, name: str) -> None:
    ended = run(name, "--repeats", "1", "--out", tmp_path / "out")
    assert ended.code == 0
    report = json.loads((tmp_path / "out" / f"{name}.json").read_text())
    assert all(row["ci95"] == [None, None] for row in report["ours"].values())
    assert "None" not in ended.out
    assert "–" not in ended.out.replace("2011–", "")


def test_one_maze_and_one_repeat_are_singular(run: Run) -> None:
    assert "1 random maze, 1 repeat, seed 0" in " ".join(run("table5", "--mazes", "1", "--repeats", "1").out.split())


@pytest.mark.parametrize(
    ("table", "kept"),
    [("table5", "stopping: nothing is kept"), ("all", "stopping: tables that are finished are kept")],
)
def test_stopping_promises_what_it_keeps(run: Run, monkeypatch: pytest.MonkeyPatch, table: str, kept: str) -> None:
    def interrupted(*_: Any) -> list[LearningRun]:
        os.kill(os.getpid(), signal.SIGINT)
        raise StoppedError

    monkeypatch.setattr(reproduce, "make_runs", interrupted)
    ended = run(table, "--mazes", "1")
    assert ended.code == 130
    assert kept in ended.err
