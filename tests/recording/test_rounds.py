from __future__ import annotations

import numpy as np

from twonav_cli.events import Clock, TrialBatch
from twonav_cli.recording.rounds import Rounds


def batch(first: int, steps: list[int], goal: int = 0) -> TrialBatch:
    n = len(steps)
    taken = np.array(steps, dtype=np.int64)
    return TrialBatch(
        Clock(first + n - 1, 0), np.full(n, goal), np.zeros(n, np.int64), taken, np.ones(n, np.bool_),
        np.full(n, 5), np.zeros((n, 2)), np.arange(n) + 10 * first,
    )  # fmt: skip


def test_a_round_is_a_trial_from_each_start_also_across_two_batches() -> None:
    rounds = Rounds(3)
    moments, means = rounds.add(batch(1, [3, 4]))
    assert len(moments) == len(means) == 0
    moments, means = rounds.add(batch(3, [8, 10, 20, 30, 40]))
    assert moments.tolist() == [[3, 30], [6, 33]]
    assert means.tolist() == [[5.0, 5.0], [20.0, 5.0]]


def test_a_new_goal_begins_a_new_round() -> None:
    rounds = Rounds(2)
    rounds.add(batch(1, [100]))
    _, means = rounds.add(batch(2, [6, 8], goal=1))
    assert means.tolist() == [[7.0, 5.0]]
