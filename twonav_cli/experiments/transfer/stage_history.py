"""What is kept of an agent's learning in a stage: every trial, and how it drove afterwards. It stands in its card.

n trials, G goals.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from twonav_cli.events import Event, GoalChosen, TrialBatch, TrialEnded
from twonav_cli.experiments.learning_run import LearningRun, shortest_ways
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Maze


@dataclass
class StageHistory:
    """The trials of a learning run; a sink that notes them.

    Attributes:
        goals: Names of all goals.
        goal_order: Goals in the order of training.
        trial_goals: [n] number of the goal that each trial was for.
        trial_steps: [n] actions of each trial.
        trial_reached: [n] whether it ended at its goal.
        wall_s: Time that learning took.
    """

    goals: list[str]
    goal_order: list[str] = field(default_factory=list)
    trial_goals: list[int] = field(default_factory=list)
    trial_steps: list[int] = field(default_factory=list)
    trial_reached: list[bool] = field(default_factory=list)
    wall_s: float = 0.0

    def __call__(self, event: Event) -> None:
        """Note a trial, a batch of them, or a chosen goal."""
        if isinstance(event, TrialEnded):
            self.trial_goals.append(self.goals.index(event.goal))
            self.trial_steps.append(event.steps)
            self.trial_reached.append(event.outcome == "reached")
        elif isinstance(event, TrialBatch):
            self.trial_goals += [int(goal) for goal in event.goal]
            self.trial_steps += [int(steps) for steps in event.steps]
            self.trial_reached += [bool(reached) for reached in event.reached]
        elif isinstance(event, GoalChosen):
            self.goal_order.append(event.goal)

    @classmethod
    def of_card(cls, card: dict[str, Any], goals: list[str]) -> StageHistory:
        """Return the history that an agent's card holds; an empty one where it holds none."""
        kept = card.get("metrics", {}).get("history")
        return cls(goals, **kept) if kept else cls(goals)

    def kept(self) -> dict[str, Any]:
        """Return what the card must hold."""
        return {
            "goal_order": self.goal_order,
            "trial_goals": self.trial_goals,
            "trial_steps": self.trial_steps,
            "trial_reached": self.trial_reached,
            "wall_s": round(self.wall_s, 2),
        }

    def learning_run(self, agent: Agent, maze: Maze) -> LearningRun:
        """Return the history as the figures about learning take it.

        Args:
            agent: As it was afterwards.
            maze: Where it learned.
        """
        progress, shortest = agent.progress, shortest_ways(maze)
        order = np.array([self.goals.index(goal) for goal in self.goal_order], dtype=np.int64)
        ranks = np.full(len(self.goals), -1, dtype=np.int16)
        ranks[order] = np.arange(len(order))
        return LearningRun(
            learner=agent.config.learner,
            outcome="learned" if progress.learned.all() else "gave-up",
            steps=progress.step,
            trials=progress.trial,
            floor_steps=agent.config.consecutive_successes * int(shortest.sum()),
            optimal_at=-1,
            goal_order=order,
            trials_of_goal=np.array(progress.trials_of_goal)[order],
            steps_of_goal=np.array(progress.steps_of_goal)[order],
            shortest_of_goal=shortest.mean(axis=1)[order],
            trial_steps=np.array(self.trial_steps, dtype=np.int32),
            trial_goal_rank=ranks[np.array(self.trial_goals, dtype=np.int64)],
        )
