"""One learning run from an untrained agent to the end, as plain arrays that travel between processes.

G goals, n trials. A goal's rank says when it was trained: 0 is the first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import LearningConfig
from twonav_cli.events import Event, GoalChosen, TrialBatch
from twonav_cli.experiments.maze_learning import MAZE_STEPS_AT_MOST, learn_maze
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Maze

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class LearningRun:
    """How learning a maze went.

    Attributes:
        learner: A key of LEARNERS.
        outcome: "learned", "gave-up" (the limit of actions) or "stopped" (asked to).
        steps: Actions over the whole run, confirmation included.
        trials: Trials over the whole run.
        floor_steps: Actions of the confirmation trials alone, were every one a shortest way (ours).
        optimal_at: Actions after which the greedy ways of all pairs were shortest for the first time; -1: never.
        goal_order: [G] index of each goal, in the order of training; shorter when the run did not get to all.
        trials_of_goal: [G] trials spent on each goal, in that order.
        steps_of_goal: [G] actions spent on each goal, in that order.
        shortest_of_goal: [G] mean shortest way from the starts to each goal, in that order.
        trial_steps: [n] actions of each trial.
        trial_goal_rank: [n] rank of the goal that each trial was for.
    """

    learner: str
    outcome: str
    steps: int
    trials: int
    floor_steps: int
    optimal_at: int
    goal_order: IntArray
    trials_of_goal: IntArray
    steps_of_goal: IntArray
    shortest_of_goal: FloatArray
    trial_steps: NDArray[np.int32]
    trial_goal_rank: NDArray[np.int16]

    @property
    def learned(self) -> bool:
        """Whether every goal met the criterion."""
        return self.outcome == "learned"


def never() -> bool:
    """Ask nobody to stop."""
    return False


def run_learner(
    maze: Maze,
    config: LearningConfig,
    seed: int,
    should_stop: Callable[[], bool] = never,
    steps_at_most: int = MAZE_STEPS_AT_MOST,
) -> LearningRun:
    """Learn every goal of a maze with a fresh agent (§4.3).

    Args:
        maze: With its goals and starts.
        config: Which learner, and its settings.
        seed: Of everything random in the run.
        should_stop: Asked every few hundred trials.
        steps_at_most: Actions after which the run gives up.

    Raises:
        TwonavError: A setting is out of its range, or a goal cannot be reached.
    """
    agent = Agent.for_maze(maze, config, seed)
    chosen: list[int] = []
    batches: list[TrialBatch] = []

    def note(event: Event) -> None:
        if isinstance(event, TrialBatch):
            batches.append(event)
        elif isinstance(event, GoalChosen):
            chosen.append(agent.goal_names.index(event.goal))

    outcome = learn_maze(agent, maze, seed, note, should_stop, steps_at_most)
    order = np.array(chosen, dtype=np.int64)
    shortest = shortest_ways(maze)
    return LearningRun(
        learner=config.learner,
        outcome=outcome.outcome,
        steps=outcome.steps,
        trials=outcome.trials,
        floor_steps=config.consecutive_successes * int(shortest.sum()),
        optimal_at=outcome.optimal_at,
        goal_order=order,
        trials_of_goal=np.array(list(outcome.trials_of_goal.values()))[order],
        steps_of_goal=np.array(list(outcome.steps_of_goal.values()))[order],
        shortest_of_goal=shortest.mean(axis=1)[order],
        trial_steps=_joined([batch.steps for batch in batches]).astype(np.int32),
        trial_goal_rank=_ranks(order, len(shortest))[_joined([batch.goal for batch in batches])],
    )


def shortest_ways(maze: Maze) -> IntArray:
    """Return the length of the shortest way to every goal from every start [G, S]."""
    rows, cols = np.array(list(maze.starts.values())).T
    return np.array([maze.distances_to(goal)[rows, cols] for goal in maze.goals.values()], dtype=np.int64)


def _ranks(order: IntArray, goals: int) -> NDArray[np.int16]:
    """Return when each goal was trained [G], -1 for those that were not."""
    ranks = np.full(goals, -1, dtype=np.int16)
    ranks[order] = np.arange(len(order))
    return ranks


def _joined(columns: list[IntArray]) -> IntArray:
    return np.concatenate(columns) if columns else np.zeros(0, dtype=np.int64)
