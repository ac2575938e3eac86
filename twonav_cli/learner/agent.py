"""The multi-goal Q-learning agent: its tables, its replay buffer, and where its learning stands.

R rows, C columns, A = 4 actions, G goals, S starts, W trials of the confirmation window. Goals are innermost in memory:
one action updates all of them.
"""

from __future__ import annotations

import re
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.checkpoint import load_checkpoint, save_checkpoint
from twonav_cli.config import LearningConfig, Rewards
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell
from twonav_cli.learner.exploration import COLDEST, COOLINGS, EXPLORATIONS, explored_action, greedy_action
from twonav_cli.learner.goals import GOAL_SELECTIONS, Progress, goals_at, rewards_of_goals
from twonav_cli.learner.learners import LEARNERS
from twonav_cli.learner.q_learning import squared_td_errors, td_targets, updated_q_of_goals
from twonav_cli.learner.relabel import NewGoal, cells_where, remembered, tried_entries, values_from_rows
from twonav_cli.learner.replay import ROW_LENGTH, Experience, Replay, sweep
from twonav_cli.maze import Action, Maze
from twonav_cli.rng import stream

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]

NAME_LETTERS = 40
"""Length of a new goal's name at most: it must fit where goals are listed (ours)."""


LARGEST_Q = 1e6
"""Size of the first Q value at which squared TD errors are still told apart from one another (ours)."""


def checked(config: LearningConfig) -> LearningConfig:
    """Return the settings unchanged.

    Raises:
        TwonavError: One of them is out of its range.
    """
    ranges = (
        ("learning_rate", 0 < config.learning_rate <= 1, "above 0 and at most 1"),
        ("replay_learning_rate", 0 < config.sweep_rate <= 1, "above 0 and at most 1"),
        ("discount", 0 <= config.discount < 1, "at least 0 and below 1"),
        ("temperature", COLDEST <= config.temperature < np.inf, f"at least {COLDEST:g}"),
        ("temperature_decay", 0 < config.temperature_decay <= 1, "above 0 and at most 1"),
        ("epsilon", 0 <= config.epsilon <= 1, "between 0 and 1"),
        ("replay_period_steps", config.replay_period_steps >= 1, "at least 1"),
        ("replay_batch", config.replay_batch >= 1, "at least 1"),
        ("backups_per_step", config.backups_per_step >= 1, "at least 1"),
        ("trial_limit_steps", config.trial_limit_steps >= 1, "at least 1"),
        ("consecutive_successes", config.consecutive_successes >= 1, "at least 1"),
        ("max_step_difference", config.max_step_difference > 0, "above 0"),
        ("initial_q", abs(config.initial_q) <= LARGEST_Q, f"between -{LARGEST_Q:g} and {LARGEST_Q:g}"),
        ("initial_td_error", 0 <= config.initial_td_error < np.inf, "at least 0"),
        ("rewards", bool(np.isfinite(list(asdict(config.rewards).values())).all()), "finite numbers"),
    )
    for name, right, range_text in ranges:
        if not right:
            raise TwonavError(f"{name.replace('_', ' ')} must be {range_text}: {getattr(config, name)} was given")
    if config.learner not in LEARNERS:
        raise unknown_name("learner", config.learner, LEARNERS)
    if config.exploration not in EXPLORATIONS:
        raise unknown_name("exploration", config.exploration, EXPLORATIONS)
    if config.cooling not in COOLINGS:
        raise unknown_name("cooling", config.cooling, COOLINGS)
    if config.goal_selection not in GOAL_SELECTIONS:
        raise unknown_name("goal selection", config.goal_selection, GOAL_SELECTIONS)
    return config


