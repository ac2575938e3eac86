"""The slips in the paper's tables, each worked out from the printed numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

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
    TABLE_10,
    TD_ERROR_BETTER_PERCENT,
    TEXT_ANGLE_STD_DEG,
    TEXT_POSITION_CM,
    TEXT_ROW_OF_FIG_6,
    TEXT_TIMES_LARGER,
    Convolutional,
)


@dataclass(frozen=True)
class Erratum:
    """A printed figure that the other printed figures contradict.

    Attributes:
        row: The row of our table that it belongs to, or what else of the paper it is about.
        text: What is printed, and what the other figures say.
    """

    row: str
    text: str


def mean(values: Sequence[float]) -> float:
    """Return the mean of printed figures."""
    return sum(values) / len(values)


def missing_value(others: Sequence[float], average: float) -> float:
    """Return the one figure that, with the others, gives the printed average."""
    return average * (len(others) + 1) - sum(others)


def errata_of(table: str) -> list[Erratum]:
    """Return the slips in what the paper prints about a table or figure by name; none for another name."""
    found = {
        "table3": _errata_3, "table4": _errata_4, "fig7": _errata_fig_7,
        "table5": _errata_5, "table6": _errata_6, "table7": _errata_7, "table10": _errata_10,
    }  # fmt: skip
    return found.get(table, list)()


def _errata_3() -> list[Erratum]:
    wrong = {row.layers for row in TABLE_1 if len(row.corruption) != row.layers}
    given = {len(row.corruption) for row in TABLE_1 if row.layers in wrong}
    return [
        Erratum(
            "Table 1",
            f"Networks of {_listed(wrong)} layer print {_listed(given)} corruptions; one for each layer is meant.",
        )
    ]


def _errata_4() -> list[Erratum]:
    return [*_errata_of_the_best(), *_errata_of_what_is_better(), *_errata_of_size_and_figure()]


def _errata_of_the_best() -> list[Erratum]:
    best = TABLE_4["kitchen", "inception-9"]
    mean_cm, std_cm = TEXT_POSITION_CM
    return [
        Erratum(
            "kitchen inception-9",
            f"The text's {mean_cm} cm and {std_cm} cm are metres in the table: {100 * best.pos_mean_m:.1f} cm and "
            f"{100 * best.pos_std_m:.1f} cm.",
        ),
        Erratum(
            "kitchen inception-9",
            f"The text's {TEXT_ANGLE_STD_DEG} degrees of deviation are {best.ang_std_deg} in the table: "
            f"{TEXT_ANGLE_STD_DEG / best.ang_std_deg:.0f} times as many.",
        ),
    ]


def _errata_of_what_is_better() -> list[Erratum]:
    networks = ("cnn-7", "cnn-9", "inception-9")
    rgb = [TABLE_4["kitchen", name] for name in networks]
    hsv = [TABLE_4["kitchen", f"{name}-hsv"] for name in networks]
    plain, inception = TABLE_4["apartment", "cnn-9"], TABLE_4["apartment", "inception-9"]
    seven, nine = TABLE_4["kitchen", "cnn-7"], TABLE_4["kitchen", "cnn-9"]
    return [
        Erratum(
            "kitchen cnn-7-hsv",
            f'The text\'s "RGB ... slightly superior" holds for the angle ({mean([r.ang_mean_deg for r in rgb]):.1f} '
            f"against {mean([r.ang_mean_deg for r in hsv]):.1f} degrees on average), not for the position "
            f"({mean([r.pos_mean_m for r in rgb]):.4f} against {mean([r.pos_mean_m for r in hsv]):.4f} m).",
        ),
        Erratum(
            "apartment inception-9",
            f'The text\'s "best results ... in both rooms" holds for the position; 9 layers without inception have the '
            f"smaller angular error in the apartment, {plain.ang_mean_deg} against {inception.ang_mean_deg} degrees.",
        ),
        Erratum(
            "kitchen cnn-9",
            f'The text\'s "more layers ... better" holds in the apartment; in the kitchen 9 layers err by '
            f"{nine.pos_mean_m} m and {nine.ang_mean_deg} degrees, 7 by {seven.pos_mean_m} and {seven.ang_mean_deg}.",
        ),
    ]


def _errata_of_size_and_figure() -> list[Erratum]:
    (width, depth), (wide, deep) = SIZES_M["kitchen"], SIZES_M["apartment"]
    drawn = TABLE_2.index(Convolutional(9, "inception", pooling=False)) + 1
    return [
        Erratum(
            "apartment",
            f"The text's room of {TEXT_TIMES_LARGER} times the size, {wide} x {deep} m, has "
            f"{wide * deep / (width * depth):.1f} times the area of {width} x {depth} m.",
        ),
        Erratum(
            "Fig. 6",
            f'The text\'s "architecture {TEXT_ROW_OF_FIG_6} from Table 1", nine layers with inception, is number '
            f"{drawn} of Table 2.",
        ),
    ]


def _errata_fig_7() -> list[Erratum]:
    found = []
    for (scene, network), ends in FIG_7.items():
        overall_m = (TABLE_3 | TABLE_4)[scene, network].pos_mean_m
        if not ends.min_m <= overall_m <= ends.max_m:
            found.append(
                Erratum(
                    f"{scene} {network}",
                    f"The cells' means lie between {ends.min_m} and {ends.max_m} m, so the mean over all frames does "
                    f"too; the table prints {overall_m} m for the same network.",
                )
            )
    return found


def _errata_5() -> list[Erratum]:
    row = TABLE_5["multi"]
    printed = min(row.thousands)
    number = row.thousands.index(printed) + 1
    others = [value for value in row.thousands if value != printed]
    needed = missing_value(others, row.average_thousands)
    ratio = TABLE_5["single"].average_thousands / row.average_thousands
    return [
        Erratum(
            "multi",
            f"Maze {number} prints {printed}k; the printed average of {row.average_thousands}k needs about "
            f"{needed:.0f}k, so 100k is meant.",
        ),
        Erratum(
            "multi",
            f'The text\'s "{FASTER_PERCENT}% faster" is the ratio of the averages, {ratio:.2f}: '
            f"{100 * (ratio - 1):.0f} % faster.",
        ),
    ]


def _errata_6() -> list[Erratum]:
    random, td_error = TABLE_6[1.0, 0.0, "random"], TABLE_6[1.0, 0.0, "td-error"]
    rounded = 1 - td_error.average_thousands / random.average_thousands
    exact = 1 - mean(td_error.thousands) / mean(random.thousands)
    return [
        Erratum(
            "td-error T=1 Q0=0",
            f'The text\'s "{TD_ERROR_BETTER_PERCENT} percent better" comes from the rounded averages '
            f"({100 * rounded:.1f} %); the rows average {mean(random.thousands):.1f}k and "
            f"{mean(td_error.thousands):.1f}k, which is {100 * exact:.1f} %.",
        )
    ]


def _errata_7() -> list[Erratum]:
    single, multi = TABLE_7["single"], TABLE_7["multi"]
    goals = len(single.means)
    fewer = 100 * (1 - multi.average_mean / single.average_mean)
    return [
        Erratum(
            "single",
            f"Goal {goals} repeats the average row ({single.average_mean}, {single.average_std}); the rows as printed "
            f"average {mean(single.means):.1f} and {mean(single.stds):.1f}, and the printed averages need "
            f"{missing_value(single.means[:-1], single.average_mean):.1f} and "
            f"{missing_value(single.stds[:-1], single.average_std):.1f} for goal {goals}.",
        ),
        Erratum(
            "multi",
            f'The caption\'s "{FEWER_TRIALS_PERCENT} percent less trials" is {fewer:.0f} % by the printed averages.',
        ),
    ]


def _listed(numbers: set[int]) -> str:
    return ", ".join(str(number) for number in sorted(numbers))


def _errata_10() -> list[Erratum]:
    printed = TABLE_10["actions"]
    found = mean(printed.means)
    text = f"{printed.average_mean} is printed for the actions, but its ten goals average {found:.1f}"
    return [Erratum("Average", text)] if abs(found - printed.average_mean) > 0.05 else []
