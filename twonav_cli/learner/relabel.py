"""The values of a new goal from old experience, with no step in the environment (ours; an aim of the paper, §2).

The experience gets the rewards of the new goal and is backed up until nothing changes any more.
R rows, C columns, N = R C cells, A = 4 actions, D different experiences. An entry is a cell with an action.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import LearningConfig
from twonav_cli.grid import Cell
from twonav_cli.learner.replay import Replay
from twonav_cli.maze import Action

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]

ACTIONS = len(Action)
STILL = 1e-10
"""Largest change of a value in the last sweep (ours)."""

SWEEPS_AT_MOST = 2000
"""Where every action always does the same, three sweeps are enough; this bounds those that often do not (ours)."""


@dataclass(frozen=True)
class NewGoal:
    """What came of adding a goal."""

    index: int
    """In every table."""
    name: str
    without_way: tuple[Cell, ...]
    """Free cells from which the experience knows no way to the goal."""
    untried: tuple[Cell, ...]
    """Free cells with an action that was never tried."""
    remembered: int = 0
    """Actions that the values were learned from, repeats included."""


class Model(NamedTuple):
    """What the experience says about every entry."""

    reward: FloatArray  # [N * A] mean reward
    stay: FloatArray  # [N * A] share of the outcomes after which the agent is where it was
    unknown: BoolArray  # [N * A] never tried, in a cell without a known way
    first: IntArray  # [N * A + 1] where the entry's moves begin in the two arrays below
    next_cell: IntArray  # [D]
    share: FloatArray  # [D] of the entry's outcomes


def values_from_experience(
    free: BoolArray, replay: Replay, goal: Cell, config: LearningConfig, outside: Replay | None = None
) -> tuple[FloatArray, BoolArray]:
    """Return the values of a goal that a replay buffer implies: the fixed point of Eq. 2 over its experiences (ours).

    An entry that was tried has the mean target of its experiences. One that was not tried, in a cell with a known way
    to the goal, counts as blocked, and so does an outcome from where no way is known: a greedy agent never leaves a
    known way for the unknown. In a cell without a known way an untried entry keeps `initial_q`, and the tried ones
    carry it on: a greedy agent walks to the nearest unknown.

    Args:
        free: [R, C] cells where the agent can be; experiences elsewhere are passed over.
        replay: What was experienced.
        goal: A free cell.
        config: Discount, rewards and the first value of an entry.
        outside: Experience of an earlier stage, for entries on which `replay` has nothing.

    Returns:
        Values [R, C, A], and the free cells [R, C] from which the experience knows a way; the goal's own is one.
    """
    return values_from_rows(free, remembered(free, (replay,), outside), goal, config)


def values_from_rows(
    free: BoolArray, rows: IntArray, goal: Cell, config: LearningConfig
) -> tuple[FloatArray, BoolArray]:
    """Return `values_from_experience` of the rows [D, 7] that `remembered` gives."""
    rewards = np.array([config.rewards.goal, config.rewards.blocked, config.rewards.step], dtype=np.float64)
    goal_cell = goal[0] * free.shape[1] + goal[1]
    q, has_way, _ = solved(
        free.reshape(-1),
        entries_of(free, rows),
        rows[:, 3] * free.shape[1] + rows[:, 4],
        rows[:, 6].copy(),  # a view may or may not be contiguous, and each kind would be compiled on its own
        rows[:, 5] > 0,
        goal_cell,
        rewards,
        float(config.discount),
        float(config.initial_q),
    )
    return q.reshape(*free.shape, ACTIONS), has_way.reshape(free.shape)


def compile_now() -> None:
    """Compile what adds a goal, or read it from disk: seconds the first time, so it is done before a clock runs."""
    values_from_rows(np.ones((1, 1), dtype=np.bool_), Replay().to_array(), Cell(0, 0), LearningConfig())


def remembered(free: BoolArray, own: Sequence[Replay], outside: Replay | None = None) -> IntArray:
    """Return the experiences between free cells [D, 7], as `Replay.to_array` does.

    All of `own` are among them, and those of `outside` on whose entries `own` has nothing.
    """
    rows = _inside(free, np.concatenate([replay.to_array() for replay in own]))
    if outside is None or not outside.counts:
        return rows
    further = _inside(free, outside.to_array())
    known = tried_entries(free, rows).reshape(-1)
    return np.concatenate((rows, further[~known[entries_of(free, further)]]))


def tried_entries(free: BoolArray, rows: IntArray) -> BoolArray:
    """Return which entries [R, C, A] some rows [D, 7] are about."""
    tried = np.zeros((*free.shape, ACTIONS), dtype=np.bool_)
    tried.reshape(-1)[entries_of(free, rows)] = True
    return tried


def entries_of(free: BoolArray, rows: IntArray) -> IntArray:
    """Return the entry [D] of each row [D, 7], numbered cell by cell."""
    return np.asarray((rows[:, 0] * free.shape[1] + rows[:, 1]) * ACTIONS + rows[:, 2], dtype=np.int64)


def cells_where(mask: BoolArray) -> tuple[Cell, ...]:
    """Return the cells of a mask [R, C], row by row."""
    return tuple(Cell(row, col) for row, col in np.argwhere(mask).tolist())


def _inside(free: BoolArray, rows: IntArray) -> IntArray:
    """Return the rows [D, 7] whose cells are free and whose action is one; the compiled part checks no index."""
    for row, col in ((0, 1), (3, 4)):
        within = (rows[:, row] >= 0) & (rows[:, row] < free.shape[0]) & (rows[:, col] >= 0)
        rows = rows[within & (rows[:, col] < free.shape[1])]
        rows = rows[free[rows[:, row], rows[:, col]]]
    return rows[(rows[:, 2] >= 0) & (rows[:, 2] < ACTIONS) & (rows[:, 6] > 0)]


@compiled
def solved(
    free: BoolArray,
    entries: IntArray,
    next_cells: IntArray,
    numbers: IntArray,
    blocked: BoolArray,
    goal: int,
    rewards: FloatArray,
    discount: float,
    initial_q: float,
) -> tuple[FloatArray, BoolArray, int]:
    """Return values [N, A], the cells with a known way [N], and the number of sweeps it took."""
    totals = np.zeros(free.shape[0] * ACTIONS, dtype=np.int64)
    for i in range(entries.shape[0]):
        totals[entries[i]] += numbers[i]
    has_way, order = nearest_first(free, entries, next_cells, totals, goal)
    model = model_of(entries, next_cells, numbers, blocked, totals, has_way, goal, rewards)
    # A way that never arrives costs a step for ever: no cell that can move is worth less.
    v = np.full(free.shape[0], rewards[2] / (1.0 - discount))
    sweeps, change = 0, np.inf
    while change > STILL and sweeps < SWEEPS_AT_MOST:
        change = sweep_cells(v, model, order, discount, initial_q)
        sweeps += 1
    q = np.full((free.shape[0], ACTIONS), initial_q)
    for cell in order:
        for a in range(ACTIONS):
            entry = cell * ACTIONS + a
            if not model.unknown[entry]:
                q[cell, a] = beyond(v, model, entry, discount) + discount * model.stay[entry] * v[cell]
    return q, has_way, sweeps


@compiled
def nearest_first(
    free: BoolArray, entries: IntArray, next_cells: IntArray, totals: IntArray, goal: int
) -> tuple[BoolArray, IntArray]:
    """Return the cells with a known way [N], and all free cells in the order that values spread in.

    They spread from the goal against the experiences, then among the other cells from those with an untried entry.
    """
    cells = free.shape[0]
    first = np.zeros(cells + 1, dtype=np.int64)
    for i in range(entries.shape[0]):
        first[next_cells[i] + 1] += 1
    first = np.cumsum(first)
    into, filled = np.zeros(entries.shape[0], dtype=np.int64), first.copy()
    for i in range(entries.shape[0]):
        into[filled[next_cells[i]]] = entries[i] // ACTIONS
        filled[next_cells[i]] += 1
    seen = np.zeros(cells, dtype=np.bool_)
    order = np.zeros(cells, dtype=np.int64)
    order[0], seen[goal] = goal, True
    found = spread(order, seen, first, into, 0, 1)
    has_way, begun = seen.copy(), found
    for cell in range(cells):
        if free[cell] and not seen[cell] and totals[cell * ACTIONS : (cell + 1) * ACTIONS].min() == 0:
            order[found], seen[cell] = cell, True
            found += 1
    found = spread(order, seen, first, into, begun, found)
    for cell in range(cells):
        if free[cell] and not seen[cell]:
            order[found] = cell
            found += 1
    return has_way, order[:found]


@compiled
def spread(order: IntArray, seen: BoolArray, first: IntArray, into: IntArray, done: int, found: int) -> int:
    """Add to `order` every cell not seen yet that leads to one of its cells from place `done` on; return its length."""
    while done < found:
        cell = order[done]
        done += 1
        for i in range(first[cell], first[cell + 1]):
            if not seen[into[i]]:
                seen[into[i]] = True
                order[found] = into[i]
                found += 1
    return found


@compiled
def model_of(
    entries: IntArray,
    next_cells: IntArray,
    numbers: IntArray,
    blocked: BoolArray,
    totals: IntArray,
    has_way: BoolArray,
    goal: int,
    rewards: FloatArray,
) -> Model:
    """Return what the experience says about every entry; behind the goal's cell there is nothing more to earn."""
    reward, stay = np.zeros(totals.shape[0]), np.zeros(totals.shape[0])
    unknown = np.zeros(totals.shape[0], dtype=np.bool_)
    first = np.zeros(totals.shape[0] + 1, dtype=np.int64)
    share = np.zeros(entries.shape[0])
    for entry in range(totals.shape[0]):
        if totals[entry] == 0 and has_way[entry // ACTIONS]:
            reward[entry], stay[entry] = rewards[1], 0.0 if entry // ACTIONS == goal else 1.0
        unknown[entry] = totals[entry] == 0 and not has_way[entry // ACTIONS]
    for i in range(entries.shape[0]):
        entry, next_cell = entries[i], next_cells[i]
        cell, share[i] = entry // ACTIONS, numbers[i] / totals[entry]
        lost = has_way[cell] and not has_way[next_cell]
        earned = rewards[1] if blocked[i] or lost else rewards[2]
        if next_cell == goal and cell != goal:
            earned = rewards[0]
        elif (next_cell == cell or lost) and cell != goal:
            stay[entry] += share[i]
        elif next_cell != goal and not lost:
            first[entry + 1] += 1
        reward[entry] += share[i] * earned
    first = np.cumsum(first)
    filled, moves, shares = first.copy(), np.zeros(first[-1], dtype=np.int64), np.zeros(first[-1])
    for i in range(entries.shape[0]):
        cell, next_cell = entries[i] // ACTIONS, next_cells[i]
        if next_cell != goal and next_cell != cell and (has_way[next_cell] or not has_way[cell]):
            moves[filled[entries[i]]], shares[filled[entries[i]]] = next_cell, share[i]
            filled[entries[i]] += 1
    return Model(reward, stay, unknown, first, moves, shares)


@compiled
def sweep_cells(v: FloatArray, model: Model, order: IntArray, discount: float, initial_q: float) -> float:
    """Bring every cell's value up to date with its neighbours', in order; return the largest change.

    The part of an entry that stays in its cell is solved for: V = b + gamma p V is b / (1 - gamma p).
    """
    change = 0.0
    for cell in order:
        best = -np.inf
        for a in range(ACTIONS):
            entry = cell * ACTIONS + a
            if model.unknown[entry]:
                best = max(best, initial_q)
            else:
                best = max(best, beyond(v, model, entry, discount) / (1.0 - discount * model.stay[entry]))
        change = max(change, abs(best - v[cell]))
        v[cell] = best
    return change


@compiled
def beyond(v: FloatArray, model: Model, entry: int, discount: float) -> float:
    """Return what an entry earns and leads to, without the part that stays in its cell."""
    value = model.reward[entry]
    for i in range(model.first[entry], model.first[entry + 1]):
        value += discount * model.share[i] * v[model.next_cell[i]]
    return float(value)
