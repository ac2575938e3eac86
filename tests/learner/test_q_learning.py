"""Eq. 1 to 3 against cases worked out by hand."""

import numpy as np

from twonav_cli.learner.q_learning import squared_td_errors, td_targets, updated_q, updated_q_of_goals


def test_a_single_update_moves_the_value_half_way_to_its_target() -> None:
    # target = -0.1 + 0.9 * 20 = 17.9; 10 + 0.5 * (17.9 - 10) = 13.95
    assert np.isclose(updated_q(10.0, -0.1, np.array([3.0, 20.0, -7.0, 5.0]), 0.5, 0.9), 13.95)


def test_targets_take_the_best_next_action_of_each_goal() -> None:
    next_values = np.array([[1.0, 40.0], [2.0, 30.0], [3.0, 20.0], [4.0, 10.0]])  # (A, G)
    targets = td_targets(np.array([-2.0, -0.1]), next_values, np.array([False, False]), 0.5)
    assert np.allclose(targets, [-2.0 + 0.5 * 4.0, -0.1 + 0.5 * 40.0])


def test_reaching_a_goal_ends_only_that_goals_episode() -> None:
    targets = td_targets(np.array([100.0, -0.1]), np.full((4, 2), 60.0), np.array([True, False]), 0.5)
    assert np.allclose(targets, [100.0, 29.9])


def test_all_goals_move_toward_their_own_targets() -> None:
    assert np.allclose(updated_q_of_goals(np.array([0.0, 10.0]), np.array([8.0, -10.0]), 0.25), [2.0, 5.0])


def test_the_td_error_is_the_square_of_the_distance_to_the_target() -> None:
    assert np.allclose(squared_td_errors(np.array([1.0, 5.0]), np.array([4.0, 3.0])), [9.0, 4.0])


def test_one_goal_of_the_multi_goal_update_equals_the_single_goal_update_bit_for_bit() -> None:
    rng = np.random.default_rng(3)
    for _ in range(500):
        q, reward, next_values = rng.normal(scale=50), rng.normal(scale=10), rng.normal(scale=50, size=(4, 1))
        rate, discount = rng.random(), rng.random()
        targets = td_targets(np.array([reward]), next_values, np.array([False]), discount)
        multi = updated_q_of_goals(np.array([q]), targets, rate)[0]
        assert multi == updated_q(q, reward, next_values[:, 0], rate, discount)
