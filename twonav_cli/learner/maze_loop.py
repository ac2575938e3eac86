"""The compiled learning loop of the maze: many trials per call, the same arithmetic as `Agent.observe`.

N cells numbered row by row, A = 4 actions, G goals, S starts, W trials of the confirmation window, n trials of a call.
Per action it costs about as much to update ten goals as one, because goals are innermost in memory.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import COLDEST, Agent
from twonav_cli.learner.goals import is_learned, record_trial
from twonav_cli.learner.replay import Experience, Replay
from twonav_cli.maze import Action, Maze
from twonav_cli.rng import stream

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
StateArray = NDArray[np.uint64]

ACTIONS = 4
NEGLIGIBLE = -40.0
"""Exponent below which an action's weight is taken as zero: e^-40 is under the rounding of a sum that holds a 1."""

SHIFT_A, SHIFT_B, SHIFT_C = np.uint64(12), np.uint64(25), np.uint64(27)
MULTIPLIER = np.uint64(0x2545F4914F6CDD1D)
TO_53_BITS = np.uint64(11)


class Tables(NamedTuple):
    """What learning changes."""

    q: FloatArray  # [N, A, G]
    td: FloatArray  # [N, A, G]
    td_sum: FloatArray  # [G] sum of td over the free cells
    counts: IntArray  # [N, A] experiences; the maze is deterministic, so cell and action tell the rest
    targets: FloatArray  # [N, A, G] scratch of a sweep


class Ways(NamedTuple):
    """What an action leads to."""

    next_cell: IntArray  # [N, A]
    goal_cells: IntArray  # [G]
    start_cells: IntArray  # [S]
    shortest: IntArray  # [S, G]


class Rules(NamedTuple):
    """The settings, as the loop reads them."""

    learning_rate: float
    discount: float
    reward_goal: float
    reward_blocked: float
    reward_step: float
    is_boltzmann: bool
    epsilon: float
    decay: float
    period: int
    limit: int
    max_step_difference: float
    free_entries: int


class Columns(NamedTuple):
    """One row per trial."""

    start: IntArray  # [n]
    steps: IntArray  # [n]
    reached: NDArray[np.bool_]  # [n]
    td_errors: FloatArray  # [n, G]


@compiled
def uniform(state: StateArray) -> float:
    """Return a number in [0, 1) and move the generator on (xorshift64*, Vigna 2016)."""
    x = state[0]
    x ^= x >> SHIFT_A
    x ^= x << SHIFT_B
    x ^= x >> SHIFT_C
    state[0] = x
    return float((x * MULTIPLIER) >> TO_53_BITS) * (1.0 / 9007199254740992.0)


@compiled
def greedy(q: FloatArray, cell: int, goal: int, state: StateArray) -> int:
    """Return an action of largest value, ties broken at random."""
    best, ties, action = q[cell, 0, goal], 1, 0
    for a in range(1, ACTIONS):
        value = q[cell, a, goal]
        if value > best:
            best, ties, action = value, 1, a
        elif value == best:
            ties += 1
            if uniform(state) * ties < 1.0:
                action = a
    return action


@compiled
def boltzmann(q: FloatArray, cell: int, goal: int, per_temperature: float, state: StateArray) -> int:
    """Return an action drawn from the Boltzmann probabilities (Eq. 6)."""
    v0, v1, v2, v3 = q[cell, 0, goal], q[cell, 1, goal], q[cell, 2, goal], q[cell, 3, goal]
    best = max(max(v0, v1), max(v2, v3))
    w0 = weight((v0 - best) * per_temperature)
    w1 = w0 + weight((v1 - best) * per_temperature)
    w2 = w1 + weight((v2 - best) * per_temperature)
    w3 = w2 + weight((v3 - best) * per_temperature)
    drawn = uniform(state) * w3
    return int(drawn >= w0) + int(drawn >= w1) + int(drawn >= w2)


@compiled
def weight(exponent: float) -> float:
    """Return exp(exponent) for an exponent of at most 0, skipping the exponential where it is not needed."""
    if exponent == 0.0:
        return 1.0
    if exponent < NEGLIGIBLE:
        return 0.0
    return math.exp(exponent)


@compiled
def drawn_action(q: FloatArray, rules: Rules, cell: int, goal: int, per_temperature: float, state: StateArray) -> int:
    """Return the action to explore with."""
    if rules.is_boltzmann:
        return boltzmann(q, cell, goal, per_temperature, state)
    if uniform(state) < rules.epsilon:
        return int(uniform(state) * ACTIONS)
    return greedy(q, cell, goal, state)


