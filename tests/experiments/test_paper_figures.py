"""The printed tables, and every erratum worked out anew from the printed numbers."""

from decimal import ROUND_HALF_UP, Decimal
from statistics import fmean

import pytest

from twonav_cli.experiments.paper_errata import errata_of, missing_value
from twonav_cli.experiments.paper_figures import (
    FASTER_PERCENT,
    FEWER_TRIALS_PERCENT,
    FIG_7,
    SIZES_M,
    TABLE_1,
    TABLE_2,
    TABLE_3,
    TABLE_4,
    TABLE_5,
    TABLE_6,
    TABLE_7,
    TABLE_8,
    TD_ERROR_BETTER_PERCENT,
    TEXT_ANGLE_STD_DEG,
    TEXT_POSITION_CM,
    TEXT_ROW_OF_FIG_6,
    TEXT_TIMES_LARGER,
    PerGoal,
    PerMaze,
)


def rounded(values: tuple[float, ...], digits: int) -> float:
    """Return the mean as one prints it: a half is rounded up."""
    exact = sum(Decimal(str(value)) for value in values) / len(values)
    return float(exact.quantize(Decimal(1).scaleb(-digits), ROUND_HALF_UP))


def texts(table: str) -> str:
    return " ".join(erratum.text for erratum in errata_of(table))


def test_table_1_prints_two_corruptions_for_one_layer() -> None:
    wrong = [row for row in TABLE_1 if len(row.corruption) != row.layers]
    assert [(row.layers, len(row.corruption)) for row in wrong] == [(1, 2), (1, 2)]
    assert all(len(row.units) == row.layers for row in TABLE_1)
    assert "Networks of 1 layer print 2 corruptions" in texts("table3")


def test_the_best_autoencoder_of_table_3_is_the_one_that_the_text_names() -> None:
    kitchen = {network: row for (scene, network), row in TABLE_3.items() if scene == "kitchen"}
    assert min(kitchen, key=lambda network: kitchen[network].pos_mean_m) == "sda-3x4000"
    assert min(kitchen, key=lambda network: kitchen[network].ang_mean_deg) == "sda-3x4000"


def test_centimetres_and_20_7_degrees_of_the_text_are_metres_and_2_07_degrees_in_table_4() -> None:
    best = TABLE_4["kitchen", "inception-9"]
    assert TEXT_POSITION_CM == (best.pos_mean_m, best.pos_std_m) == (0.056, 0.079)
    assert pytest.approx(10 * best.ang_std_deg) == TEXT_ANGLE_STD_DEG
    assert "0.056 cm and 0.079 cm are metres in the table: 5.6 cm and 7.9 cm" in texts("table4")
    assert "20.7 degrees of deviation are 2.07 in the table: 10 times as many" in texts("table4")


def test_rgb_is_superior_by_the_angle_and_not_by_the_position() -> None:
    networks = ("cnn-7", "cnn-9", "inception-9")
    rgb, hsv = ([TABLE_4["kitchen", name + ending] for name in networks] for ending in ("", "-hsv"))
    assert fmean(row.pos_mean_m for row in rgb) > fmean(row.pos_mean_m for row in hsv)
    assert fmean(row.ang_mean_deg for row in rgb) < fmean(row.ang_mean_deg for row in hsv)
    assert "5.3 against 5.8 degrees" in texts("table4")
    assert "0.0637 against 0.0633 m" in texts("table4")


def test_in_the_apartment_inception_is_best_by_the_position_only() -> None:
    rows = {network: row for (scene, network), row in TABLE_4.items() if scene == "apartment"}
    assert min(rows, key=lambda network: rows[network].pos_mean_m) == "inception-9"
    assert min(rows, key=lambda network: rows[network].ang_mean_deg) == "cnn-9"
    assert "3.1 against 3.8 degrees" in texts("table4")


def test_more_layers_are_better_in_the_apartment_and_worse_in_the_kitchen() -> None:
    def gain(scene: str) -> list[bool]:
        seven, nine = TABLE_4[scene, "cnn-7"], TABLE_4[scene, "cnn-9"]
        return [nine.pos_mean_m < seven.pos_mean_m, nine.ang_mean_deg < seven.ang_mean_deg]

    assert (gain("apartment"), gain("kitchen")) == ([True, True], [False, False])
    assert "9 layers err by 0.069 m and 6.1 degrees, 7 by 0.066 and 4.9" in texts("table4")


def test_the_apartment_is_more_than_twice_as_large() -> None:
    assert SIZES_M == {"kitchen": (7, 5), "apartment": (14, 9)}
    assert (14 * 9) / (7 * 5) == pytest.approx(3.6) != TEXT_TIMES_LARGER
    assert "3.6 times the area" in texts("table4")


def test_the_network_of_fig_6_is_in_another_place_of_another_table() -> None:
    assert [(row.layers, row.kind, row.pooling) for row in TABLE_2].index((9, "inception", False)) + 1 == 4
    assert TEXT_ROW_OF_FIG_6 == 3
    assert "number 4 of Table 2" in texts("table4")


def test_fig_7_contradicts_table_4_and_not_table_3() -> None:
    sda, cnn = FIG_7["apartment", "sda-3x4000"], FIG_7["apartment", "inception-9"]
    assert sda.min_m < TABLE_3["apartment", "sda-3x4000"].pos_mean_m < sda.max_m
    assert TABLE_4["apartment", "inception-9"].pos_mean_m < cnn.min_m
    (erratum,) = errata_of("fig7")
    assert erratum.row == "apartment inception-9"
    assert "between 0.12 and 0.56 m" in erratum.text
    assert "0.076 m" in erratum.text


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
