"""Interquartile mean, its bootstrap interval, and runs without a figure."""

import json
from statistics import stdev

import numpy as np
import pytest

from twonav_cli.experiments.statistics import (
    RESAMPLES,
    bootstrap_interval,
    interquartile_mean,
    means_of,
    summary_of,
)
from twonav_cli.rng import stream


@pytest.mark.parametrize(
    ("values", "expected"),
    [
        ([7.0], 7.0),
        ([1.0, 5.0], 3.0),
        ([1.0, 2.0, 90.0], 31.0),
        ([100.0, 2.0, 4.0, -50.0], 3.0),
        ([0.0, 0.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 900.0, 900.0], 5.5),
    ],
)
def test_the_interquartile_mean_leaves_out_a_quarter_at_each_end_rounded_down(
    values: list[float], expected: float
) -> None:
    assert interquartile_mean(values) == expected


def test_the_interquartile_mean_is_scipys_trimmed_mean() -> None:
    from scipy.stats import trim_mean

    rng = np.random.default_rng(3)
    for size in (5, 10, 33, 100):
        values = rng.exponential(size=size)
        assert interquartile_mean(values) == pytest.approx(trim_mean(values, 0.25))


def test_one_run_has_neither_deviation_nor_interval() -> None:
    summary = summary_of([[42.0]], seed=0)
    assert (summary.mean, summary.std, summary.iqm, summary.ci95) == (42.0, None, 42.0, (None, None))


def test_the_deviation_is_that_of_a_sample() -> None:
    values = [3.0, 5.0, 10.0]
    assert summary_of(values, seed=0).std == pytest.approx(stdev(values), abs=1e-4)


def test_mazes_that_differ_but_whose_runs_are_equal_have_an_interval_without_width() -> None:
    """Resampling over all runs would mix the mazes, and say that something is uncertain."""
    table = np.array([[10.0] * 5, [20.0] * 5, [90.0] * 5])
    assert bootstrap_interval(table, stream(0, "bootstrap")) == (interquartile_mean(table),) * 2


def test_the_same_seed_gives_the_same_interval_and_another_seed_another() -> None:
    table = np.random.default_rng(1).normal(size=(4, 10))
    intervals = [bootstrap_interval(table, stream(seed, "bootstrap")) for seed in (5, 5, 6)]
    assert intervals[0] == intervals[1] != intervals[2]


def test_the_interval_holds_the_true_value_in_about_95_of_100_samples() -> None:
    rng = np.random.default_rng(0)
    held = 0
    for trial in range(300):
        low, high = bootstrap_interval(rng.normal(7.0, 2.0, size=(1, 30)), stream(trial, "bootstrap"), resamples=400)
        held += low <= 7.0 <= high
    assert 0.88 <= held / 300 <= 0.98


def test_the_resamples_are_all_drawn_when_they_come_in_blocks(monkeypatch: pytest.MonkeyPatch) -> None:
    table = np.random.default_rng(1).normal(size=(2, 8))
    whole = bootstrap_interval(table, stream(0, "bootstrap"))
    monkeypatch.setattr("twonav_cli.experiments.statistics.BLOCK_VALUES", 16 * RESAMPLES // 7)
    assert bootstrap_interval(table, stream(0, "bootstrap")) == whole


def test_a_run_that_gave_up_takes_the_mean_away_and_counts_as_the_longest_in_the_interquartile_mean() -> None:
    learned = [[10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0, 17.0]]
    summary = summary_of([[*learned[0][:-1], np.inf]], seed=0)
    assert (summary.mean, summary.std) == (None, None)
    assert (summary.runs, summary.gave_up) == (8, 1)
    assert summary.iqm == summary_of(learned, seed=0).iqm == 13.5
    assert summary.ci95[0] is not None


def test_more_than_a_quarter_given_up_leaves_no_figure_at_all() -> None:
    summary = summary_of([[10.0, 11.0, np.inf, np.inf]], seed=0)
    assert (summary.iqm, summary.ci95[1]) == (None, None)
    assert json.loads(json.dumps(summary.report(), allow_nan=False))["gave_up"] == 2


def test_the_mean_of_a_maze_is_missing_only_where_a_run_gave_up() -> None:
    assert means_of([[1.0, 3.0], [np.inf, 5.0]]) == [2.0, None]
