"""Tables 5 and 6, and the sweep: what goes into every row, from runs with known numbers, and once from real ones."""

import json
from dataclasses import asdict
from functools import partial

import numpy as np
import pytest
from made_up_runs import make_up, make_up_where

from twonav_cli.experiments.learning_run import shortest_ways
from twonav_cli.experiments.repeats import Item, make_runs
from twonav_cli.experiments.tables.method_runs import run_methods
from twonav_cli.experiments.tables.request import TableRequest
from twonav_cli.experiments.tables.sensitivity import SWEEPS, sensitivity
from twonav_cli.experiments.tables.table5 import table5
from twonav_cli.experiments.tables.table6 import table6
from twonav_cli.learner.learners import LEARNERS, learner_settings
from twonav_cli.random_maze import random_maze

REQUEST = TableRequest("table5", repeats=3, mazes=2)
STEPS_OF_A_ROUND = 10 * sum(30 + rank for rank in range(10))
"""Of a made-up run of ten goals and ten starts."""


def test_table_5_has_every_learner_with_total_floor_and_excess() -> None:
    report = table5(REQUEST, make_up)
    assert list(report.ours) == list(report.excess) == list(LEARNERS)
    totals = [STEPS_OF_A_ROUND * (60 + repeat) for repeat in range(3)]
    floors = [50 * int(shortest_ways(maze).sum()) for maze in REQUEST.random_mazes()]
    for row in report.ours.values():
        assert row["mean"] == np.mean(totals)
        assert row["per_maze"] == [np.mean(totals)] * 2
        assert row["std"] == pytest.approx(np.std(totals * 2, ddof=1), abs=1e-3)
        assert row["optimal_at"]["mean"] == 1001.0
        assert row["ci95"][0] <= row["iqm"] <= row["ci95"][1]
    assert report.floor["mean"] == np.mean(floors)
    assert report.excess["multi"]["mean"] == np.mean(totals) - np.mean(floors)


def test_table_5_stands_beside_the_papers_figures_in_actions() -> None:
    report = table5(REQUEST, make_up)
    assert report.paper["single"]["mean"] == 201_000
    assert report.paper["multi"]["per_maze"][4] == 10_000
    assert {erratum["row"] for erratum in report.errata} == {"multi"}


def test_the_settings_say_what_decides_the_table_and_what_differs() -> None:
    settings = table5(REQUEST, make_up).settings
    expected = {
        "discount": 0.99, "temperature": 2.0, "initial_q": 80.0, "trial_limit_steps": 500, "replay_period_steps": 500,
        "consecutive_successes": 50, "max_step_difference": 10.0, "mazes": 2, "repeats": 3, "seed": 0,
    }  # fmt: skip
    assert {name: settings[name] for name in expected} == expected
    assert settings["methods"]["multi"] == {}
    assert settings["methods"]["single"] == {"learner": "single"}
    assert settings["methods"]["optimistic"]["discount"] == 0.95
    assert set(settings["versions"]) == {"python", "twonav", "numpy", "numba"}
    assert settings["command"].startswith("twonav reproduce table5")


def test_a_run_that_gave_up_takes_its_mazes_and_its_methods_mean_away_and_no_others() -> None:
    def given_up(item: Item) -> bool:
        return item.config.learner == "single" and item.maze == 1 and item.repeat == 2

    report = table5(REQUEST, make_up_where(given_up))
    single = report.ours["single"]
    assert (single["mean"], single["gave_up"], single["runs"]) == (None, 1, 6)
    assert single["iqm"] is not None
    assert single["per_maze"][0] is not None
    assert single["per_maze"][1] is None
    assert single["optimal_at"]["gave_up"] == 1
    assert report.excess["single"]["mean"] is None
    assert report.floor["mean"] is not None
    assert report.ours["multi"]["gave_up"] == 0
    json.dumps(asdict(report), allow_nan=False)


def test_table_6_has_three_selections_from_both_starting_values_under_the_relaxed_criterion() -> None:
    asked: list[Item] = []

    def make(items, mazes):  # type: ignore[no-untyped-def]  # as `make_up`
        asked.extend(items)
        return make_up(items, mazes)

    report = table6(TableRequest("table6", repeats=2, mazes=1), make)
    rows = ["random T=1 Q0=0", "td-error T=1 Q0=0", "sequential T=1 Q0=0"]
    rows += [row.replace("T=1 Q0=0", "T=2 Q0=80") for row in rows]
    assert list(report.ours) == rows
    assert list(report.paper) == [row for row in rows if "sequential" not in row]
    configs = {item.config for item in asked}
    assert {config.consecutive_successes for config in configs} == {15}
    assert {(c.temperature, c.initial_q, c.goal_selection) for c in configs} == {
        (t, q, rule) for t, q in ((1.0, 0.0), (2.0, 80.0)) for rule in ("random", "td-error", "sequential")
    }
    assert report.errata[0]["row"] in rows


def test_the_sweep_changes_one_setting_at_a_time_and_runs_the_preset_once() -> None:
    asked: list[Item] = []

    def make(items, mazes):  # type: ignore[no-untyped-def]  # as `make_up`
        asked.extend(items)
        return make_up(items, mazes)

    report = sensitivity(TableRequest("sensitivity", repeats=1, mazes=1), make)
    preset = {name: learner_settings(name) for name in ("single", "multi")}
    for item in asked:
        of_preset = preset[item.config.learner]
        assert sum(getattr(item.config, name) != getattr(of_preset, name) for name in vars(of_preset)) <= 1
    points = sum(len(values) for values in SWEEPS.values())
    assert len(asked) == 2 * (points - len(SWEEPS) + 1)
    for figures in report.ours.values():
        assert {name: [p["value"] for p in found] for name, found in figures["sweeps"].items()} == {
            name: list(values) for name, values in SWEEPS.items()
        }
    assert (report.paper["single"]["mean"], report.paper["multi"]["mean"]) == (201_000, 84_000)


def test_the_sweep_says_which_share_gave_up_at_each_value() -> None:
    def given_up(item: Item) -> bool:
        return item.config.temperature == 4.0 and item.config.learner == "multi" and item.repeat == 0

    report = sensitivity(TableRequest("sensitivity", repeats=4, mazes=1), make_up_where(given_up))
    sweep = report.ours["multi"]["sweeps"]["temperature"]
    assert [point["gave_up_share"] for point in sweep] == [0.0, 0.0, 0.0, 0.25]
    assert [point["mean"] is None for point in sweep] == [False, False, False, True]
    assert sweep[3]["iqm"] is not None
    assert report.excess["multi"]["gave_up"] == 0


def test_methods_of_equal_settings_share_their_runs() -> None:
    config, maze = learner_settings("multi"), random_maze(0, 0)
    asked: list[Item] = []

    def make(items, mazes):  # type: ignore[no-untyped-def]  # as `make_up`
        asked.extend(items)
        return make_up(items, mazes)

    runs = run_methods({"a": config, "b": learner_settings("single"), "c": config}, [maze], 2, make)
    assert len(asked) == 4
    assert runs["a"] is runs["c"]
    assert [[run.learner for run in row] for row in runs["b"]] == [["single", "single"]]


def test_a_real_table_is_the_same_on_one_and_on_two_processors() -> None:
    request = TableRequest("table6", repeats=2, seed=1, mazes=1)
    tables = [table6(request, partial(make_runs, seed=1, processes=processes)) for processes in (1, 2)]
    assert asdict(tables[0]) == asdict(tables[1])
    assert tables[0].floor["mean"] < tables[0].ours["td-error T=2 Q0=80"]["mean"] < 200_000
