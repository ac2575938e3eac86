"""The compiled loop over trials: every learner chooses, learns and plans here, under one criterion (§4.3).

N cells numbered row by row, A = 4 actions, G goals, S starts, W trials of the confirmation window, n trials of a call.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from twonav_cli.compiled import compiled
from twonav_cli.learner.draws import StateArray, boltzmann, epsilon_greedy
from twonav_cli.learner.exploration import COLDEST
from twonav_cli.learner.goals import is_learned, record_trial
from twonav_cli.learner.maze_kernel import (
    CELL,
    EXPLORED,
    NEAREST,
    NOBODY,
    PRIORITIZED,
    SINCE_SWEEP,
    SINGLE,
    START,
    STEP,
    SWEEPS,
    TAKEN,
    Columns,
    IntArray,
    Rules,
    Tables,
    Ways,
    learn_step,
    note_if_optimal,
    sweep_all,
)
from twonav_cli.learner.nearest_untried import action_toward_untried, plan
from twonav_cli.learner.prioritized_sweeping import sweep_by_priority


@compiled
def plan_after(
    tables: Tables, ways: Ways, rules: Rules, at: IntArray, next_cell: int, first: int, last: int, state: StateArray
) -> None:
    """Plan on what was experienced: by a sweep of the replay buffer, or when an action was tried for the first time."""
    if rules.strategy == NEAREST:
        plan(tables.q, tables.counts, ways, rules)
        at[EXPLORED] = int(action_toward_untried(tables.counts, ways.next_cell, next_cell, state) == NOBODY)
    else:
        sweep_all(tables, ways, rules, first, last)
        at[SINCE_SWEEP] = 0
        at[SWEEPS] += 1
    note_if_optimal(tables.q, ways, at)


@compiled
def run_round(
    tables: Tables,
    ways: Ways,
    rules: Rules,
    columns: Columns,
    goal: int,
    temperature: float,
    at: IntArray,
    state: StateArray,
    last_step: int,
    row: int,
    last_row: int,
) -> tuple[int, float]:
    """Run trials to the end of a round (one from each start), or until `last_step` or `last_row` is reached.

    The arrays are taken out of their tuples once a round and the choice of an action is spelled out, because a call
    that takes tuples or does not vanish into the loop counts references: several times the cost of the update itself.

    Returns:
        The row after the last trial that ended, and the temperature then.
    """
    q, td, td_sum, counts, noise = tables.q, tables.td, tables.td_sum, tables.counts, tables.noise
    next_cells, reward_rows, reward, discount = ways.next_cell, ways.reward_row, ways.reward, ways.discount
    first, last = (goal, goal + 1) if rules.strategy == SINGLE else (0, q.shape[2])
    goal_cell, alpha, is_boltzmann = ways.goal_cells[goal], rules.learning_rate, rules.is_boltzmann
    per_temperature = 1.0 / temperature
    while row < last_row:
        if at[TAKEN] == NOBODY:
            at[CELL], at[TAKEN] = ways.start_cells[at[START]], 0
        cell, step, since_sweep, explored = at[CELL], at[STEP], at[SINCE_SWEEP], at[EXPLORED]
        begun, end = step - at[TAKEN], min(step - at[TAKEN] + rules.limit, last_step)
        while (cell != goal_cell or explored == 0) and step < end:
            if explored == 0:
                action = action_toward_untried(counts, next_cells, cell, state)
            elif is_boltzmann:
                action = boltzmann(q, cell, goal, per_temperature, noise, state)
            else:
                action = epsilon_greedy(q, cell, goal, rules.epsilon, state)
            next_cell, is_new = next_cells[cell, action], counts[cell, action] == 0
            counts[cell, action] += 1
            step += 1
            since_sweep += 1
            if rules.strategy == PRIORITIZED:
                at[STEP] = step
                sweep_by_priority(tables, ways, rules, at, cell, action)
            else:
                reward_row = reward_rows[cell, action]
                learn_step(q, td, td_sum, reward, discount, reward_row, alpha, cell, action, next_cell, first, last)
            if since_sweep >= rules.period or (is_new and rules.strategy == NEAREST):
                at[STEP], at[SINCE_SWEEP] = step, since_sweep
                plan_after(tables, ways, rules, at, next_cell, first, last, state)
                since_sweep, explored = at[SINCE_SWEEP], at[EXPLORED]
            cell = next_cell
        at[CELL], at[STEP], at[SINCE_SWEEP], at[TAKEN] = cell, step, since_sweep, step - begun
        reached = cell == goal_cell and explored == 1
        if not reached and step - begun < rules.limit:
            break
        columns.start[row], columns.steps[row], columns.reached[row] = at[START], step - begun, reached
        for g in range(len(td_sum)):
            columns.td_errors[row, g] = td_sum[g]
        row += 1
        temperature = max(temperature * rules.decay, COLDEST)
        per_temperature = 1.0 / temperature
        at[START], at[TAKEN] = (at[START] + 1) % len(ways.start_cells), NOBODY
        if at[START] == 0:
            break
    return row, temperature


@compiled
def run_trials(
    tables: Tables,
    ways: Ways,
    rules: Rules,
    columns: Columns,
    consecutive: IntArray,
    window: IntArray,
    goal: int,
    temperature: float,
    at: IntArray,
    state: StateArray,
    actions_at_most: int,
    trials_at_most: int,
) -> tuple[int, float, bool]:
    """Run trials at one goal, from each start in turn, until it is learned or enough was done; may stop inside one.

    Returns:
        Number of trials that ended, the temperature after them, and whether the goal is learned.
    """
    ended: Any = np.int64(0)  # a literal 0 would be another type, and everything compiled twice
    last_step, running = at[STEP] + actions_at_most, True
    if at[STEP] == 0:
        note_if_optimal(tables.q, ways, at)
    while running and ended < trials_at_most:
        row, temperature = run_round(
            tables, ways, rules, columns, goal, temperature, at, state, last_step, ended, trials_at_most
        )
        for trial in range(ended, row):
            record_trial(consecutive, window, columns.start[trial], columns.steps[trial], columns.reached[trial])
        running, ended = at[TAKEN] == NOBODY, row
        # Both are asked once a round: so every goal gets the same number of trials from each start, and it is cheap.
        if running and at[START] == 0:
            note_if_optimal(tables.q, ways, at)
            if is_learned(consecutive, window, rules.max_step_difference):
                return ended, temperature, True
    return ended, temperature, False
