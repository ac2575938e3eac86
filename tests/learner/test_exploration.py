"""Eq. 6 and epsilon-greedy."""

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.learner.exploration import (
    boltzmann_action,
    boltzmann_probabilities,
    epsilon_greedy_action,
    explored_action,
    greedy_action,
)


def test_boltzmann_weighs_actions_by_the_exponential_of_their_value() -> None:
    # exp(0), exp(1), exp(2), exp(3) at T = 2 for values 0, 2, 4, 6
    weights = np.exp([0.0, 1.0, 2.0, 3.0])
    assert np.allclose(boltzmann_probabilities(np.array([0.0, 2.0, 4.0, 6.0]), 2.0), weights / weights.sum())


def test_boltzmann_stays_finite_for_huge_values_and_tiny_temperatures() -> None:
    probabilities = boltzmann_probabilities(np.array([1e6, 1e6 - 1.0, -1e6, 1e6]), 1e-6)
    assert np.allclose(probabilities, [0.5, 0.0, 0.0, 0.5])


def test_boltzmann_draws_actions_as_often_as_their_probability_says() -> None:
    rng, values = np.random.default_rng(0), np.array([0.0, 2.0, 4.0, 6.0])
    drawn = np.bincount([boltzmann_action(values, 2.0, rng) for _ in range(20_000)], minlength=4) / 20_000
    assert np.abs(drawn - boltzmann_probabilities(values, 2.0)).max() < 0.015


def test_ties_are_broken_at_random() -> None:
    rng = np.random.default_rng(0)
    drawn = np.bincount([greedy_action(np.array([7.0, 1.0, 7.0, 7.0]), rng) for _ in range(3000)], minlength=4)
    assert drawn[1] == 0
    assert drawn[[0, 2, 3]].min() > 850


def test_epsilon_is_the_share_of_random_actions() -> None:
    rng = np.random.default_rng(0)
    values = np.array([0.0, 0.0, 1.0, 0.0])
    off = sum(epsilon_greedy_action(values, 0.4, rng) != 2 for _ in range(10_000)) / 10_000
    assert abs(off - 0.4 * 3 / 4) < 0.02
    assert all(epsilon_greedy_action(values, 0.0, rng) == 2 for _ in range(50))


def test_a_wrong_rule_is_answered_with_the_right_ones() -> None:
    with pytest.raises(TwonavError, match="boltzmann, epsilon-greedy"):
        explored_action("boltzman", np.zeros(4), 1.0, 0.1, np.random.default_rng(0))
