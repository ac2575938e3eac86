"""The paper's tables as printed, 1 to 8, with Fig. 7's ends and what the text says about them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class PerMaze:
    """A row of Table 5 or 6: thousand actions for each of the ten random mazes, and their printed average."""

    thousands: tuple[int, ...]
    average_thousands: int


@dataclass(frozen=True)
class PerGoal:
    """A column pair of Tables 7 to 10: mean and deviation for each goal in order of training, and their averages."""

    means: tuple[float, ...]
    stds: tuple[float, ...]
    average_mean: float
    average_std: float


class PoseErrors(NamedTuple):
    """A row of Table 3 or 4: mean and deviation of the position's and the heading's error."""

    pos_mean_m: float
    pos_std_m: float
    ang_mean_deg: float
    ang_std_deg: float


class Extremes(NamedTuple):
    """The ends of a colour scale of Fig. 7: the smallest and the largest mean error of a cell."""

    min_m: float
    max_m: float


class Autoencoder(NamedTuple):
    """A row of Table 1: units and corruption of each layer."""

    layers: int
    units: tuple[int, ...]
    corruption: tuple[float, ...]


class Convolutional(NamedTuple):
    """A row of Table 2."""

    layers: int
    kind: str
    pooling: bool


TABLE_1: tuple[Autoencoder, ...] = (
    Autoencoder(1, (4000,), (0.2, 0.2)),
    Autoencoder(1, (1500,), (0.2, 0.2)),
    Autoencoder(2, (4000, 4000), (0.2, 0.2)),
    Autoencoder(2, (1500, 1500), (0.2, 0.2)),
    Autoencoder(3, (4000, 4000, 4000), (0.2, 0.2, 0.2)),
    Autoencoder(3, (1500, 1500, 1500), (0.2, 0.2, 0.2)),
)

TABLE_2: tuple[Convolutional, ...] = (
    Convolutional(7, "convolution", False),
    Convolutional(7, "inception", True),
    Convolutional(9, "convolution", False),
    Convolutional(9, "inception", False),
    Convolutional(9, "inception", True),
)

TABLE_3: dict[tuple[str, str], PoseErrors] = {
    ("kitchen", "sda-1x1500"): PoseErrors(0.218, 0.213, 12.6, 14.0),
    ("kitchen", "sda-1x4000"): PoseErrors(0.217, 0.207, 12.8, 13.6),
    ("kitchen", "sda-2x1500"): PoseErrors(0.204, 0.221, 11.6, 13.7),
    ("kitchen", "sda-2x4000"): PoseErrors(0.193, 0.205, 11.3, 12.8),
    ("kitchen", "sda-3x1500"): PoseErrors(0.198, 0.214, 11.6, 13.9),
    ("kitchen", "sda-3x4000"): PoseErrors(0.182, 0.205, 10.7, 12.5),
    ("apartment", "sda-3x4000"): PoseErrors(0.560, 0.869, 28.8, 48.9),
}
"""Scene and network to the errors of the stacked denoising autoencoders."""

TABLE_4: dict[tuple[str, str], PoseErrors] = {
    ("kitchen", "cnn-7"): PoseErrors(0.066, 0.087, 4.9, 1.96),
    ("kitchen", "cnn-9"): PoseErrors(0.069, 0.101, 6.1, 2.59),
    ("kitchen", "inception-9"): PoseErrors(0.056, 0.079, 4.9, 2.07),
    ("kitchen", "cnn-7-hsv"): PoseErrors(0.065, 0.086, 6.1, 2.46),
    ("kitchen", "cnn-9-hsv"): PoseErrors(0.069, 0.101, 6.2, 2.60),
    ("kitchen", "inception-9-hsv"): PoseErrors(0.056, 0.080, 5.1, 2.10),
    ("apartment", "cnn-7"): PoseErrors(0.156, 0.190, 3.9, 2.67),
    ("apartment", "cnn-9"): PoseErrors(0.113, 0.125, 3.1, 2.21),
    ("apartment", "inception-9"): PoseErrors(0.076, 0.067, 3.8, 1.63),
    ("apartment", "inception-pool-7"): PoseErrors(0.324, 0.087, 5.6, 1.94),
    ("apartment", "inception-pool-9"): PoseErrors(0.276, 0.174, 4.5, 2.51),
}
"""Scene and network to the errors of the convolutional networks."""

FIG_7: dict[tuple[str, str], Extremes] = {
    ("apartment", "sda-3x4000"): Extremes(0.43, 1.6),
    ("apartment", "inception-9"): Extremes(0.12, 0.56),
}
"""Scene and network, "the best SDA" and "the best CNN", to what its captions say is green and red."""

EPOCHS = 10_000
"""§4.2.1: how long each network is trained; the one with the lowest validation error is kept."""

TEXT_POSITION_CM = (0.056, 0.079)
"""§4.4.1 about the inception network in the kitchen: "0.056 cm position error ... with 0.079 cm ... deviation"."""

TEXT_ANGLE_STD_DEG = 20.7
"""§4.4.1 about the same network: "20.7 degrees standard deviation"."""

TEXT_TIMES_LARGER = 2
"""§4.4.1 about the apartment beside the kitchen: "the size of the room is doubled"."""

TEXT_ROW_OF_FIG_6 = 3
"""§4.2.2: Fig. 6, whose caption says nine layers with inception, is "the third architecture from Table 1"."""

SIZES_M = {"kitchen": (7, 5), "apartment": (14, 9)}
"""Captions of Figs. 3 and 4."""

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

TABLE_9: dict[str, PerGoal] = {
    "2d": PerGoal(
        (35.3, 42.4, 19.7, 25.2, 33.7, 23.8, 22.1, 27.6, 19.2, 21.2),
        (7.3, 7.8, 2.6, 6.4, 7.9, 4.0, 4.2, 6.3, 4.4, 2.1),
        27.0,
        5.30,
    ),
    "3d": PerGoal(
        (43.6, 73.4, 28.0, 46.7, 44.5, 28.9, 26.6, 43.0, 27.7, 29.0),
        (10.3, 16.3, 4.6, 15.7, 11.1, 5.0, 5.3, 12.5, 9.4, 3.7),
        39.1,
        9.4,
    ),
}
"""Actions to each goal from every start, after learning."""

TABLE_10: dict[str, PerGoal] = {
    "trials": PerGoal(
        (6849.6, 376.6, 181.1, 141.8, 432.0, 142.4, 153.1, 473.1, 3141.5, 160.4),
        (5154.0, 253.2, 104.5, 1.8, 60.0, 5.6, 15.8, 181.5, 5343.4, 23.9),
        1205.2,
        1114.4,
    ),
    "actions": PerGoal(
        (74.8, 87.9, 46.9, 24.0, 144.4, 21.3, 33.8, 189.7, 131.1, 372.7),
        (8.4, 40.3, 63.5, 3.8, 45.2, 6.4, 5.8, 31.6, 60.9, 26.1),
        80.1,
        29.2,
    ),
}
"""Trials until each goal is learned in 3D without transfer, and actions to it afterwards."""

TABLE_10_NOT_REACHED = (0, 3, 1, 0, 4, 1, 1, 1, 3, 0)
"""How many of the ten agents had not learned each goal after 14 thousand trials."""

FASTER_PERCENT = 239
"""§4.4.2 about Table 5: "a 239% faster convergence time"."""

TD_ERROR_BETTER_PERCENT = 9
"""§4.4.2 about Table 6 at T = 1: TD-error selection is "on average 9 percent better" than random."""

FEWER_TRIALS_PERCENT = 40
"""Caption of Table 7: "requires 40 percent less trials"."""
