"""Every goal from every start, and the figures that navigation is measured by."""

from __future__ import annotations

import copy
import time
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from twonav_cli.events import Clock, Sink
from twonav_cli.experiments.trials import run_trial
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Maze
from twonav_cli.rng import stream
from twonav_cli.stages.stage import Stage

TIME_DIGITS = 6
"""Decimals of simulated seconds: the clock of a stage that has driven before differs in the last bits (ours)."""


@dataclass(frozen=True)
class Pair:
    """One goal from one start: indices, and which repeat it is."""

    goal: int
    start: int
    repeat: int = 0


@dataclass(frozen=True)
class PairResult:
    """How one goal from one start went.

    Attributes:
        goal: Name.
        start: Name.
        success: Whether the agent declared arrival, and stood in the goal's cell.
        outcome: "reached", "false-arrival" or "time-out".
        actions: How many were taken.
        shortest: Length of the shortest way in the maze.
        cause: Why it failed, one of CAUSES; "" when it did not.
        collisions: Control periods that ended at something.
        wrong_cells: Actions after which the robot stood in another cell than it should have.
        sim_s: Simulated time.
        repeat: Which repeat it was.
        wall_s: Time that driving it took.
    """

    goal: str
    start: str
    success: bool
    outcome: str
    actions: int
    shortest: int
    cause: str
    collisions: int = 0
    wrong_cells: int = 0
    sim_s: float = 0.0
    repeat: int = 0
    wall_s: float = field(default=0.0, compare=False)


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
    """Return success, actions, shortest ways, their ratio, SPL and what went wrong on the way, of some pairs.

    Actions and shortest ways are means over the successful pairs, so that their ratio compares like with like. The
    deviation is that of the actions from one repeat to the next, averaged over the pairs; None with a single repeat.
    """
    won = [pair for pair in pairs if pair.success]
    actions = float(np.mean([pair.actions for pair in won])) if won else None
    shortest = float(np.mean([pair.shortest for pair in won])) if won else None
    taken = sum(pair.actions for pair in pairs)
    return {
        "pairs": len(pairs),
        "successes": len(won),
        "success_rate": len(won) / len(pairs) if pairs else None,
        "actions_mean": actions,
        "actions_std": _deviation_between_repeats(won),
        "shortest_mean": shortest,
        "ratio": actions / shortest if actions is not None and shortest else None,
        "spl": success_weighted_path_length(pairs),
        "collisions_per_100_actions": 100 * sum(pair.collisions for pair in pairs) / taken if taken else None,
        "wrong_cells_per_100_actions": 100 * sum(pair.wrong_cells for pair in pairs) / taken if taken else None,
        "sim_s_per_action": sum(pair.sim_s for pair in pairs) / taken if taken else None,
        "actions_per_s": taken / wall_s if (wall_s := sum(pair.wall_s for pair in pairs)) > 0 else None,
    }


def _deviation_between_repeats(won: list[PairResult]) -> float | None:
    """Return the standard deviation of a pair's actions from repeat to repeat, averaged over the pairs."""
    of_pair: dict[tuple[str, str], list[int]] = {}
    for pair in won:
        of_pair.setdefault((pair.goal, pair.start), []).append(pair.actions)
    deviations = [float(np.std(actions, ddof=1)) for actions in of_pair.values() if len(actions) > 1]
    return float(np.mean(deviations)) if deviations else None


def success_weighted_path_length(pairs: Iterable[PairResult]) -> float | None:
    """Return the mean of S * shortest / max(taken, shortest) (SPL; Anderson et al. 2018)."""
    terms = [
        pair.success * (pair.shortest / max(pair.actions, pair.shortest) if pair.shortest else 1.0) for pair in pairs
    ]
    return float(np.mean(terms)) if terms else None


def pairs_of(maze: Maze, repeats: int = 1) -> list[Pair]:
    """Return every goal from every start, as often as asked, repeat by repeat."""
    return [
        Pair(goal, start, repeat)
        for repeat in range(repeats)
        for goal in range(len(maze.goals))
        for start in range(len(maze.starts))
    ]


def drive_pair(stage: Stage, agent: Agent, pair: Pair, seed: int, clock: Clock, sink: Sink) -> tuple[PairResult, Clock]:
    """Drive one goal from one start, greedily, with what the agent knows now; return how it went, and when it ended.

    On its way the agent keeps learning, as it does in play (a blocked way must lose its value, or a greedy agent stands
    before it for ever); for the next pair it forgets that again. Actions and the world's noise are drawn from streams
    of the pair's own, so that its result does not depend on what was driven before.

    Args:
        stage: Where to drive.
        agent: Whose values are followed; unchanged afterwards.
        pair: Which.
        seed: Seed of the evaluation.
        clock: When it begins.
        sink: Consumer of events.
    """
    start, cell = list(stage.maze.starts.items())[pair.start]
    numbers = (pair.goal, pair.start, pair.repeat)
    stage.draw_from(stream(seed, "world of pair", *numbers))
    touched, begun_s, begun_wall_s = getattr(stage, "collisions", 0), stage.time_s, time.perf_counter()
    rng = stream(seed, "explore pair", *numbers)
    result = run_trial(stage, copy.deepcopy(agent), pair.goal, cell, rng, clock, sink, learn=True, explore=False)
    ended = Clock(clock.trial + 1, clock.step + result.steps, stage.time_s)
    return PairResult(
        goal=agent.goal_names[pair.goal],
        start=start,
        success=result.outcome == "reached",
        outcome=result.outcome,
        actions=result.steps,
        shortest=result.shortest,
        cause=result.cause,
        collisions=getattr(stage, "collisions", 0) - touched,
        wrong_cells=result.wrong_cells,
        sim_s=round(stage.time_s - begun_s, TIME_DIGITS),
        repeat=pair.repeat,
        wall_s=time.perf_counter() - begun_wall_s,
    ), ended


def evaluate_pairs(
    stage: Stage,
    agent: Agent,
    seed: int,
    sink: Sink,
    on_pair: Callable[[PairResult], None],
    should_stop: Callable[[], bool],
    pairs: Sequence[Pair] | None = None,
) -> PairTable:
    """Drive pairs one after the other (`drive_pair`).

    Args:
        stage: Where to drive.
        agent: Whose values are followed; unchanged afterwards.
        seed: Seed of the evaluation.
        sink: Consumer of events.
        on_pair: Called after each pair.
        should_stop: Asked before each pair; True ends the evaluation early.
        pairs: Which; None for every goal from every start once.
    """
    table = PairTable()
    clock = Clock()
    for pair in pairs_of(stage.maze) if pairs is None else pairs:
        if should_stop():
            break
        found, clock = drive_pair(stage, agent, pair, seed, clock, sink)
        table.pairs.append(found)
        on_pair(found)
    return table
