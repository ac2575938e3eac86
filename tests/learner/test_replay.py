"""The replay buffer and its sweep."""

import copy

import numpy as np

from twonav_cli.config import LearningConfig
from twonav_cli.grid import Cell
from twonav_cli.learner.replay import Experience, Replay, sweep

A, B, C = Cell(0, 0), Cell(0, 1), Cell(0, 2)
GOALS = [C]


def corridor() -> Replay:
    replay = Replay()
    replay.add(Experience(A, 3, B, False))
    replay.add(Experience(B, 3, C, False))
    return replay


def swept(replay: Replay, config: LearningConfig, times: int = 1, seed: int = 0) -> np.ndarray:
    q = np.full((1, 3, 4, 1), 10.0)
    for _ in range(times):
        sweep(q, replay, GOALS, config, np.random.default_rng(seed))
    return q


def test_a_sweep_uses_the_values_from_before_it() -> None:
    q = swept(corridor(), LearningConfig(learning_rate=1.0, discount=0.5))
    assert q[0, 1, 3, 0] == 100.0
    assert q[0, 0, 3, 0] == -0.1 + 0.5 * 10.0


def test_a_second_sweep_carries_the_reward_one_cell_further() -> None:
    q = swept(corridor(), LearningConfig(learning_rate=1.0, discount=0.5), times=2)
    assert np.isclose(q[0, 0, 3, 0], -0.1 + 0.5 * 100.0)
    assert (q[0, :, :3, 0] == 10.0).all()


def test_an_experience_made_twice_is_swept_twice() -> None:
    replay = corridor()
    replay.add(Experience(B, 3, C, False))
    q = swept(replay, LearningConfig(learning_rate=0.5))
    assert len(replay) == 3
    assert q[0, 1, 3, 0] == 10.0 + 0.5 * 90.0 + 0.5 * 45.0


def test_a_sweep_may_have_a_rate_of_its_own() -> None:
    q = swept(corridor(), LearningConfig(learning_rate=0.8, replay_learning_rate=0.1))
    assert q[0, 1, 3, 0] == 10.0 + 0.1 * 90.0
    assert LearningConfig(learning_rate=0.8).sweep_rate == 0.8


def test_contradicting_experiences_are_swept_in_an_order_that_the_seed_decides() -> None:
    replay = corridor()
    replay.add(Experience(B, 3, B, True))
    config = LearningConfig(learning_rate=0.5)
    found = {float(swept(replay, config, seed=seed)[0, 1, 3, 0]) for seed in range(20)}
    assert len(found) == 2
    assert swept(replay, config, seed=4).tolist() == swept(replay, config, seed=4).tolist()


def test_the_size_of_a_mini_batch_does_not_change_the_sweep() -> None:
    replay = corridor()
    replay.add(Experience(B, 3, B, True), times=9)
    small, large = (swept(replay, LearningConfig(learning_rate=0.1, replay_batch=n)) for n in (2, 1000))
    assert small.tolist() == large.tolist()


def test_a_buffer_survives_being_written_as_an_array() -> None:
    replay = corridor()
    replay.add(Experience(B, 3, B, True), times=4)
    again = Replay.from_array(replay.to_array())
    assert list(again.counts.items()) == list(replay.counts.items())
    assert Replay.from_array(Replay().to_array()).counts == {}


def test_an_array_holds_what_was_added_since_the_last_one() -> None:
    replay = corridor()
    first = replay.to_array()
    replay.add(Experience(B, 3, C, False))
    replay.add(Experience(B, 3, B, True))
    assert first[:, -1].tolist() == [1, 1]
    assert replay.to_array().tolist() == [[0, 0, 3, 0, 1, 0, 1], [0, 1, 3, 0, 2, 0, 2], [0, 1, 3, 0, 1, 1, 1]]


def test_a_copy_grows_on_its_own() -> None:
    replay = corridor()
    replay.to_array()
    copied = copy.deepcopy(replay)
    copied.add(Experience(B, 3, B, True))
    replay.add(Experience(A, 3, B, False))
    assert replay.to_array()[:, -1].tolist() == [2, 1]
    assert copied.to_array()[:, -1].tolist() == [1, 1, 1]


def test_a_buffer_is_filled_from_another_where_it_knows_nothing() -> None:
    here, there = Cell(0, 0), Cell(0, 1)
    nearer, further = Replay(), Replay()
    nearer.add(Experience(here, 3, here, True), times=2)
    further.add(Experience(here, 3, there, False))
    further.add(Experience(there, 2, here, False), times=4)
    filled = nearer.filled_from(further)
    assert filled.counts == {Experience(here, 3, here, True): 2, Experience(there, 2, here, False): 4}
    assert filled.to_array().shape == (2, 7)
    assert len(nearer) == 2
