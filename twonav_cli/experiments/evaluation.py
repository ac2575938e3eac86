"""Every goal from every start, and the figures that navigation is measured by."""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from twonav_cli.events import Clock, Sink
from twonav_cli.experiments.trials import TrialResult, run_trial
from twonav_cli.learner.agent import Agent
from twonav_cli.rng import stream
from twonav_cli.stages.stage import Stage


@dataclass(frozen=True)
class PairResult:
    """One goal from one start."""

    goal: str
    start: str
    success: bool
    outcome: str
    actions: int
    shortest: int
    cause: str
    collisions: int = 0


@dataclass
class PairTable:
    """All pairs driven so far."""

    pairs: list[PairResult] = field(default_factory=list)

    def report(self) -> dict[str, Any]:
        """Return the figures of all pairs and of each goal, under the keys of `twonav evaluate --json`."""
        goals = list(dict.fromkeys(pair.goal for pair in self.pairs))
        causes = Counter(pair.cause for pair in self.pairs if not pair.success)
        return {
            **figures(self.pairs),
            "collisions": sum(pair.collisions for pair in self.pairs),
            "causes": dict(causes),
            "per_goal": {goal: figures([p for p in self.pairs if p.goal == goal]) for goal in goals},
        }


def figures(pairs: list[PairResult]) -> dict[str, Any]:
    """Return success, actions, shortest ways, their ratio and SPL of some pairs.

    Actions and shortest ways are means over the successful pairs, so that their ratio compares like with like.
    """
    won = [pair for pair in pairs if pair.success]
    actions = float(np.mean([pair.actions for pair in won])) if won else None
    shortest = float(np.mean([pair.shortest for pair in won])) if won else None
    return {
        "pairs": len(pairs),
        "successes": len(won),
        "success_rate": len(won) / len(pairs) if pairs else None,
        "actions_mean": actions,
        "shortest_mean": shortest,
        "ratio": actions / shortest if actions is not None and shortest else None,
        "spl": success_weighted_path_length(pairs),
    }


def success_weighted_path_length(pairs: Iterable[PairResult]) -> float | None:
    """Return the mean of S * shortest / max(taken, shortest) (SPL; Anderson et al. 2018)."""
    terms = [
        pair.success * (pair.shortest / max(pair.actions, pair.shortest) if pair.shortest else 1.0) for pair in pairs
    ]
    return float(np.mean(terms)) if terms else None


def evaluate_pairs(
    stage: Stage,
    agent: Agent,
    seed: int,
    sink: Sink,
    on_pair: Callable[[PairResult], None],
    should_stop: Callable[[], bool],
) -> PairTable:
    """Drive every goal from every start, greedily, with what the agent knows now.

    Within a trial the agent keeps learning, as it does in play (a blocked way must lose its value, or a greedy agent
    stands before it for ever); for the next pair it forgets that again. Each pair draws from its own random stream.
    So a pair's result depends on the pairs before it only through the noise of odometry.

    Args:
        stage: Where to drive.
        agent: Whose values are followed; unchanged afterwards.
        seed: Seed of the run.
        sink: Consumer of events.
        on_pair: Called after each pair.
        should_stop: Asked before each pair; True ends the evaluation early.
    """
    table = PairTable()
    clock = Clock()
    for goal_index, goal in enumerate(agent.goal_names):
        for start_index, (start, cell) in enumerate(stage.maze.starts.items()):
            if should_stop():
                return table
            rng = stream(seed, "explore", goal_index, start_index)
            touched = getattr(stage, "collisions", 0)
            driver = copy.deepcopy(agent)
            result = run_trial(stage, driver, goal_index, cell, rng, clock, sink, learn=True, explore=False)
            clock = Clock(clock.trial + 1, clock.step + result.steps, stage.time_s)
            pair = _pair(goal, start, result, getattr(stage, "collisions", 0) - touched)
            table.pairs.append(pair)
            on_pair(pair)
    return table


def _pair(goal: str, start: str, result: TrialResult, collisions: int) -> PairResult:
    success = result.outcome == "reached"
    return PairResult(goal, start, success, result.outcome, result.steps, result.shortest, result.cause, collisions)