@compiled
def target_of(q: FloatArray, rules: Rules, cell: int, next_cell: int, goal_cell: int, goal: int) -> float:
    """Return the target of one goal for one action (inside Eq. 2)."""
    reward = rules.reward_blocked if next_cell == cell else rules.reward_step
    if next_cell == goal_cell:
        return reward if next_cell == cell else rules.reward_goal
    best = max(max(q[next_cell, 0, goal], q[next_cell, 1, goal]), max(q[next_cell, 2, goal], q[next_cell, 3, goal]))
    return float(reward + rules.discount * best)


@compiled
def learn_step(
    q: FloatArray,
    td: FloatArray,
    td_sum: FloatArray,
    goal_cells: IntArray,
    rules: Rules,
    cell: int,
    action: int,
    next_cell: int,
) -> None:
    """Update every goal from one action (Eq. 2), with its squared TD error (Eq. 3)."""
    for g in range(q.shape[2]):
        error = target_of(q, rules, cell, next_cell, goal_cells[g], g) - q[cell, action, g]
        squared = error * error
        td_sum[g] += squared - td[cell, action, g]
        td[cell, action, g] = squared
        q[cell, action, g] += rules.learning_rate * error


@compiled
def sweep_all(
    q: FloatArray, counts: IntArray, targets: FloatArray, next_cells: IntArray, goal_cells: IntArray, rules: Rules
) -> None:
    """Sweep the replay buffer once: all targets first, then every update (§3.1.1).

    Copies of an experience have one target here: k updates toward it are one of rate 1 - (1 - alpha)^k, in any order.
    """
    cells, actions, goals = q.shape
    for cell in range(cells):
        for a in range(actions):
            if counts[cell, a] > 0:
                for g in range(goals):
                    targets[cell, a, g] = target_of(q, rules, cell, next_cells[cell, a], goal_cells[g], g)
    for cell in range(cells):
        for a in range(actions):
            if counts[cell, a] > 0:
                left = 1.0 - rules.learning_rate
                rate = 1.0 - left ** counts[cell, a] if left > 0.0 else 1.0
                for g in range(goals):
                    q[cell, a, g] += rate * (targets[cell, a, g] - q[cell, a, g])


@compiled
def run_trial(
    tables: Tables,
    ways: Ways,
    rules: Rules,
    start: int,
    goal: int,
    temperature: float,
    clock: IntArray,
    state: StateArray,
) -> int:
    """Run one trial and return the number of actions, negative when the goal was not reached.

    `clock` counts [actions since the last sweep, sweeps]. The arrays are taken out of their tuples first: handing the
    tuples on would count references at every action, which costs ten times the update itself.
    """
    q, td, td_sum, counts = tables.q, tables.td, tables.td_sum, tables.counts
    next_cells, goal_cells = ways.next_cell, ways.goal_cells
    cell, goal_cell, steps = ways.start_cells[start], ways.goal_cells[goal], 0
    per_temperature = 1.0 / temperature
    while cell != goal_cell and steps < rules.limit:
        action = drawn_action(q, rules, cell, goal, per_temperature, state)
        next_cell = next_cells[cell, action]
        learn_step(q, td, td_sum, goal_cells, rules, cell, action, next_cell)
        counts[cell, action] += 1
        clock[0] += 1
        if clock[0] >= rules.period:
            sweep_all(q, counts, tables.targets, next_cells, goal_cells, rules)
            clock[0] = 0
            clock[1] += 1
        cell = next_cell
        steps += 1
    return steps if cell == goal_cell else -steps


@compiled
def run_trials(
    tables: Tables,
    ways: Ways,
    rules: Rules,
    columns: Columns,
    consecutive: IntArray,
    window: IntArray,
    goal: int,
    next_start: int,
    temperature: float,
    clock: IntArray,
    state: StateArray,
) -> tuple[int, float, bool]:
    """Run up to n trials at one goal, from each start in turn, until it is learned.

    Returns:
        Number of trials, the temperature after them, and whether the goal is learned.
    """
    starts = ways.start_cells.shape[0]
    for i in range(columns.start.shape[0]):
        start = (next_start + i) % starts
        signed = run_trial(tables, ways, rules, start, goal, temperature, clock, state)
        reached = signed > 0 or ways.start_cells[start] == ways.goal_cells[goal]
        record_trial(consecutive, window, start, abs(signed), reached)
        temperature = max(temperature * rules.decay, COLDEST)
        columns.start[i], columns.steps[i], columns.reached[i] = start, abs(signed), reached
        for g in range(tables.td_sum.shape[0]):
            columns.td_errors[i, g] = max(tables.td_sum[g], 0.0) / rules.free_entries
        # The criterion is asked once a round, so that every goal gets the same number of trials from each start.
        if start == starts - 1 and is_learned(consecutive, window, rules.max_step_difference):
            return i + 1, temperature, True
    return columns.start.shape[0], temperature, False


