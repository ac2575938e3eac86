"""One seed, named streams."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.rng import stream


def draws(seed: int, name: str, *indices: int) -> NDArray[np.float64]:
    return stream(seed, name, *indices).random(4)


def test_the_same_name_and_seed_draw_the_same() -> None:
    assert np.array_equal(draws(3, "explore", 1), draws(3, "explore", 1))


def test_another_seed_name_or_index_draws_something_else() -> None:
    drawn = [
        draws(3, "explore"),
        draws(4, "explore"),
        draws(3, "replay"),
        draws(3, "explore", 2),
        draws(3, "explore", 1),
    ]
    assert len({tuple(row) for row in drawn}) == len(drawn)


def test_drawing_more_from_one_stream_changes_no_other() -> None:
    untouched = draws(7, "odometry")
    explore = stream(7, "explore")
    explore.random(1000)
    assert np.array_equal(draws(7, "odometry"), untouched)


def test_a_negative_seed_is_a_seed() -> None:
    assert not np.array_equal(draws(-1, "explore"), draws(1, "explore"))
