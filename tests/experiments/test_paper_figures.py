"""The printed tables, and every erratum worked out anew from the printed numbers."""

from decimal import ROUND_HALF_UP, Decimal
from statistics import fmean

import pytest

from twonav_cli.experiments.paper_figures import (
    FASTER_PERCENT,
    FEWER_TRIALS_PERCENT,
    TABLE_5,
    TABLE_6,
    TABLE_7,
    TABLE_8,
    TD_ERROR_BETTER_PERCENT,
    PerGoal,
    PerMaze,
    errata_of,
    missing_value,
)


def rounded(values: tuple[float, ...], digits: int) -> float:
    """Return the mean as one prints it: a half is rounded up."""
    exact = sum(Decimal(str(value)) for value in values) / len(values)
    return float(exact.quantize(Decimal(1).scaleb(-digits), ROUND_HALF_UP))


def texts(table: str) -> str:
    return " ".join(erratum.text for erratum in errata_of(table))


@pytest.mark.parametrize("row", [TABLE_5["single"], *TABLE_6.values()])
def test_the_averages_of_tables_5_and_6_follow_from_their_rows_with_one_exception(row: PerMaze) -> None:
    assert rounded(row.thousands, 0) == row.average_thousands


def test_maze_5_of_table_5_contradicts_the_average_and_about_100k_does_not() -> None:
    row = TABLE_5["multi"]
    assert rounded(row.thousands, 0) == 75 != row.average_thousands
    with_100 = (*row.thousands[:4], 100, *row.thousands[5:])
    assert row.thousands[4] == 10
    assert rounded(with_100, 0) == row.average_thousands
    assert missing_value([*row.thousands[:4], *row.thousands[5:]], row.average_thousands) == 99
    assert "Maze 5 prints 10k" in texts("table5")
    assert "about 99k" in texts("table5")


def test_239_percent_is_a_ratio_of_averages() -> None:
    ratio = TABLE_5["single"].average_thousands / TABLE_5["multi"].average_thousands
    assert round(100 * ratio) == FASTER_PERCENT
    assert "2.39: 139 % faster" in texts("table5")


def test_9_percent_of_table_6_hold_for_the_rounded_averages_and_not_for_the_rows() -> None:
    random, td_error = TABLE_6[1.0, 0.0, "random"], TABLE_6[1.0, 0.0, "td-error"]
    assert round(100 * (1 - td_error.average_thousands / random.average_thousands)) == TD_ERROR_BETTER_PERCENT
    assert 100 * (1 - fmean(td_error.thousands) / fmean(random.thousands)) == pytest.approx(6.6, abs=0.05)
    assert "6.6 %" in texts("table6")
    assert "33.5k and 31.3k" in texts("table6")


@pytest.mark.parametrize("column", [TABLE_7["multi"], *TABLE_8.values()])
def test_the_averages_of_tables_7_and_8_follow_from_their_rows_with_one_exception(column: PerGoal) -> None:
    assert rounded(column.means, 1) == column.average_mean
    assert rounded(column.stds, 1) == column.average_std


def test_goal_10_of_table_7_repeats_an_average_that_the_rows_do_not_give() -> None:
    column = TABLE_7["single"]
    assert (column.means[-1], column.stds[-1]) == (column.average_mean, column.average_std)
    assert (rounded(column.means, 1), rounded(column.stds, 1)) == (99.0, 33.4)
    assert rounded((*column.means[:-1], 98.3), 1) == column.average_mean
    assert rounded((*column.stds[:-1], 20.0), 1) == column.average_std
    assert "average 99.0 and 33.4" in texts("table7")
    assert "need 98.3 and 20.0" in texts("table7")


def test_40_percent_less_trials_are_37() -> None:
    fewer = 100 * (1 - TABLE_7["multi"].average_mean / TABLE_7["single"].average_mean)
    assert round(fewer) == 37 != FEWER_TRIALS_PERCENT
    assert "37 %" in texts("table7")


def test_table_8_and_what_is_no_table_have_no_errata() -> None:
    assert errata_of("table8") == errata_of("fig8") == errata_of("sensitivity") == []


def test_every_printed_column_has_ten_figures() -> None:
    assert {len(row.thousands) for row in (*TABLE_5.values(), *TABLE_6.values())} == {10}
    assert {len(numbers) for c in (*TABLE_7.values(), *TABLE_8.values()) for numbers in (c.means, c.stds)} == {10}
