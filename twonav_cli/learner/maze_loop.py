"""An agent in a maze with the compiled trials: every learner runs through here, by whole trials or single actions.

N cells numbered row by row, A = 4 actions, G goals, S starts, n trials of a call.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.draws import ACTIONS, StateArray, first_state, gumbel_noise
from twonav_cli.learner.maze_kernel import (
    CELL,
    EXPLORED,
    MULTI,
    NEAREST,
    NOBODY,
    OPTIMAL_AT,
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
)
from twonav_cli.learner.maze_trials import run_trials
from twonav_cli.learner.nearest_untried import plan
from twonav_cli.learner.prioritized_sweeping import queue_all
from twonav_cli.learner.replay import Experience, Replay
from twonav_cli.maze import OFFSETS, Maze

STRATEGIES = {
    "single": SINGLE,
    "multi": MULTI,
    "optimistic": MULTI,
    "prioritized-sweeping": PRIORITIZED,
    "nearest-untried": NEAREST,
    "oracle": MULTI,
}
"""Learner to what the compiled loop does after an action; optimistic and oracle differ from multi in their settings."""

NO_LIMIT = 2**62


class Advance(NamedTuple):
    """Where a run stands after `MazeLoop.advance`."""

    cell: Cell
    start: Cell
    goal: int
    steps_in_trial: int
    rows: Columns
    learned: bool


def tables_of(agent: Agent) -> Tables:
    """Return the agent's tables as the loop sees them; q and td share their memory with the agent's."""
    rows, cols, actions, goals = agent.q.shape
    cells = rows * cols
    shape = (cells, actions, goals)
    counts = np.zeros((cells, actions), dtype=np.int64)
    for (cell, action, _next, _blocked), number in agent.replay.counts.items():
        counts[cell.row * cols + cell.col, action] += number
    q, td = agent.q.reshape(shape), agent.td.reshape(shape)
    return Tables(q, td, np.zeros(goals), counts, np.zeros((cells, goals)), np.zeros(cells * actions), gumbel_noise())


def ways_of(maze: Maze, rules: Rules) -> Ways:
    """Return what every action leads to and earns; a blocked cell leads nowhere."""
    cells = maze.rows * maze.cols
    numbers = np.arange(cells).reshape(maze.rows, maze.cols)
    next_cell = np.repeat(numbers.reshape(-1, 1), ACTIONS, axis=1)
    into = np.full((cells, 2 * ACTIONS), NOBODY)
    framed = np.pad(~maze.blocked, 1)
    for action, (d_row, d_col) in enumerate(OFFSETS):
        onward_free = framed[1 + d_row : 1 + d_row + maze.rows, 1 + d_col : 1 + d_col + maze.cols]
        moves = numbers[~maze.blocked & onward_free]
        next_cell[moves, action] = moves + d_row * maze.cols + d_col
        into[next_cell[moves, action], action] = moves * ACTIONS + action
        bumps = numbers[~maze.blocked & ~onward_free]
        into[bumps, ACTIONS + action] = bumps * ACTIONS + action
    goal_cells = np.array([numbers[cell] for cell in maze.goals.values()])
    start_cells = np.array([numbers[cell] for cell in maze.starts.values()], dtype=np.int64)
    to_goals = np.stack([maze.distances_to(cell).reshape(-1) for cell in maze.goals.values()], axis=1)
    distance = np.ascontiguousarray(to_goals, dtype=np.int64)
    reward, discount = np.full((cells + 1, len(goal_cells)), rules.reward_step), np.full(distance.shape, rules.discount)
    reward[goal_cells, range(len(goal_cells))], discount[goal_cells, range(len(goal_cells))] = rules.reward_goal, 0.0
    reward[cells] = rules.reward_blocked
    reward_row = np.where(next_cell == numbers.reshape(-1, 1), cells, next_cell)
    shortest = distance[start_cells]
    return Ways(next_cell, into, goal_cells, start_cells, reward, reward_row, discount, distance, shortest)


def rules_of(agent: Agent) -> Rules:
    """Return the agent's settings as the loop reads them."""
    config, rewards = agent.config, agent.config.rewards
    return Rules(
        strategy=STRATEGIES[config.learner],
        learning_rate=float(config.learning_rate),
        sweep_rate=float(config.sweep_rate),
        discount=float(config.discount),
        reward_goal=float(rewards.goal),
        reward_blocked=float(rewards.blocked),
        reward_step=float(rewards.step),
        is_boltzmann=config.exploration == "boltzmann",
        epsilon=float(config.epsilon),
        decay=float(config.temperature_decay),
        period=int(config.replay_period_steps),
        backups=int(config.backups_per_step),
        limit=int(config.trial_limit_steps),
        max_step_difference=float(config.max_step_difference),
        free_entries=int(agent.free.sum()) * ACTIONS,
    )


