"""Random numbers and drawn actions of the compiled loops."""

import numpy as np
import pytest

from twonav_cli.learner.draws import boltzmann, epsilon_greedy, first_state, greedy, gumbel_noise, uniform
from twonav_cli.learner.exploration import boltzmann_probabilities

DRAWS = 200_000


def states(seed: int) -> np.ndarray:
    return np.array([seed], dtype=np.uint64)


def test_random_numbers_are_uniform() -> None:
    state = np.array([first_state(0)], dtype=np.uint64)
    drawn = np.array([uniform(state) for _ in range(20_000)])
    assert 0 <= drawn.min() < drawn.max() < 1
    assert np.abs(np.histogram(drawn, 10, (0, 1))[0] / 20_000 - 0.1).max() < 0.01


@pytest.mark.parametrize("temperature", [0.5, 2.0, 5.0])
@pytest.mark.parametrize("values", [(0.0, 2.0, 4.0, 6.0), (80.0, 80.0, 80.0, 80.0), (-3.0, 9.5, 9.0, 9.5)])
def test_compiled_boltzmann_draws_by_the_probabilities_of_eq_6(values: tuple[float, ...], temperature: float) -> None:
    q, state = np.array(values).reshape(1, 4, 1), states(99)
    noise, per_temperature = gumbel_noise(), 1.0 / temperature
    drawn = np.bincount([boltzmann(q, 0, 0, per_temperature, noise, state) for _ in range(DRAWS)], minlength=4) / DRAWS
    expected = boltzmann_probabilities(np.array(values), temperature)
    assert np.abs(drawn - expected).max() < 4 * np.sqrt(0.25 / DRAWS)


def test_a_cold_boltzmann_agent_is_greedy() -> None:
    q, state = np.array([7.0, 7.0 - 1e-4, 3.0, 6.9]).reshape(1, 4, 1), states(7)
    assert {int(boltzmann(q, 0, 0, 1e6, gumbel_noise(), state)) for _ in range(500)} == {0}


def test_epsilon_greedy_takes_any_action_with_probability_epsilon() -> None:
    q, state = np.array([1.0, 9.0, 3.0, 5.0]).reshape(1, 4, 1), states(5)
    drawn = np.bincount([epsilon_greedy(q, 0, 0, 0.2, state) for _ in range(20_000)], minlength=4) / 20_000
    assert np.abs(drawn - np.array([0.05, 0.85, 0.05, 0.05])).max() < 0.01


def test_compiled_greedy_breaks_ties_evenly() -> None:
    q, state = np.array([7.0, 1.0, 7.0, 7.0]).reshape(1, 4, 1), np.array([99], dtype=np.uint64)
    drawn = np.bincount([greedy(q, 0, 0, state) for _ in range(6000)], minlength=4)
    assert drawn[1] == 0
    assert drawn[[0, 2, 3]].min() > 1800