class Agent:
    """A table of values per goal, learned for all goals from every action.

    Attributes:
        q: [R, C, A, G] values.
        td: [R, C, A, G] squared TD error of the latest visit (Eq. 3); `initial_td_error` before the first.
        free: [R, C] cells that count in `td_error_of_goals`.
        config: Settings.
        goal_names: [G].
        goal_cells: [G].
        temperature: Of Eq. 6, now.
        replay: Every experience of this run; of the single-goal learner, of the current goal.
        earlier_here: Other experience in this stage: only `add_goal` uses it, it is neither swept nor saved.
        earlier_elsewhere: The same of the stage before; what was tried in this one counts instead of it.
        progress: Where a learning run stands.
    """

    def __init__(
        self, free: BoolArray, goals: dict[str, Cell], starts: int, config: LearningConfig, seed: int = 0
    ) -> None:
        """Make an untrained agent.

        Args:
            free: [R, C].
            goals: Name to cell.
            starts: Number of starts, S.
            config: Settings.
            seed: Of the shuffles of the replay buffer.

        Raises:
            TwonavError: No goal, or a setting out of its range.
        """
        if not goals:
            raise TwonavError("there is no goal to learn: add one to the scene")
        shape = (*free.shape, len(Action), len(goals))
        self.config = checked(config)
        self.free = free.copy()
        self.goal_names, self.goal_cells = list(goals), list(goals.values())
        self.seed = seed
        self.q: FloatArray = np.full(shape, config.initial_q, dtype=np.float64)
        self.td: FloatArray = np.where(free[..., None, None], config.initial_td_error, 0.0) * np.ones(shape)
        self.temperature = config.temperature
        self.replay = Replay()
        self.earlier_here, self.earlier_elsewhere = Replay(), Replay()
        self.steps_since_sweep = 0
        self.sweeps = 0
        self.progress = Progress.fresh(len(goals), starts, config.consecutive_successes)

    @classmethod
    def for_maze(cls, maze: Maze, config: LearningConfig, seed: int = 0) -> Agent:
        """Return an untrained agent for the goals and starts of a maze."""
        return cls(~maze.blocked, maze.goals, len(maze.starts), config, seed)

    def check_fits(self, maze: Maze) -> None:
        """Make sure that the tables are those of a maze.

        Raises:
            TwonavError: Other walls, other goals or another order of them, or another number of starts.
        """
        if self.free.shape != maze.blocked.shape:
            raise TwonavError(
                f"the agent's table has {self.free.shape[0]} x {self.free.shape[1]} cells, the maze "
                f"{maze.rows} x {maze.cols}: train an agent for this maze"
            )
        if not np.array_equal(self.free, ~maze.blocked):
            raise TwonavError(
                "the agent was trained between other walls than the maze has: train an agent for this maze"
            )
        if list(zip(self.goal_names, self.goal_cells, strict=True)) != list(maze.goals.items()):
            raise TwonavError("the agent was trained for other goals than the maze has: train an agent for this maze")
        if len(self.progress.consecutive) != len(maze.starts):
            raise TwonavError("the agent was trained from another number of starts: train an agent for this maze")

    def values(self, cell: Cell, goal: int) -> FloatArray:
        """Return the values [A] of the actions in a cell."""
        return self.q[cell.row, cell.col, :, goal].copy()

    def choose(self, cell: Cell, goal: int, rng: np.random.Generator, explore: bool = True) -> tuple[int, bool]:
        """Return the next action, and whether it is a greedy one.

        Args:
            cell: Where the agent believes to be.
            goal: Index of the goal.
            rng: Stream "explore".
            explore: False draws among the actions of largest value only.
        """
        values = self.values(cell, goal)
        if explore:
            action = explored_action(self.config.exploration, values, self.temperature, self.config.epsilon, rng)
        else:
            action = greedy_action(values, rng)
        return action, bool(values[action] == values.max())

    def targets(self, cell: Cell, next_cell: Cell, blocked: bool) -> FloatArray:
        """Return the target of every goal [G] for one action from `cell`."""
        rewards = rewards_of_goals(self.config.rewards, cell, next_cell, blocked, self.goal_cells)
        arrived = goals_at(next_cell, self.goal_cells)
        return td_targets(rewards, self.q[next_cell], arrived, self.config.discount)

    def td_errors(self, cell: Cell, action: int, next_cell: Cell, blocked: bool) -> FloatArray:
        """Return the squared TD error of every goal [G] for one action, learning nothing (Eq. 3)."""
        return squared_td_errors(self.q[(*cell, action)], self.targets(cell, next_cell, blocked))

    def observe(self, cell: Cell, action: int, next_cell: Cell, blocked: bool) -> FloatArray:
        """Learn from one action for every goal at once (Eq. 2, Eq. 3), and sweep the replay buffer when due.

        Returns:
            [G] squared TD errors of this action.
        """
        targets = self.targets(cell, next_cell, blocked)
        errors = squared_td_errors(self.q[(*cell, action)], targets)
        self.td[(*cell, action)] = errors
        self.q[(*cell, action)] = updated_q_of_goals(self.q[(*cell, action)], targets, self.config.learning_rate)
        self.replay.add(Experience(cell, action, next_cell, blocked))
        self.steps_since_sweep += 1
        if self.steps_since_sweep >= self.config.replay_period_steps:
            sweep(self.q, self.replay, self.goal_cells, self.config, stream(self.seed, "replay", self.sweeps))
            self.steps_since_sweep = 0
            self.sweeps += 1
        return errors

    def greedy_actions(self, goal: int) -> NDArray[np.int64]:
        """Return the first action of largest value in every cell [R, C]."""
        return np.asarray(self.q[..., goal].argmax(axis=2), dtype=np.int64)

    def td_error_of_goals(self) -> FloatArray:
        """Return the TD error of every goal [G]: the mean over the free cells' entries, visited or not.

        A maximum would not tell the goals apart: an entry is visited for all goals at once, so while one of them is
        unvisited every goal's maximum is the initial value.
        """
        return np.asarray(self.td[self.free].mean(axis=(0, 1)), dtype=np.float64)

    def table(self) -> FloatArray:
        """Return a copy of the values as [G, R, C, A]."""
        return np.ascontiguousarray(np.moveaxis(self.q, 3, 0))

    def td_table(self) -> FloatArray:
        """Return the squared TD errors of the latest visits as [G, R, C, A], not a number where there was none.

        An entry that has its initial value was never visited; an initial value of 0 cannot be told from a visit.
        """
        untried = (self.td == self.config.initial_td_error) & (self.config.initial_td_error > 0)
        return np.ascontiguousarray(np.moveaxis(np.where(untried, np.nan, self.td), 3, 0))

    def add_goal(self, cell: Cell, name: str | None = None) -> NewGoal:
        """Add a goal and learn its values from what was experienced, with no step in the environment (ours, after §2).

        Its values are those of `values_from_experience`; its TD errors are 0 where an action was tried. A `MazeLoop`
        that was made before refuses to go on.

        Args:
            cell: A free cell; another goal may lie there too.
            name: Of letters, digits, - and _, blanks inside; None for "goal-N".

        Raises:
            TwonavError: The cell is blocked or outside, the name is taken or odd, or nothing was experienced yet.
        """
        name = self._name_of_new(name)
        inside = 0 <= cell[0] < self.free.shape[0] and 0 <= cell[1] < self.free.shape[1]
        if not inside or not self.free[cell]:
            raise TwonavError(f"goal {name!r} would lie in the blocked cell {tuple(cell)}: choose a free one")
        rows = remembered(self.free, (self.replay, self.earlier_here), self.earlier_elsewhere)
        if len(rows) == 0:
            raise TwonavError("the agent has experienced nothing yet that a goal could be learned from: train it first")
        q, has_way = values_from_rows(self.free, rows, cell, self.config)
        untried: BoolArray = self.free[..., None] & ~tried_entries(self.free, rows)  # (R, C, A)
        td = np.where(untried, self.config.initial_td_error, 0.0)
        self.q = np.concatenate((self.q, q[..., None]), axis=3)
        self.td = np.concatenate((self.td, td[..., None]), axis=3)
        self.goal_names.append(name)
        self.goal_cells.append(Cell(*cell))
        self.progress.learned = np.append(self.progress.learned, False)
        self.progress.trials_of_goal.append(0)
        self.progress.steps_of_goal.append(0)
        return NewGoal(
            len(self.goal_names) - 1, name, cells_where(self.free & ~has_way),
            cells_where(np.logical_or.reduce(untried, axis=2)), int(rows[:, -1].sum()),
        )  # fmt: skip

    def _name_of_new(self, name: str | None) -> str:
        """Return the name of a goal that is added; upper and lower case do not tell two apart."""
        taken = {known.casefold() for known in self.goal_names}
        if name is None:
            return next(f"goal-{i}" for i in range(len(taken) + 1, 2 * len(taken) + 2) if f"goal-{i}" not in taken)
        if len(name) > NAME_LETTERS or not re.fullmatch(r"\w(?:[\w -]*\w)?", name):
            raise TwonavError(
                f"{name!r} is no name for a goal: use up to {NAME_LETTERS} letters and digits, with - or _ between"
            )
        if name.casefold() in taken:
            raise TwonavError(f"there is a goal {name!r} already: choose another name")
        return name

    def begin_goal(self, goal: int) -> None:
        """Turn to a goal: its confirmation starts at zero, and the temperature at its first value.

        The paper does not say whether T goes on cooling from goal to goal. By default it starts anew, since only then
        does a discount of 0.99 take about the paper's 84 thousand actions in the random mazes (Table 5); cooling on
        takes 47, but gives Tables 7 and 8 their shape. The single-goal learner is a new one for every goal.
        """
        self.progress.begin_goal(goal)
        if self.config.cooling == "per-goal" or self.config.learner == "single":
            self.temperature = self.config.temperature

    def end_trial(self) -> None:
        """Cool down after a trial (§4.3)."""
        self.temperature = max(self.temperature * self.config.temperature_decay, COLDEST)

    def save(self, folder: Path, card: dict[str, Any]) -> Path:
        """Write the agent so that `load` goes on as if unbroken (prioritized sweeping: with a queue made anew).

        Args:
            folder: Where to.
            card: "scene", "scene_digest", "map_digest", "command", "seed" and "metrics".

        Raises:
            TwonavError: The table holds a value that is not finite, or the folder cannot be written.
        """
        if not (np.isfinite(self.q).all() and np.isfinite(self.td).all()):
            raise TwonavError("the agent's table holds a value that is not a number, so it is not saved: train again")
        progress = asdict(self.progress)
        arrays = {"q": self.q, "td": self.td, "free": self.free, "replay": self.replay.to_array()}
        arrays |= {name: progress.pop(name) for name in ("learned", "consecutive", "window")}
        state = {
            "goals": [[name, *cell] for name, cell in zip(self.goal_names, self.goal_cells, strict=True)],
            "settings": asdict(self.config),
            "progress": progress,
            "agent_seed": self.seed,
            "temperature": self.temperature,
            "steps_since_sweep": self.steps_since_sweep,
            "sweeps": self.sweeps,
        }
        return save_checkpoint(folder, arrays, {**card, **state, "kind": "agent"})

    @classmethod
    def load(
        cls,
        folder: Path,
        scene_digest: str | None = None,
        map_digest: str | None = None,
        config: LearningConfig | None = None,
    ) -> Agent:
        """Read an agent.

        Args:
            folder: Where `save` wrote it.
            scene_digest: The scene it must have been made for, unless None.
            map_digest: The map it must have been made for, unless None.
            config: None to go on with the saved run. Settings of another stage keep the tables and begin a new run:
                no goal learned yet, an empty replay buffer (what happened elsewhere may not happen here; the saved one
                becomes `earlier_elsewhere`), T anew.

        Raises:
            TwonavError: Missing, damaged, made for something else, or tables of the wrong shape.
        """
        arrays, card = load_checkpoint(folder, "agent", scene_digest, map_digest)
        try:
            agent = _agent_from(arrays, card, config)
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            raise TwonavError(f"the agent in {folder} is incomplete ({error}): train it again") from error
        return agent


