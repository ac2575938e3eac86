"""Fig. 9: which looks are kept, and what is said about them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from twonav_cli.experiments.wrong_places import look_around
from twonav_cli.geometry import Pose
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.stages.localize import Image, Located

HERE = np.array([(1.0, 1.0, 0.0), (1.2, 1.0, 0.0), (3.0, 2.0, 1.0), (4.5, 3.0, -1.0)])
OFF_M = {1.0: 2.0, 1.2: 1.5, 3.0: 0.2, 4.5: 0.8}
"""How far the made-up localizer errs, by where the robot stands."""


@pytest.fixture
def floor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Floor:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    return read_floor("kitchen")


class Mistaken:
    """A localizer that errs as the table says; the picture's first pixel tells it where it is."""

    def __call__(self, image: Image, motion: Pose) -> Located:
        x_m = image[0, 0, 0] / 10
        return Located(Pose(x_m + OFF_M[x_m], 1.0 if x_m < 2 else float(HERE[HERE[:, 0] == x_m][0, 1]), 0.0))

    def forget(self) -> None:
        pass

    def draw_from(self, rng: np.random.Generator) -> None:
        pass


def picture(pose: Pose) -> Image:
    return np.full((84, 84, 3), round(10 * pose.x_m), dtype=np.uint8)


def test_the_worst_looks_are_shown_far_from_each_other_and_all_that_are_wrong_are_counted(floor: Floor) -> None:
    looks = list[int]()
    found = look_around(floor, HERE, picture, Mistaken(), 6, lambda: looks.append(1))
    assert (found.looks, len(looks)) == (4, 4)
    assert found.errors_m == pytest.approx([2.0, 1.5, 0.2, 0.8])
    assert found.wrong.shape == (3, 2, 3)
    assert [round(place.error_m, 3) for place in found.shown] == [2.0, 0.8]  # the second stands beside the first
    assert found.shown[0].image[0, 0, 0] == 10
    assert "2.00 m off" in found.shown[0].sentence
    assert found.shown[0].figures()["true"] == [1.0, 1.0, 0.0]


def test_no_more_are_shown_than_were_asked_for(floor: Floor) -> None:
    assert len(look_around(floor, HERE, picture, Mistaken(), 1).shown) == 1
    assert look_around(floor, HERE[2:3], picture, Mistaken(), 6).shown == []
