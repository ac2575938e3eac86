"""The camera in characters."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.terminal.screen.halfblocks import image_picture, image_text, resized
from twonav_cli.terminal.screen.picture import HALF_BLOCK


def test_the_upper_pixel_is_ink_and_the_lower_one_paper() -> None:
    image = np.zeros((2, 1, 3), dtype=np.uint8)
    image[0], image[1] = (250, 0, 0), (0, 0, 250)
    picture = image_picture(image, 1, 1)
    assert picture.glyphs[0, 0] == HALF_BLOCK
    assert picture.ink[0, 0].tolist() == [250, 0, 0]
    assert picture.paper[0, 0].tolist() == [0, 0, 250]


@pytest.mark.parametrize(("rows", "cols"), [(21, 42), (13, 26), (50, 100), (1, 1)])
def test_any_size_can_be_asked_for(rows: int, cols: int) -> None:
    image = np.random.default_rng(0).integers(0, 256, (84, 84, 3), dtype=np.uint8)
    lines = image_text(image, rows, cols).plain.split("\n")
    assert [len(line) for line in lines] == [cols] * rows


def test_a_smaller_image_has_the_mean_of_the_area() -> None:
    image = np.zeros((4, 4, 3), dtype=np.uint8)
    image[:2, :2] = 200
    image[0, 3] = 100
    assert resized(image, 2, 2)[..., 0].tolist() == [[200, 25], [0, 0]]


def test_without_colour_dark_is_blank_and_light_is_dense() -> None:
    image = np.zeros((84, 84, 3), dtype=np.uint8)
    image[:, 42:] = 255
    assert image_picture(image, 1, 4, coloured=False).text().plain == "  @@"
