"""The compiled arithmetic of the maze, that of `Agent.observe`: an update of all goals, a sweep, a look at the ways.

N cells numbered row by row, A = 4 actions, G goals, S starts, W trials of the confirmation window, n trials of a call.
Goals are innermost in memory, so that updating ten of them costs little more than updating one.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled, inlined
from twonav_cli.learner.draws import ACTIONS, NoiseArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]

NOBODY = -1
"""Marks: no trial under way, not optimal yet, no entry."""

SINCE_SWEEP, SWEEPS, START, CELL, TAKEN, STEP, OPTIMAL_AT, EXPLORED, QUEUED, SUSPECT = range(10)
"""Places in `at`, the whole numbers of a run: actions since the last sweep, sweeps, the start of the trial under way,
where the agent is, actions of the trial (NOBODY between trials), actions of the run, the action after which every
greedy way was first a shortest one, whether nothing is left to explore, whether backups wait in the queue, and the pair
of start and goal whose way was not a shortest one when last asked."""

MULTI, SINGLE, PRIORITIZED, NEAREST = range(4)
"""What is done after an action."""


class Tables(NamedTuple):
    """What learning changes."""

    q: FloatArray  # [N, A, G]
    td: FloatArray  # [N, A, G]
    td_sum: FloatArray  # [G] sum of td over the free cells
    counts: IntArray  # [N, A] experiences; the maze is deterministic, so cell and action tell the rest
    best: FloatArray  # [N, G] scratch: value of every cell
    priority: FloatArray  # [N * A] scratch of prioritized sweeping
    noise: NoiseArray  # [8192] Gumbel noise to draw actions with


class Ways(NamedTuple):
    """What an action leads to."""

    next_cell: IntArray  # [N, A]
    into: IntArray  # [N, 8] entries (cell * A + action) that lead into a cell, bumps included; NOBODY fills up
    goal_cells: IntArray  # [G]
    start_cells: IntArray  # [S]
    reward: FloatArray  # [N + 1, G] what entering a cell earns; the last row is that of a bump
    reward_row: IntArray  # [N, A] the row of `reward` for an action
    discount: FloatArray  # [N, G] factor on the value of a cell: 0 where the goal lies, since its trial ends there
    distance: IntArray  # [N, G] length of the shortest way
    shortest: IntArray  # [S, G] the same from the starts


class Rules(NamedTuple):
    """The settings, as the loop reads them."""

    strategy: int
    learning_rate: float
    sweep_rate: float
    discount: float
    reward_goal: float
    reward_blocked: float
    reward_step: float
    is_boltzmann: bool
    epsilon: float
    decay: float
    period: int
    backups: int
    limit: int
    max_step_difference: float
    free_entries: int


class Columns(NamedTuple):
    """One row per trial."""

    start: IntArray  # [n]
    steps: IntArray  # [n]
    reached: NDArray[np.bool_]  # [n]
    td_errors: FloatArray  # [n, G]


@inlined
def value_of(q: FloatArray, cell: Any, g: Any) -> Any:
    """Return the value of a goal in a cell, that of its best action; indices with or without a sign."""
    return max(max(q[cell, 0, g], q[cell, 1, g]), max(q[cell, 2, g], q[cell, 3, g]))


@inlined
def learn_step(
    q: FloatArray,
    td: FloatArray,
    td_sum: FloatArray,
    reward: FloatArray,
    discount: FloatArray,
    row: int,
    learning_rate: float,
    cell: int,
    action: int,
    next_cell: int,
    first: int,
    last: int,
) -> None:
    """Update the goals `first` to `last` - 1 from one action (Eq. 2), with their squared TD errors (Eq. 3).

    Two goals a turn, everything read before anything is written, and indices without a sign: a third of the time of the
    plain loop, because nothing is read again and the processor works on both at once.
    """
    c, a, n, r = np.uint64(cell), np.uint64(action), np.uint64(next_cell), np.uint64(row)
    for k in range(first, last - 1, 2):
        g, h = np.uint64(k), np.uint64(k + 1)
        old_g, old_h = q[c, a, g], q[c, a, h]
        error_g = reward[r, g] + discount[n, g] * value_of(q, n, g) - old_g
        error_h = reward[r, h] + discount[n, h] * value_of(q, n, h) - old_h
        squared_g, squared_h = error_g * error_g, error_h * error_h
        sum_g, sum_h = td_sum[g] + (squared_g - td[c, a, g]), td_sum[h] + (squared_h - td[c, a, h])
        q[c, a, g], q[c, a, h] = old_g + learning_rate * error_g, old_h + learning_rate * error_h
        td_sum[g], td_sum[h] = sum_g, sum_h
        td[c, a, g], td[c, a, h] = squared_g, squared_h
    if (last - first) % 2 == 1:
        g = np.uint64(last - 1)
        error_g = reward[r, g] + discount[n, g] * value_of(q, n, g) - q[c, a, g]
        td_sum[g] += error_g * error_g - td[c, a, g]
        td[c, a, g] = error_g * error_g
        q[c, a, g] += learning_rate * error_g


@compiled
def learn_from(tables: Tables, ways: Ways, rules: Rules, cell: int, action: int) -> None:
    """Update every goal from one action (Eq. 2)."""
    first: Any = np.int64(0)  # a literal 0 would be another type, and the update compiled twice
    row, next_cell, alpha = ways.reward_row[cell, action], ways.next_cell[cell, action], rules.learning_rate
    q, td, td_sum, goals = tables.q, tables.td, tables.td_sum, tables.q.shape[2]
    learn_step(q, td, td_sum, ways.reward, ways.discount, row, alpha, cell, action, next_cell, first, goals)


@compiled
def sweep_all(tables: Tables, ways: Ways, rules: Rules, first: int, last: int) -> None:
    """Sweep the replay buffer once for the goals `first` to `last` - 1: the targets do not move meanwhile (§3.1.1).

    Copies of an experience have one target here: k updates toward it are one of rate 1 - (1 - alpha)^k, in any order.
    """
    q, counts, best, reward, discount = tables.q, tables.counts, tables.best, ways.reward, ways.discount
    next_cells, rows, left = ways.next_cell, ways.reward_row, 1.0 - rules.sweep_rate
    for cell in range(q.shape[0]):
        for g in range(first, last):
            best[cell, g] = value_of(q, cell, g)
    for cell in range(q.shape[0]):
        for a in range(ACTIONS):
            if counts[cell, a] == 0:
                continue
            next_cell, row = next_cells[cell, a], rows[cell, a]
            rate = 1.0 - left ** counts[cell, a] if left > 0.0 else 1.0
            for g in range(first, last):
                target = reward[row, g] + discount[next_cell, g] * best[next_cell, g]
                q[cell, a, g] += rate * (target - q[cell, a, g])


@compiled
def way_is_shortest(q: FloatArray, ways: Ways, start: int, g: int) -> bool:
    """Return whether the greedy way from a start to a goal is a shortest one, however ties are broken."""
    cell = ways.start_cells[start]
    while cell != ways.goal_cells[g]:
        best, onward = value_of(q, cell, g), cell
        for a in range(ACTIONS):
            if q[cell, a, g] == best:
                onward = ways.next_cell[cell, a]
                if ways.distance[onward, g] != ways.distance[cell, g] - 1:
                    return False
        cell = onward
    return True


@compiled
def note_if_optimal(q: FloatArray, ways: Ways, at: IntArray) -> None:
    """Keep the number of actions after which the greedy way from every start to every goal was first a shortest one.

    The way that was not one when last asked is looked at first, so that the answer is mostly cheap.
    """
    pairs, goals = len(ways.start_cells) * q.shape[2], q.shape[2]
    if at[OPTIMAL_AT] >= 0:
        return
    for i in range(pairs):
        pair = (max(at[SUSPECT], 0) + i) % pairs
        if not way_is_shortest(q, ways, pair // goals, pair % goals):
            at[SUSPECT] = pair
            return
    at[OPTIMAL_AT] = at[STEP]
