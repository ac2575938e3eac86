import numpy as np
import pytest

from twonav_cli.navigation.distance import distances_m


@pytest.mark.parametrize("share", [0.002, 0.05, 0.5])
def test_distances_are_those_of_brute_force(share):
    occupied = np.random.default_rng(4).random((31, 47)) < share
    occupied[11, 5] = True
    rows, cols = np.mgrid[:31, :47]
    marks = np.argwhere(occupied)
    brute = np.min(np.hypot(rows[..., None] - marks[:, 0], cols[..., None] - marks[:, 1]), axis=-1)
    assert distances_m(occupied, 0.05) == pytest.approx(0.05 * brute)


def test_without_marks_everything_is_far():
    assert distances_m(np.zeros((8, 8), dtype=bool), 0.05).min() >= 16 * 0.05
