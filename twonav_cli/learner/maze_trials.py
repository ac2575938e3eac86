"""The compiled loop over trials: every learner chooses, learns and plans here, under one criterion (§4.3).

N cells numbered row by row, A = 4 actions, G goals, S starts, W trials of the confirmation window, n trials of a call.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from twonav_cli.compiled import compiled, inlined
from twonav_cli.learner.draws import NoiseArray, StateArray, boltzmann, epsilon_greedy
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
    FloatArray,
    IntArray,
    Rules,
    Tables,
    Ways,
    learn_from,
    learn_step,
    note_if_optimal,
    sweep_all,
)
from twonav_cli.learner.nearest_untried import action_toward_untried, plan
from twonav_cli.learner.prioritized_sweeping import sweep_by_priority


@inlined
def walk(
    q: FloatArray,
    td: FloatArray,
    td_sum: FloatArray,
    counts: IntArray,
    noise: NoiseArray,
    next_cells: IntArray,
    reward_rows: IntArray,
    reward: FloatArray,
    discount: FloatArray,
    rules: Rules,
    goal: int,
    goal_cell: int,
    per_temperature: float,
    cell: int,
    actions_at_most: int,
    state: StateArray,
) -> tuple[int, int]:
    """Draw an action and learn from it, again and again, up to the goal or so many actions (Eq. 6, Eq. 2).

    Returns:
        Where the agent is then, and the number of actions.
    """
    taken, alpha, is_boltzmann = 0, rules.learning_rate, rules.is_boltzmann
    first, last = (goal, goal + 1) if rules.strategy == SINGLE else (0, q.shape[2])
    while cell != goal_cell and taken < actions_at_most:
        if is_boltzmann:
            action = boltzmann(q, cell, goal, per_temperature, noise, state)
        else:
            action = epsilon_greedy(q, cell, goal, rules.epsilon, state)
        next_cell, row = next_cells[cell, action], reward_rows[cell, action]
        learn_step(q, td, td_sum, reward, discount, row, alpha, cell, action, next_cell, first, last)
        counts[cell, action] += 1
        cell = next_cell
        taken += 1
    return cell, taken


@compiled
def explore(
    tables: Tables, ways: Ways, rules: Rules, goal: int, per_temperature: float, at: IntArray, state: StateArray
) -> None:
    """Take one action of a learner that plans, or none: choose it, learn from it, plan on what it showed."""
    q, counts, cell = tables.q, tables.counts, at[CELL]
    if at[EXPLORED] == 0:
        action = action_toward_untried(counts, ways.next_cell, cell, state)
        if action == NOBODY:  # a run that was taken up again after everything had been tried
            at[EXPLORED] = 1
            return
    elif rules.is_boltzmann:
        action = boltzmann(q, cell, goal, per_temperature, tables.noise, state)
    else:
        action = epsilon_greedy(q, cell, goal, rules.epsilon, state)
    next_cell = ways.next_cell[cell, action]
    counts[cell, action] += 1
    at[STEP] += 1
    at[CELL] = next_cell
    if rules.strategy == PRIORITIZED:
        sweep_by_priority(tables, ways, rules, at, cell, action)
        return
    learn_from(tables, ways, rules, cell, action)
    if counts[cell, action] == 1:
        plan(q, counts, ways, rules)
        at[EXPLORED] = int(action_toward_untried(counts, ways.next_cell, next_cell, state) == NOBODY)
        note_if_optimal(q, ways, at)


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

    The arrays are taken out of their tuples once a round, because that counts references, at the cost of some actions.

    Returns:
        The row after the last trial that ended, and the temperature then.
    """
    q, td, td_sum, counts, noise = tables.q, tables.td, tables.td_sum, tables.counts, tables.noise
    next_cells, rows, reward, discount = ways.next_cell, ways.reward_row, ways.reward, ways.discount
    goal_cell, plans = ways.goal_cells[goal], rules.strategy in (PRIORITIZED, NEAREST)
    while row < last_row:
        if at[TAKEN] == NOBODY:
            at[CELL], at[TAKEN] = ways.start_cells[at[START]], 0
        begun, per_temperature = at[STEP] - at[TAKEN], 1.0 / temperature
        end = min(begun + rules.limit, last_step)
        while (at[CELL] != goal_cell or at[EXPLORED] == 0) and at[STEP] < end:
            if plans:
                explore(tables, ways, rules, goal, per_temperature, at, state)
                continue
            most = min(end - at[STEP], rules.period - at[SINCE_SWEEP])
            cell, taken = walk(
                q, td, td_sum, counts, noise, next_cells, rows, reward, discount, rules, goal, goal_cell,
                per_temperature, at[CELL], most, state,
            )  # fmt: skip
            at[CELL] = cell
            at[STEP] += taken
            at[SINCE_SWEEP] += taken
            if at[SINCE_SWEEP] >= rules.period:
                replay(tables, ways, rules, at, goal)
        at[TAKEN] = at[STEP] - begun
        reached = at[CELL] == goal_cell and at[EXPLORED] == 1
        if not reached and at[TAKEN] < rules.limit:
            break
        columns.start[row], columns.steps[row], columns.reached[row] = at[START], at[TAKEN], reached
        for g in range(len(td_sum)):
            columns.td_errors[row, g] = td_sum[g]
        row += 1
        temperature = max(temperature * rules.decay, COLDEST)
        at[START], at[TAKEN] = (at[START] + 1) % len(ways.start_cells), NOBODY
        if at[START] == 0:
            break
    return row, temperature


@compiled
def replay(tables: Tables, ways: Ways, rules: Rules, at: IntArray, goal: int) -> None:
    """Sweep the replay buffer, of all goals or of the one (§3.1.1)."""
    first, last = (goal, goal + 1) if rules.strategy == SINGLE else (0, tables.q.shape[2])
    sweep_all(tables, ways, rules, first, last)
    at[SINCE_SWEEP] = 0
    at[SWEEPS] += 1
    note_if_optimal(tables.q, ways, at)


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
