"""The explorer that walks to the nearest action it never tried and plans on what it saw (in the spirit of R-max, 2002).

In a deterministic maze an action tried once is known. While anything reachable is untried the agent walks on through
the goal of the trial without declaring that it arrived; afterwards every trial takes a shortest way. N cells, A = 4
actions, G goals.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.learner.draws import ACTIONS, StateArray, uniform
from twonav_cli.learner.maze_kernel import NOBODY, IntArray, Rules, Ways

FloatArray = NDArray[np.float64]


@compiled
def untried_action(counts: IntArray, cell: int, state: StateArray) -> int:
    """Return an action never tried in a cell, drawn at random among them, or NOBODY."""
    action, found = NOBODY, 0
    for a in range(ACTIONS):
        if counts[cell, a] == 0:
            found += 1
            if uniform(state) * found < 1.0:
                action = a
    return action


@compiled
def action_toward_untried(counts: IntArray, next_cells: IntArray, cell: int, state: StateArray) -> int:
    """Return the first action of a shortest known way to a cell with an untried action, or NOBODY when there is none.

    Breadth first over the tried actions.
    """
    here = untried_action(counts, cell, state)
    if here != NOBODY:
        return here
    first_action, queue = np.empty(counts.shape[0], dtype=np.int64), np.empty(counts.shape[0], dtype=np.int64)
    first_action[:] = NOBODY
    queue[0], head, tail = cell, 0, 1
    while head < tail:
        via = queue[head]
        head += 1
        for a in range(ACTIONS):
            onward = next_cells[via, a]
            if onward in (cell, via) or first_action[onward] != NOBODY:
                continue
            first_action[onward] = a if via == cell else first_action[via]
            for b in range(ACTIONS):
                if counts[onward, b] == 0:
                    return int(first_action[onward])
            queue[tail] = onward
            tail += 1
    return NOBODY


@compiled
def plan(q: FloatArray, counts: IntArray, ways: Ways, rules: Rules) -> None:
    """Set the values of every goal to what the experience says, wherever a way to the goal is known.

    Value iteration over the replay buffer, done in one pass per goal because the cells are taken in the order of their
    known distance to it. An untried action counts as blocked, so that a greedy agent keeps to what it knows.
    """
    order, known = np.empty(q.shape[0], dtype=np.int64), np.empty(q.shape[0], dtype=np.int64)
    value = np.empty(q.shape[0])
    for g in range(q.shape[2]):
        goal_cell = ways.goal_cells[g]
        known[:] = NOBODY
        order[0], known[goal_cell], value[goal_cell], head, tail = goal_cell, 0, -np.inf, 0, 1
        while head < tail:
            cell = order[head]
            head += 1
            for entry in ways.into[cell]:
                before = entry // ACTIONS
                if entry == NOBODY or known[before] != NOBODY or counts[before, entry % ACTIONS] == 0:
                    continue
                known[before] = known[cell] + 1
                onward = rules.reward_goal if cell == goal_cell else rules.reward_step + rules.discount * value[cell]
                value[before] = onward
                order[tail] = before
                tail += 1
        # The goal's own cell is left like any other: out of it and back.
        for a in range(ACTIONS):
            onward_cell = ways.next_cell[goal_cell, a]
            if counts[goal_cell, a] > 0 and onward_cell != goal_cell and known[onward_cell] != NOBODY:
                back = rules.reward_step + rules.discount * value[onward_cell]
                value[goal_cell] = max(value[goal_cell], back)
        for i in range(0 if value[goal_cell] > -np.inf else 1, tail):
            set_values_of_cell(q, counts, ways, rules, order[i], g, known, value)


@compiled
def set_values_of_cell(
    q: FloatArray, counts: IntArray, ways: Ways, rules: Rules, cell: int, g: int, known: IntArray, value: FloatArray
) -> None:
    """Set a goal's values of one cell from the values of the cells around it."""
    goal_cell = ways.goal_cells[g]
    for a in range(ACTIONS):
        onward = ways.next_cell[cell, a]
        if counts[cell, a] == 0 or onward == cell or known[onward] == NOBODY:
            behind = 0.0 if cell == goal_cell else value[cell]
            q[cell, a, g] = rules.reward_blocked + rules.discount * behind
        elif onward == goal_cell:
            q[cell, a, g] = rules.reward_goal
        else:
            q[cell, a, g] = rules.reward_step + rules.discount * value[onward]
