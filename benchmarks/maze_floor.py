"""The least that learning ten goals in a maze can cost: numba loops with nothing around them, for `bench_maze.py`.

N cells numbered row by row, A = 4 actions, G goals, S starts; entry = cell * A + action.

What makes them fast: the update of all goals is one vector operation (numba's own loops are not vectorised here, since
the rows that are read may be the row that is written); arriving and bumping are looked up instead of asked; actions are
drawn by Gumbel noise, so that no exponential stands between one cell and the next.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import permutations
from typing import Any, NamedTuple

import numba
import numpy as np
from llvmlite import ir
from numba.extending import intrinsic
from numpy.typing import NDArray

from twonav_cli.config import LearningConfig
from twonav_cli.maze import Action, Maze

ACTIONS = 4
TRIALS_PER_GOAL = 500
NOISES = 2**16
U = np.uint64  # numba looks whether a signed index is negative, at every access


class Table(NamedTuple):
    """A maze and what is learned in it."""

    q: NDArray[np.float64]  # [N * A, G]
    next_cell: NDArray[np.uint64]  # [N * A]
    rewards: NDArray[np.float64]  # [N + 1, G] of entering a cell; the last row of a bump
    reward_row: NDArray[np.uint64]  # [N * A]
    discounts: NDArray[np.float64]  # [N, G] of a cell's value; 0 where the goal lies
    goals: NDArray[np.uint64]  # [G]
    starts: NDArray[np.uint64]  # [S]


def table_of(maze: Maze, config: LearningConfig) -> Table:
    """Return the maze with an untrained table."""
    numbers = np.arange(maze.rows * maze.cols).reshape(maze.rows, maze.cols)
    goals = np.array([numbers[cell] for cell in maze.goals.values()])
    starts = np.array([numbers[cell] for cell in maze.starts.values()])
    next_cell = np.repeat(numbers.reshape(-1, 1), ACTIONS, axis=1)
    for cell in maze.free_cells:
        next_cell[numbers[cell]] = [numbers[maze.moved(cell, action)] for action in Action]
    bumps = next_cell == numbers.reshape(-1, 1)
    rewards = np.full((numbers.size + 1, goals.size), config.rewards.step)
    discounts = np.full((numbers.size, goals.size), config.discount)
    each = np.arange(goals.size)
    rewards[goals, each], discounts[goals, each], rewards[-1] = config.rewards.goal, 0.0, config.rewards.blocked
    q = np.full((next_cell.size, goals.size), config.initial_q)
    reward_row = np.where(bumps, numbers.size, next_cell)
    wholes = [array.reshape(-1).astype(np.uint64) for array in (next_cell, reward_row, goals, starts)]
    return Table(q, wholes[0], rewards, wholes[1], discounts, wholes[2], wholes[3])


def update_of(goals: int) -> Callable[..., None]:
    """Return a compiled update of that many goals at once, with learning rate 1 (Eq. 2)."""
    row_type = ir.VectorType(ir.DoubleType(), goals)

    @intrinsic
    def update(typing: Any, q: Any, rewards: Any, discounts: Any, entry: Any, following: Any, row: Any) -> Any:
        """q[entry] = rewards[row] + discounts[following] * max over a of q[following * A + a]."""

        def generate(context: Any, builder: Any, signature: Any, given: Any) -> Any:
            def at(array: int, number: Any) -> Any:
                data = context.make_array(signature.args[array])(context, builder, given[array]).data
                place = builder.gep(data, [builder.mul(number, ir.Constant(ir.IntType(64), goals))])
                return builder.bitcast(place, row_type.as_pointer())

            def loaded(array: int, number: Any) -> Any:
                value = builder.load(at(array, number))
                value.align = 8
                return value

            def larger(one: Any, other: Any) -> Any:
                return builder.select(builder.fcmp_ordered(">", one, other), one, other)

            first = builder.mul(given[4], ir.Constant(ir.IntType(64), ACTIONS))
            values = [loaded(0, builder.add(first, ir.Constant(ir.IntType(64), a))) for a in range(ACTIONS)]
            best = larger(larger(values[0], values[1]), larger(values[2], values[3]))
            target = builder.fadd(loaded(1, given[5]), builder.fmul(loaded(2, given[4]), best))
            builder.store(target, at(0, given[3])).align = 8
            return context.get_dummy_value()

        number = numba.types.uint64
        return numba.types.void(q, rewards, discounts, number, number, number), generate

    return update


@numba.njit
def next_state(x: np.uint64) -> np.uint64:
    """Move the generator on (xorshift64*, Vigna 2016)."""
    x ^= x >> U(12)
    x ^= x << U(25)
    return x ^ (x >> U(27))


@numba.njit
def boltzmann(q: Any, first: np.uint64, goal: np.uint64, per_temperature: float, bits: np.uint64, noise: Any) -> Any:
    """Return the entry of an action drawn by Eq. 6: the largest of Q/T plus Gumbel noise."""
    lowest = U(NOISES - 1)
    v0 = q[first, goal] * per_temperature + noise[bits & lowest]
    v1 = q[first + U(1), goal] * per_temperature + noise[(bits >> U(16)) & lowest]
    v2 = q[first + U(2), goal] * per_temperature + noise[(bits >> U(32)) & lowest]
    v3 = q[first + U(3), goal] * per_temperature + noise[bits >> U(48)]
    upper, lower = U(1) if v1 > v0 else U(0), U(3) if v3 > v2 else U(2)
    return first + (lower if max(v2, v3) > max(v0, v1) else upper)


@numba.njit
def epsilon_greedy(q: Any, first: np.uint64, goal: np.uint64, epsilon: float, bits: np.uint64, orders: Any) -> Any:
    """Return the first of the largest values in a random order, or with probability epsilon the order's first entry."""
    order = orders[((bits >> U(32)) * U(24)) >> U(32)]
    e0, e1, e2, e3 = first + order[0], first + order[1], first + order[2], first + order[3]
    v0, v1, v2, v3 = q[e0, goal], q[e1, goal], q[e2, goal], q[e3, goal]
    upper, lower = e1 if v1 > v0 else e0, e3 if v3 > v2 else e2
    best = lower if max(v2, v3) > max(v0, v1) else upper
    return e0 if float(np.int64(bits & U(0xFFFFFFFF))) < epsilon * 4294967296.0 else best


