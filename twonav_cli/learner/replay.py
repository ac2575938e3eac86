"""The replay buffer: every experience of the agent, swept again from time to time (§3.1.1).

Equal experiences are kept once with their number, so the buffer stays small however long a run is. The rewards are not
stored: they follow from the cells, for every goal. N experiences, D different ones, A actions, G goals.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import LearningConfig
from twonav_cli.grid import Cell
from twonav_cli.learner.goals import goals_at, rewards_of_goals
from twonav_cli.learner.q_learning import td_targets

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

ROW_LENGTH = 7
"""cell row, cell col, action, next row, next col, blocked, number."""


class Experience(NamedTuple):
    """One action and what came of it."""

    cell: Cell
    action: int
    next_cell: Cell
    blocked: bool


class Replay:
    """Every experience, in the order of first appearance, with the number of times it was made."""

    def __init__(self) -> None:
        self.counts: dict[Experience, int] = {}
        self._rows: IntArray = np.zeros((0, ROW_LENGTH - 1), dtype=np.int64)
        """What `to_array` has turned into numbers so far, in the order of `counts`, where nothing is ever taken out."""

    def __deepcopy__(self, memo: dict[int, Any]) -> Replay:
        """Return a copy of its own; experiences never change, so they are shared."""
        copied = Replay()
        copied.counts, copied._rows = dict(self.counts), self._rows
        return copied

    def __len__(self) -> int:
        """Number of experiences, repeats included."""
        return sum(self.counts.values())

    def add(self, experience: Experience, times: int = 1) -> None:
        """Keep an experience."""
        self.counts[experience] = self.counts.get(experience, 0) + times

    def filled_from(self, other: Replay) -> Replay:
        """Return this experience, and that of another buffer about actions in cells of which this one knows nothing."""
        tried = {(experience.cell, experience.action) for experience in self.counts}
        filled = Replay()
        filled.counts = dict(self.counts)
        for experience, times in other.counts.items():
            if (experience.cell, experience.action) not in tried:
                filled.counts[experience] = times
        return filled

    def to_array(self) -> IntArray:
        """Return the buffer as [D, 7]: cell, action, next cell, blocked, number."""
        further = islice(self.counts, len(self._rows), None)
        rows = [(*e.cell, e.action, *e.next_cell, int(e.blocked)) for e in further]
        if rows:
            self._rows = np.concatenate((self._rows, np.array(rows, dtype=np.int64)))
        return np.column_stack((self._rows, np.fromiter(self.counts.values(), np.int64, len(self.counts))))

    @classmethod
    def from_array(cls, rows: IntArray) -> Replay:
        """Return the buffer that `to_array` wrote."""
        replay = cls()
        for r, c, action, next_r, next_c, blocked, number in rows.tolist():
            replay.add(Experience(Cell(r, c), action, Cell(next_r, next_c), bool(blocked)), number)
        if len(replay.counts) == len(rows):
            replay._rows = np.array(rows[:, :-1], dtype=np.int64)
        return replay


@compiled
def apply_batch(q: FloatArray, entries: IntArray, targets: FloatArray, batch: IntArray, learning_rate: float) -> None:
    """Move table entries toward their targets, one experience after the other, all goals at once (Eq. 2).

    Args:
        q: [R * C * A, G], changed in place.
        entries: [D] row of `q` of each different experience.
        targets: [D, G].
        batch: Experiences of the mini-batch, as indices below D.
        learning_rate: alpha.
    """
    for i in batch:
        for g in range(q.shape[1]):
            q[entries[i], g] += learning_rate * (targets[i, g] - q[entries[i], g])


def sweep(
    q: FloatArray, replay: Replay, goal_cells: Sequence[Cell], config: LearningConfig, rng: np.random.Generator
) -> None:
    """Recompute the target of every experience, shuffle them, and go through them once in mini-batches (§3.1.1).

    The targets stay fixed during the sweep, as the paper has it. A table's entries share no weights, so the size of a
    mini-batch then decides only how much is done per call.

    Args:
        q: [R, C, A, G], changed in place.
        replay: What was experienced.
        goal_cells: [G].
        config: Learning rate, discount, rewards, mini-batch.
        rng: Shuffles.
    """
    if not replay.counts:
        return
    shape = q.shape[:3]
    made = list(replay.counts)
    entries = np.array([np.ravel_multi_index((*e.cell, e.action), shape) for e in made])
    targets = np.stack(
        [
            td_targets(
                rewards_of_goals(config.rewards, e.cell, e.next_cell, e.blocked, goal_cells),
                q[e.next_cell],
                goals_at(e.next_cell, goal_cells),
                config.discount,
            )
            for e in made
        ]
    )
    order = np.repeat(np.arange(len(made)), list(replay.counts.values()))
    rng.shuffle(order)
    flat = q.reshape(-1, q.shape[3])
    for first in range(0, len(order), config.replay_batch):
        apply_batch(flat, entries, targets, order[first : first + config.replay_batch], config.sweep_rate)
