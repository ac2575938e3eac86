"""The sentence that says what a lost robot believed."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.events import Filtered
from twonav_cli.experiments.belief_evidence import belief_sentence, share_near
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.localizer.belief_filter import BeliefFilter, FilterConfig
from twonav_cli.stages.localize import STILL, FromEveryLook
from twonav_cli.stages.stage import Observation

TRUE, BELIEVED = Pose(5.0, 1.0, 0.0), Pose(1.0, 4.0, 0.0)


def belief(*places: tuple[float, float, float], lost: float = 0.1) -> Belief:
    """Weight, x_m, y_m of each place on a floor of 50 square metres."""
    rows = np.array([(*place, 0.1) for place in places])
    grid = np.zeros((1, 1), dtype=np.float32)
    return Belief(rows, np.array([(1.0, 0.0, 0.1)]), lost, 50.0, grid, GridFrame(0, 0, 9, 1, 1))


def seen(said: Belief | None, filtered: Filtered | None = None) -> Observation:
    return Observation(Cell(0, 0), Cell(1, 1), TRUE, BELIEVED, None, said, filtered)


def test_without_a_belief_nothing_is_said() -> None:
    assert belief_sentence(seen(None)) == ""


def test_a_true_place_that_was_thought_of_is_told_with_its_probability() -> None:
    sentence = belief_sentence(seen(belief((0.7, 1.0, 4.0), (0.2, 5.2, 1.1), (0.1, 9.0, 9.0))))
    assert sentence == (
        "It was 0.63 sure to be at (1.0, 4.0) m and gave the true place, (5.0, 1.0) m, 0.18; "
        "it named 2 other places, the true one among them."
    )


def test_a_true_place_that_was_not_thought_of_has_only_its_share_of_the_even_floor() -> None:
    said = belief((0.95, 1.0, 4.0), (0.05, 9.0, 9.0))
    assert share_near(said, None, TRUE) == pytest.approx(0.1 * np.pi * 0.45**2 / 50.0)
    assert "it named 1 other place, none of them the true one." in belief_sentence(seen(said))
    assert belief_sentence(seen(belief((1.0, 1.0, 4.0)))).endswith("it named no other place.")


def test_with_a_filter_its_own_belief_is_told_and_then_that_of_the_last_picture() -> None:
    particles = np.zeros((10, 3), dtype=np.float32)
    particles[:4, :2] = TRUE[:2]
    filtered = Filtered(0.6, 0.2, 0.1, particles, np.array([(0.4, 5.1, 1.0)]))
    assert belief_sentence(seen(belief((1.0, 5.0, 1.1)), filtered)) == (
        "It was 0.60 sure to be at (1.0, 4.0) m and gave the true place, (5.0, 1.0) m, 0.40; it named 1 other place, "
        "the true one among them. The last picture alone was 0.90 sure of (5.0, 1.1) m and gave the true place 0.90."
    )


def test_on_its_first_look_a_filter_gives_the_true_place_no_more_than_it_is_sure_of() -> None:
    said = belief((1.0, 5.0, 1.0), lost=0.6)
    localize = FromEveryLook(
        lambda image: said, BeliefFilter(FilterConfig(), OdometryNoise(), np.random.default_rng(0))
    )
    filtered = localize(np.zeros((84, 84, 3), dtype=np.uint8), STILL).filtered
    assert filtered is not None
    assert filtered.placed == pytest.approx(0.4)
    assert share_near(said, filtered, TRUE) == pytest.approx(filtered.probability, abs=0.02)
    assert "It was 0.40 sure" in belief_sentence(seen(said, filtered))
    assert "gave the true place, (5.0, 1.0) m, 0.40;" in belief_sentence(seen(said, filtered))
