"""The pictures: small PNG files of a page's width, the same for the same report, drawn without a display."""

import ast
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from made_up_runs import make_up, make_up_where

import twonav_cli.plotting
from twonav_cli.experiments.tables.catalog import TABLES
from twonav_cli.experiments.tables.report import Report
from twonav_cli.experiments.tables.request import TableRequest
from twonav_cli.maze import Maze
from twonav_cli.plotting.fig8_plot import draw_fig8
from twonav_cli.plotting.pictures import PICTURES, picture_of
from twonav_cli.plotting.sensitivity_plot import draw_sensitivity
from twonav_cli.plotting.step_table_plot import draw_step_table
from twonav_cli.plotting.style import LOOKS, in_thousands, look_of
from twonav_cli.random_maze import random_maze

PNG = b"\x89PNG\r\n\x1a\n"
BYTES_AT_MOST = 150_000
WIDTH_PX = 882


@pytest.fixture(autouse=True)
def no_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fig. 8 shows agents that are there: none of the developer's."""
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path / "runs"))


@pytest.fixture(autouse=True)
def _no_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    def scene_maze(request: TableRequest) -> Maze:
        return random_maze(0, 0)

    monkeypatch.setattr(TableRequest, "scene_maze", scene_maze)


def report_of(name: str, make: Callable[..., list] = make_up) -> Report:  # type: ignore[type-arg]
    return TABLES[name](TableRequest(name, repeats=3, mazes=2), make)


def size_of(png: bytes) -> tuple[int, int]:
    return int.from_bytes(png[16:20], "big"), int.from_bytes(png[20:24], "big")


@pytest.mark.parametrize("name", TABLES)
def test_every_table_has_a_small_picture_of_a_pages_width(name: str) -> None:
    png = picture_of(report_of(name))
    assert png.startswith(PNG)
    assert len(png) < BYTES_AT_MOST
    width, height = size_of(png)
    assert width == WIDTH_PX
    assert 200 < height < 800


def test_every_table_has_a_picture() -> None:
    assert list(PICTURES) == list(TABLES)


def test_the_same_report_gives_the_same_bytes() -> None:
    report = report_of("table6")
    assert picture_of(report) == picture_of(report)


@pytest.mark.parametrize("name", TABLES)
@pytest.mark.parametrize("share", [1, 2])
def test_a_table_of_runs_that_gave_up_is_drawn_too(name: str, share: int) -> None:
    report = report_of(name, make_up_where(lambda item: item.repeat % share == 0))
    assert picture_of(report).startswith(PNG)


def test_the_sweeps_picture_has_four_panels_with_the_papers_figures_as_dashed_lines() -> None:
    figure = draw_sensitivity(report_of("sensitivity"))
    assert len(figure.axes) == 4
    for axes in figure.axes:
        dashed = {float(np.asarray(line.get_ydata())[0]) for line in axes.lines if line.get_linestyle() == "--"}
        assert dashed == {201_000.0, 84_000.0}


def test_the_sweeps_picture_says_where_runs_gave_up() -> None:
    made = make_up_where(lambda item: item.config.discount == 0.8 and item.repeat == 0)
    panel = draw_sensitivity(report_of("sensitivity", made)).axes[0]
    assert [text.get_text() for text in panel.texts] == ["33 % gave up"] * 2


def test_fig_8_has_a_panel_for_each_learner_and_a_mark_for_each_goal() -> None:
    figure = draw_fig8(report_of("fig8"))
    assert [axes.get_title(loc="left")[:3] for axes in figure.axes] == ["(a)", "(b)"]
    for axes in figure.axes:
        assert [text.get_text() for text in axes.texts] == [str(number) for number in range(1, 11)]
        assert axes.get_yscale() == "log"


def test_fig_8_has_a_panel_more_for_each_stage_whose_agents_are_there() -> None:
    report = report_of("fig8")
    curve = report.ours["multi"]["curve"]
    report.settings["stages"] = {name: {"agents": 3, "curve": curve} for name in ("2d", "from-nothing")}
    titles = [axes.get_title(loc="left") for axes in draw_fig8(report).axes]
    assert [title[:3] for title in titles] == ["(a)", "(b)", "(c)", "(e)"]
    assert "from nothing" in titles[-1]


def test_table_5_has_a_row_for_each_learner_and_the_papers_marks() -> None:
    report = report_of("table5")
    (axes,) = draw_step_table(report).axes
    assert [label.get_text() for label in axes.get_yticklabels()] == list(report.ours)
    crosses = [float(np.asarray(line.get_xdata())[0]) for line in axes.lines if line.get_marker() == "x"]
    assert crosses == [201_000, 84_000]


@pytest.mark.parametrize("name", TABLES)
def test_no_two_methods_of_a_table_look_alike(name: str) -> None:
    methods = {method.split()[0] for method in report_of(name).ours}
    looks = [look_of(method) for method in methods]
    assert len({look.colour for look in looks}) == len({look.marker for look in looks}) == len(methods)


def test_red_and_green_are_never_all_that_tells_two_lines_apart() -> None:
    """Every colour is one of Okabe and Ito's."""
    okabe_ito = {"#E69F00", "#56B4E9", "#009E73", "#F0E442", "#0072B2", "#D55E00", "#CC79A7"}
    assert {look.colour for look in LOOKS.values()} <= okabe_ito


def test_an_axis_counts_in_thousands() -> None:
    assert [in_thousands(value) for value in (0, 1500, 200_000)] == ["0", "1.5k", "200k"]


def test_nothing_uses_pyplot_whose_state_is_shared() -> None:
    for path in Path(twonav_cli.plotting.__file__).parent.glob("*.py"):
        assert not re.search("pyplot|pylab", ast.unparse(ast.parse(path.read_text()))), path