def saved_settings(card: dict[str, Any]) -> LearningConfig:
    """Return the settings on an agent's card; those that it does not name are the usual ones.

    Raises:
        KeyError, TypeError: It has none, or they are of another version.
    """
    settings = dict(card["settings"])
    return LearningConfig(**{**settings, "rewards": Rewards(**settings["rewards"])})


def _agent_from(arrays: dict[str, NDArray[Any]], card: dict[str, Any], config: LearningConfig | None) -> Agent:
    goals = {str(name): Cell(int(row), int(col)) for name, row, col in card["goals"]}
    saved = saved_settings(card)
    starts, seed = len(arrays["consecutive"]), int(card["agent_seed"])
    agent = Agent(arrays["free"].astype(np.bool_), goals, starts, config or saved, seed)
    for name in ("q", "td"):
        expected = getattr(agent, name)
        if arrays[name].shape != expected.shape:
            raise TwonavError(
                f"the agent's table {name!r} has the shape {arrays[name].shape} where {expected.shape} is needed: "
                "train it again"
            )
        if not np.isfinite(arrays[name]).all():
            raise TwonavError(f"the agent's table {name!r} holds a value that is not a number: train it again")
        expected[:] = arrays[name]
    for cell in agent.goal_cells:
        if not agent.free[cell]:
            raise ValueError(f"goal in the blocked cell {tuple(cell)}")
    if config is None:
        _resume(agent, arrays, card)
    else:
        agent.earlier_elsewhere = Replay.from_array(arrays["replay"].reshape(-1, ROW_LENGTH))
    return agent


def _resume(agent: Agent, arrays: dict[str, NDArray[Any]], card: dict[str, Any]) -> None:
    fresh = agent.progress
    saved = {name: arrays[name] for name in ("learned", "consecutive", "window")}
    for name, array in saved.items():
        if array.shape != getattr(fresh, name).shape:
            raise ValueError(f"{name} has the wrong shape")
    agent.progress = Progress(**{**saved, **card["progress"]})
    agent.replay = Replay.from_array(arrays["replay"].reshape(-1, ROW_LENGTH))
    agent.temperature = float(card["temperature"])
    agent.steps_since_sweep, agent.sweeps = int(card["steps_since_sweep"]), int(card["sweeps"])
