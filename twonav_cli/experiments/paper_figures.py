"""The paper's Tables 5 to 8 as printed, and the slips in them, each worked out from the printed numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Erratum:
    """A printed figure that the other printed figures contradict.

    Attributes:
        row: The row of our table that it belongs to.
        text: What is printed, and what the other figures say.
    """

    row: str
    text: str


@dataclass(frozen=True)
class PerMaze:
    """A row of Table 5 or 6: thousand actions for each of the ten random mazes, and their printed average."""

    thousands: tuple[int, ...]
    average_thousands: int


@dataclass(frozen=True)
class PerGoal:
    """A column pair of Table 7 or 8: mean and deviation for each goal in order of training, and their averages."""

    means: tuple[float, ...]
    stds: tuple[float, ...]
    average_mean: float
    average_std: float


TABLE_5: dict[str, PerMaze] = {
    "single": PerMaze((184, 209, 204, 185, 255, 212, 186, 172, 203, 201), 201),
    "multi": PerMaze((76, 82, 90, 73, 10, 91, 83, 75, 78, 93), 84),
}
"""Actions until every goal is learned."""

TABLE_6: dict[tuple[float, float, str], PerMaze] = {
    (1.0, 0.0, "random"): PerMaze((23, 31, 28, 27, 46, 29, 32, 52, 38, 29), 34),
    (1.0, 0.0, "td-error"): PerMaze((23, 30, 23, 26, 43, 28, 31, 41, 40, 28), 31),
    (2.0, 80.0, "random"): PerMaze((26, 39, 31, 27, 26, 33, 26, 50, 26, 31), 32),
    (2.0, 80.0, "td-error"): PerMaze((33, 41, 29, 27, 28, 31, 21, 47, 28, 34), 32),
}
"""Starting temperature, first Q value and goal selection to the actions, under the relaxed criterion."""

TABLE_7: dict[str, PerGoal] = {
    "single": PerGoal(
        (112.1, 123.2, 89.6, 87.2, 107.2, 99.7, 87.3, 88.4, 96.0, 98.9),
        (50.8, 62.9, 16.4, 28.2, 49.8, 22.6, 17.8, 31.6, 21.9, 32.2),
        98.9,
        32.2,
    ),
    "multi": PerGoal(
        (112.6, 107.7, 50.0, 50.1, 50.4, 51.3, 50.7, 51.0, 52.4, 50.1),
        (50.6, 48.6, 0.0, 0.1, 0.3, 0.9, 0.5, 0.7, 1.6, 0.1),
        62.6,
        10.3,
    ),
}
"""Trials from each start until a goal is learned; 50 is the least that the criterion allows."""

TABLE_8: dict[str, PerGoal] = {
    "single": PerGoal(
        (115.0, 103.5, 55.2, 68.0, 79.7, 65.5, 56.0, 75.0, 53.4, 59.0),
        (73.4, 59.7, 15.7, 37.9, 49.0, 23.7, 17.9, 44.2, 18.3, 16.3),
        73.0,
        35.6,
    ),
    "multi": PerGoal(
        (117.5, 54.7, 26.6, 17.1, 17.4, 20.8, 16.8, 18.1, 20.3, 17.7),
        (2.8, 5.0, 0.1, 3.2, 2.4, 5.4, 4.1, 2.9, 4.2, 5.9),
        32.7,
        3.6,
    ),
    "multi-random": PerGoal(
        (120.6, 28.3, 19.8, 21.9, 17.7, 24.3, 18.9, 22.7, 24.6, 23.0),
        (20.7, 13.7, 7.6, 7.8, 3.4, 11.4, 7.6, 5.8, 11.2, 9.8),
        32.2,
        9.9,
    ),
}
"""Actions of a trial; the second and third are with goals selected by TD error and at random."""

FASTER_PERCENT = 239
"""§4.4.2 about Table 5: "a 239% faster convergence time"."""

TD_ERROR_BETTER_PERCENT = 9
"""§4.4.2 about Table 6 at T = 1: TD-error selection is "on average 9 percent better" than random."""

FEWER_TRIALS_PERCENT = 40
"""Caption of Table 7: "requires 40 percent less trials"."""


def mean(values: Sequence[float]) -> float:
    """Return the mean of printed figures."""
    return sum(values) / len(values)


def missing_value(others: Sequence[float], average: float) -> float:
    """Return the one figure that, with the others, gives the printed average."""
    return average * (len(others) + 1) - sum(others)


def errata_of(table: str) -> list[Erratum]:
    """Return the slips in what the paper prints about a table ("table5" to "table8"); none for another name."""
    return {"table5": _errata_5, "table6": _errata_6, "table7": _errata_7}.get(table, list)()


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
