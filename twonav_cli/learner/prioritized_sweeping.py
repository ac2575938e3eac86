"""Prioritized sweeping: the most surprising remembered entries are backed up after each action (Moore, Atkeson 1993).

Dyna with a learned model: an entry is worth a backup when the value of the cell it leads to has changed, and the more
it has, the sooner. All goals are backed up at once; an entry's priority is the largest change over the goals. Untried
actions keep their optimistic first value, which is what explores. N cells, A = 4 actions, G goals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.learner.draws import ACTIONS
from twonav_cli.learner.maze_kernel import (
    NOBODY,
    QUEUED,
    IntArray,
    Rules,
    Tables,
    Ways,
    learn_from,
    note_if_optimal,
    value_of,
)

FloatArray = NDArray[np.float64]

WORTH_A_BACKUP = 1e-3
"""Change of a value below which nothing is queued (ours): a thousandth of a percent of the goal's reward."""


@compiled
def back_up(tables: Tables, ways: Ways, rules: Rules, cell: int, action: int) -> float:
    """Learn from one experience for every goal, and return the largest change of the cell's value over the goals."""
    q, best = tables.q, tables.best
    for g in range(q.shape[2]):
        best[cell, g] = value_of(q, cell, g)
    learn_from(tables, ways, rules, cell, action)
    change = 0.0
    for g in range(q.shape[2]):
        change = max(change, abs(value_of(q, cell, g) - best[cell, g]))
    return change


@compiled
def queue_those_before(tables: Tables, ways: Ways, cell: int, change: float) -> None:
    """Queue every remembered entry that leads into a cell whose value has changed."""
    if change <= WORTH_A_BACKUP:
        return
    priority = tables.priority
    for entry in ways.into[cell]:
        if entry != NOBODY and tables.counts[entry // ACTIONS, entry % ACTIONS] > 0:
            priority[entry] = max(priority[entry], change)


@compiled
def most_urgent(priority: FloatArray) -> int:
    """Return the entry of highest priority, the first of equals."""
    entry = 0
    for other in range(1, priority.shape[0]):
        if priority[other] > priority[entry]:
            entry = other
    return entry


@compiled
def sweep_by_priority(tables: Tables, ways: Ways, rules: Rules, at: IntArray, cell: int, action: int) -> None:
    """Learn from an action, then back up the remembered entries of highest priority, some at most."""
    priority = tables.priority
    change = back_up(tables, ways, rules, cell, action)
    if change <= WORTH_A_BACKUP and at[QUEUED] == 0:
        return
    queue_those_before(tables, ways, cell, change)
    at[QUEUED] = 1
    for _ in range(rules.backups):
        entry = most_urgent(priority)
        if priority[entry] <= 0.0:
            at[QUEUED] = 0
            break
        priority[entry] = 0.0
        before = entry // ACTIONS
        queue_those_before(tables, ways, before, back_up(tables, ways, rules, before, entry % ACTIONS))
    note_if_optimal(tables.q, ways, at)


@compiled
def queue_all(tables: Tables, ways: Ways, rules: Rules, at: IntArray) -> None:
    """Queue every remembered entry by how far it is from its target: a run that is taken up again lost its queue."""
    q = tables.q
    at[QUEUED] = 0
    for entry in range(tables.priority.shape[0]):
        cell, action = entry // ACTIONS, entry % ACTIONS
        tables.priority[entry] = 0.0
        if tables.counts[cell, action] == 0:
            continue
        row, next_cell = ways.reward_row[cell, action], ways.next_cell[cell, action]
        for g in range(q.shape[2]):
            target = ways.reward[row, g] + ways.discount[next_cell, g] * value_of(q, next_cell, g)
            away = abs(target - q[cell, action, g])
            if away > WORTH_A_BACKUP:
                tables.priority[entry] = max(tables.priority[entry], away)
                at[QUEUED] = 1