def replay_of(counts: IntArray, ways: Ways, cols: int) -> Replay:
    """Return counted experiences [N, A] as a replay buffer, for a maze of so many columns."""
    cells, actions = np.nonzero(counts)
    rows = zip(cells.tolist(), actions.tolist(), ways.next_cell[cells, actions].tolist(), strict=True)
    replay = Replay()
    for (cell, action, onward), number in zip(rows, counts[cells, actions].tolist(), strict=True):
        here, there = Cell(*divmod(cell, cols)), Cell(*divmod(onward, cols))
        replay.counts[Experience(here, action, there, onward == cell)] = number
    return replay


def columns_of(trials: int, goals: int) -> Columns:
    """Return empty columns."""
    whole = np.zeros(trials, dtype=np.int64)
    return Columns(whole, whole.copy(), np.zeros(trials, dtype=np.bool_), np.zeros((trials, goals)))


class MazeLoop:
    """An agent, a maze, and everything the compiled loop needs of them.

    Attributes:
        agent: Learns in place.
        maze: The agent's.
        ways: What the loop knows of the maze.
    """

    def __init__(self, agent: Agent, maze: Maze, seed: int, trials_per_call: int = 500) -> None:
        self.agent, self.maze = agent, maze
        self.tables, self.rules = tables_of(agent), rules_of(agent)
        self.ways = ways_of(maze, self.rules)
        self.columns = columns_of(trials_per_call, len(agent.goal_names))
        progress = agent.progress
        self.state: StateArray = np.array([progress.explore_state or first_state(seed)], dtype=np.uint64)
        self.at: IntArray = np.full(10, NOBODY, dtype=np.int64)
        self.at[EXPLORED] = int(self.rules.strategy != NEAREST)
        self._goal_begun = (
            progress.goal if progress.goal != NOBODY and progress.trials_of_goal[progress.goal] else NOBODY
        )
        self._put_away = np.zeros_like(self.tables.counts)
        self._sum_td_errors()
        if agent.config.learner == "oracle" and progress.step == 0:
            everything = np.repeat(agent.free.reshape(-1, 1), ACTIONS, axis=1).astype(np.int64)
            plan(self.tables.q, everything, self.ways, self.rules)
        elif self.rules.strategy == PRIORITIZED:
            queue_all(self.tables, self.ways, self.rules, self.at)

    def run(self) -> tuple[Columns, bool]:
        """Run trials at the current goal of the agent's progress, and bring agent and progress up to date.

        Returns:
            One row per trial, and whether the goal is learned.
        """
        return self._run(NO_LIMIT, len(self.columns.start))

    def advance(self, actions: int, trials: int | None = None) -> Advance:
        """Run at most so many actions (and trials) at the current goal; the sum of calls is what `run` does.

        Args:
            actions: May end inside a trial, which the next call goes on with.
            trials: The size of a call when None.
        """
        at_most = len(self.columns.start) if trials is None else min(trials, len(self.columns.start))
        rows, learned = self._run(actions, at_most)
        between = self.at[TAKEN] == NOBODY
        start = list(self.maze.starts.values())[int(self.at[START])]
        cell = start if between else Cell(*divmod(int(self.at[CELL]), self.maze.cols))
        return Advance(cell, start, self.agent.progress.goal, 0 if between else int(self.at[TAKEN]), rows, learned)

    @property
    def in_trial(self) -> bool:
        """Whether the last call ended inside a trial."""
        return bool(self.at[TAKEN] != NOBODY)

    def visits(self) -> IntArray:
        """Return how often every action was taken in every cell [R, C, A]."""
        return (self.tables.counts + self._put_away).reshape(self.maze.rows, self.maze.cols, ACTIONS)

    def _run(self, actions: int, trials: int) -> tuple[Columns, bool]:
        agent, progress, at = self.agent, self.agent.progress, self.at
        if progress.goal == NOBODY:
            raise TwonavError("no goal is chosen yet: choose one with `Agent.begin_goal`")
        if len(agent.goal_names) != self.tables.q.shape[2]:
            raise TwonavError("a goal was added to the agent: make a new MazeLoop, with a maze that has it too")
        if progress.goal != self._goal_begun:
            self._begin_goal()
        at[SINCE_SWEEP], at[SWEEPS], at[STEP] = agent.steps_since_sweep, agent.sweeps, progress.step
        at[OPTIMAL_AT] = progress.optimal_at
        if not self.in_trial:
            at[START] = progress.next_start
        ended, agent.temperature, learned = run_trials(
            self.tables,
            self.ways,
            self.rules,
            self.columns,
            progress.consecutive,
            progress.window,
            progress.goal,
            agent.temperature,
            at,
            self.state,
            actions,
            trials,
        )
        rows = self._first_rows(ended)
        self._bring_up_to_date(ended, progress.step)
        return rows, bool(learned)

    def _first_rows(self, ended: int) -> Columns:
        """Return the rows of the trials that ended, with means for the sums of TD errors.

        Rounding can leave a sum just below zero.
        """
        start, steps, reached, td_sums = self.columns
        td_errors = np.maximum(td_sums[:ended], 0.0) / self.rules.free_entries
        return Columns(start[:ended].copy(), steps[:ended].copy(), reached[:ended].copy(), td_errors)

    def _sum_td_errors(self) -> None:
        """Sum the TD errors anew, at each goal: so rounding cannot build up, and does not depend on the calls."""
        self.tables.td_sum[:] = self.agent.td_error_of_goals() * self.rules.free_entries

    def _begin_goal(self) -> None:
        """Note a new goal; with one goal at a time, what was experienced for another one is put away."""
        self._goal_begun = self.agent.progress.goal
        self.at[TAKEN] = NOBODY
        self._sum_td_errors()
        if self.rules.strategy == SINGLE:
            self._put_away += self.tables.counts
            self.tables.counts[:] = 0
            self.agent.steps_since_sweep = 0

    def _bring_up_to_date(self, ended: int, steps_before: int) -> None:
        agent, progress, at = self.agent, self.agent.progress, self.at
        agent.steps_since_sweep, agent.sweeps = int(at[SINCE_SWEEP]), int(at[SWEEPS])
        progress.next_start = int(at[START])
        progress.explore_state = int(self.state[0])
        progress.trial += ended
        progress.step, progress.optimal_at = int(at[STEP]), int(at[OPTIMAL_AT])
        progress.trials_of_goal[progress.goal] += ended
        progress.steps_of_goal[progress.goal] += progress.step - steps_before

    def hand_over_replay(self) -> None:
        """Give the agent what was counted so far, so that it can be saved; the loop may go on."""
        self.agent.replay = replay_of(self.tables.counts, self.ways, self.maze.cols)

    def close(self) -> None:
        """Hand the counted experiences back to the agent; what was put away stays of use for new goals."""
        self.hand_over_replay()
        for experience, number in replay_of(self._put_away, self.ways, self.maze.cols).counts.items():
            self.agent.earlier_here.add(experience, number)
        self._put_away[:] = 0
