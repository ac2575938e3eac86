"""Tables 7 and 8 and Fig. 8: figures by order of training, from runs with known numbers."""

import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from made_up_runs import gave_up, made_up_run, make_up, make_up_where

from twonav_cli.experiments.learning_run import shortest_ways
from twonav_cli.experiments.repeats import Item
from twonav_cli.experiments.tables.fig8 import curve_of, fig8, point_edges
from twonav_cli.experiments.tables.method_runs import EXPLORERS
from twonav_cli.experiments.tables.request import TableRequest
from twonav_cli.experiments.tables.table7 import table7
from twonav_cli.experiments.tables.table8 import table8
from twonav_cli.learner.learners import LEARNERS, learner_settings
from twonav_cli.maze import Maze
from twonav_cli.random_maze import random_maze

MAZE = random_maze(0, 0)


@pytest.fixture(autouse=True)
def no_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fig. 8 shows agents that are there: none of the developer's."""
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path / "runs"))


@pytest.fixture(autouse=True)
def _no_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    def scene_maze(request: TableRequest) -> Maze:
        return MAZE

    monkeypatch.setattr(TableRequest, "scene_maze", scene_maze)


def test_the_apartment_is_the_scene_by_default(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.undo()
    maze = TableRequest("table7").scene_maze()
    assert (maze.rows, maze.cols, len(maze.goals), len(maze.starts)) == (24, 47, 10, 10)


def test_table_7_counts_trials_from_each_start_for_every_learner() -> None:
    report = table7(TableRequest("table7", repeats=3), make_up)
    assert list(report.ours) == list(LEARNERS)
    for row in report.ours.values():
        assert [goal["mean"] for goal in row["goals"]] == [61.0] * 10
        assert [goal["std"] for goal in row["goals"]] == [1.0] * 10
        assert (row["mean"], row["std_of_goals"]) == (61.0, 1.0)
    assert report.floor["iqm"] == 50.0
    assert report.excess["multi"]["mean"] == 11.0
    assert report.paper["multi"]["goals"][2] == {"mean": 50.0, "std": 0.0}
    assert report.settings["scene"] == "apartment"


def test_table_8_counts_the_actions_of_a_trial_by_order_of_training() -> None:
    report = table8(TableRequest("table8", repeats=2), make_up)
    assert list(report.paper) == ["single", "multi", "multi-random"]
    assert list(report.ours) == [*report.paper, *EXPLORERS]
    assert [goal["mean"] for goal in report.ours["single"]["goals"]] == [30.0 + rank for rank in range(10)]
    shortest = shortest_ways(MAZE).mean()
    assert report.floor["mean"] == pytest.approx(shortest, abs=1e-4)
    assert report.excess["single"]["mean"] == pytest.approx(34.5 - shortest, abs=1e-4)
    assert report.settings["methods"]["multi-random"] == {"goal_selection": "random"}


@pytest.mark.parametrize("table", [table7, table8, fig8])
def test_a_method_of_which_every_run_gave_up_has_no_figures_and_valid_json(table) -> None:  # type: ignore[no-untyped-def]
    def given_up(item: Item) -> bool:
        return item.config.learner == "single"

    report = table(TableRequest("table7", repeats=2), make_up_where(given_up))
    assert report.ours["single"]["iqm"] is None
    assert report.ours["single"]["gave_up"] == 2
    assert report.ours["multi"]["iqm"] is not None
    json.dumps(asdict(report), allow_nan=False)


def test_one_run_that_gave_up_takes_the_goals_means_away() -> None:
    report = table7(TableRequest("table7", repeats=4), make_up_where(lambda item: item.repeat == 0))
    assert [goal["mean"] for goal in report.ours["multi"]["goals"]] == [None] * 10
    assert report.ours["multi"]["goals"][0]["iqm"] is not None
    assert report.ours["multi"]["std_of_goals"] is None


def test_fig_8_has_a_curve_for_each_panel_and_says_what_is_missing() -> None:
    report = fig8(TableRequest("fig8", repeats=3), make_up)
    for method in ("single", "multi"):
        curve = report.ours[method]["curve"]
        assert curve["goal_starts"] == [610 * rank for rank in range(10)]
        assert len(curve["trials"]) == len(curve["mean"]) == len(curve["q25"]) == len(curve["q75"])
        assert (np.diff(curve["trials"]) > 0).all()
        assert curve["mean"][0] == 30.0
        assert curve["mean"][-1] == 39.0
        assert curve["shortest"] == [round(ways, 4) for ways in shortest_ways(MAZE).mean(axis=1)[::-1]]
    assert "(c) to (e)" in report.settings["panels"]


def test_a_curve_is_the_mean_over_the_repeats_between_the_quartiles() -> None:
    config = learner_settings("multi")
    runs = [made_up_run(Item(config, 0, 0), MAZE, trial_steps=steps) for steps in (10, 20, 60)]
    curve = curve_of(runs, starts=10)
    assert (curve["mean"][0], curve["q25"][0], curve["q75"][0]) == (30.0, 15.0, 40.0)


def test_a_goals_stretch_is_as_long_as_in_the_median_repeat() -> None:
    config = learner_settings("multi")
    runs = [made_up_run(Item(config, 0, 0), MAZE, rounds=rounds, trial_steps=rounds) for rounds in (12, 20, 50)]
    curve = curve_of(runs, starts=10)
    assert curve["goal_starts"][1] == 200
    in_first = [mean for trial, mean in zip(curve["trials"], curve["mean"], strict=True) if trial < 200]
    assert in_first[0] == pytest.approx((12 + 20 + 50) / 3, abs=1e-4)
    assert in_first[-1] == 35.0, "the shortest repeat has nothing to say about the last rounds"


def test_a_curve_of_no_run_is_empty() -> None:
    assert set(map(len, curve_of([], starts=10).values())) == {0}


@pytest.mark.parametrize(
    ("length", "edges"),
    [(0, []), (3, [0, 1, 2, 3]), (10, [*range(11)]), (12, [*range(11), 12]), (20, [*range(11), 15, 20])],
)
def test_the_first_rounds_stand_alone_and_later_ones_in_groups(length: int, edges: list[int]) -> None:
    assert point_edges(length) == edges


def test_runs_that_gave_up_are_not_in_the_curve() -> None:
    config = learner_settings("multi")
    run = made_up_run(Item(config, 0, 0), MAZE)
    assert not gave_up(run).learned
    report = fig8(TableRequest("fig8", repeats=2), make_up_where(lambda item: item.repeat == 1))
    assert report.ours["multi"]["curve"]["goal_starts"][1] == 600