def gumbel_noise() -> NDArray[np.float64]:
    """Return the quantiles of the Gumbel distribution, one for each 16 random bits."""
    return np.asarray(-np.log(-np.log((np.arange(NOISES) + 0.5) / NOISES)))


def orders_of_actions() -> NDArray[np.uint64]:
    """Return the 24 orders of the actions [24, A]."""
    return np.array(list(permutations(range(ACTIONS))), dtype=np.uint64)


def floor_of(maze: Maze, config: LearningConfig) -> Callable[[int], int]:
    """Return a function that runs so many trials, goal after goal, learning on, and returns the actions taken."""
    table, update = table_of(maze, config), update_of(len(maze.goals))
    is_boltzmann, limit = config.exploration == "boltzmann", config.trial_limit_steps
    draw, drawn_with = (boltzmann, gumbel_noise()) if is_boltzmann else (epsilon_greedy, orders_of_actions())
    hottest, decay, epsilon = config.temperature, config.temperature_decay, config.epsilon

    @numba.njit
    def run(table: Table, drawn_with: Any, trials: int, x: np.uint64) -> tuple[int, np.uint64]:
        q, next_cell, rewards, reward_row, discounts, goals, starts = table
        steps, per_temperature = 0, 1.0 / hottest
        for trial in range(trials):
            goal = U(trial // TRIALS_PER_GOAL % goals.size)
            per_temperature = 1.0 / hottest if trial % TRIALS_PER_GOAL == 0 else per_temperature / decay
            cell, taken = starts[U(trial % starts.size)], 0
            while cell != goals[goal] and taken < limit:
                x = next_state(x)
                bits = x * U(0x2545F4914F6CDD1D)
                entry = draw(q, cell * U(ACTIONS), goal, per_temperature if is_boltzmann else epsilon, bits, drawn_with)
                cell = next_cell[entry]
                update(q, rewards, discounts, entry, cell, reward_row[entry])
                taken += 1
            steps += taken
        return steps, x

    state = [U(88172645463325252)]

    def run_trials(trials: int) -> int:
        steps, state[0] = run(table, drawn_with, trials, state[0])
        return int(steps)

    return run_trials