def tables_of(agent: Agent) -> Tables:
    """Return the agent's tables as the loop sees them; q and td share their memory with the agent's."""
    rows, cols, actions, goals = agent.q.shape
    shape = (rows * cols, actions, goals)
    counts = np.zeros(shape[:2], dtype=np.int64)
    for (cell, action, _next, _blocked), number in agent.replay.counts.items():
        counts[cell.row * cols + cell.col, action] += number
    return Tables(agent.q.reshape(shape), agent.td.reshape(shape), np.zeros(goals), counts, np.zeros(shape))


def ways_of(maze: Maze) -> Ways:
    """Return what every action leads to; a blocked cell leads nowhere."""
    numbers = np.arange(maze.rows * maze.cols).reshape(maze.rows, maze.cols)
    next_cell = np.repeat(numbers.reshape(-1, 1), ACTIONS, axis=1)
    for cell in maze.free_cells:
        for action in Action:
            next_cell[numbers[cell], action] = numbers[maze.moved(cell, action)]
    goal_cells = np.array([numbers[cell] for cell in maze.goals.values()])
    start_cells = np.array([numbers[cell] for cell in maze.starts.values()])
    distances = np.stack([maze.distances_to(cell).reshape(-1) for cell in maze.goals.values()], axis=1)
    return Ways(next_cell, goal_cells, start_cells, distances[start_cells].astype(np.int64))


def rules_of(agent: Agent) -> Rules:
    """Return the agent's settings as the loop reads them."""
    config, rewards = agent.config, agent.config.rewards
    return Rules(
        learning_rate=float(config.learning_rate),
        discount=float(config.discount),
        reward_goal=float(rewards.goal),
        reward_blocked=float(rewards.blocked),
        reward_step=float(rewards.step),
        is_boltzmann=config.exploration == "boltzmann",
        epsilon=float(config.epsilon),
        decay=float(config.temperature_decay),
        period=int(config.replay_period_steps),
        limit=int(config.trial_limit_steps),
        max_step_difference=float(config.max_step_difference),
        free_entries=int(agent.free.sum()) * ACTIONS,
    )


def replay_of(tables: Tables, maze: Maze) -> Replay:
    """Return the experiences that the loop counted as a replay buffer."""
    replay = Replay()
    for number, action in np.argwhere(tables.counts > 0).tolist():
        cell = Cell(*divmod(number, maze.cols))
        next_cell = maze.moved(cell, action)
        experience = Experience(cell, action, next_cell, next_cell == cell)
        replay.add(experience, int(tables.counts[number, action]))
    return replay


def first_state(seed: int) -> int:
    """Return the first state of the loop's random numbers: 64 bits, never 0."""
    return int(stream(seed, "explore").integers(1, 2**63))


class MazeLoop:
    """An agent, a maze, and everything the compiled loop needs of them."""

    def __init__(self, agent: Agent, maze: Maze, seed: int, trials_per_call: int = 500) -> None:
        self.agent, self.maze = agent, maze
        self.tables, self.ways, self.rules = tables_of(agent), ways_of(maze), rules_of(agent)
        n, goals = trials_per_call, len(agent.goal_names)
        self.columns = Columns(
            np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.bool_), np.zeros((n, goals))
        )
        self.state: StateArray = np.array([agent.progress.explore_state or first_state(seed)], dtype=np.uint64)

    def run(self) -> tuple[Columns, bool]:
        """Run trials at the current goal of the agent's progress, and bring agent and progress up to date.

        Returns:
            One row per trial, and whether the goal is learned.
        """
        agent, progress = self.agent, self.agent.progress
        # Summed anew at each call, so that the rounding of the running sum cannot build up.
        self.tables.td_sum[:] = agent.td_error_of_goals() * self.rules.free_entries
        clock = np.array([agent.steps_since_sweep, agent.sweeps])
        trials, agent.temperature, learned = run_trials(
            self.tables,
            self.ways,
            self.rules,
            self.columns,
            progress.consecutive,
            progress.window,
            progress.goal,
            progress.next_start,
            agent.temperature,
            clock,
            self.state,
        )
        agent.steps_since_sweep, agent.sweeps = int(clock[0]), int(clock[1])
        start, steps, reached, td_errors = self.columns
        rows = Columns(start[:trials].copy(), steps[:trials].copy(), reached[:trials].copy(), td_errors[:trials].copy())
        progress.next_start = (progress.next_start + trials) % len(self.ways.start_cells)
        progress.explore_state = int(self.state[0])
        progress.trial += trials
        progress.step += int(rows.steps.sum())
        progress.trials_of_goal[progress.goal] += trials
        progress.steps_of_goal[progress.goal] += int(rows.steps.sum())
        return rows, learned

    def close(self) -> None:
        """Hand the counted experiences back to the agent."""
        self.agent.replay = replay_of(self.tables, self.maze)
