"""One trial after the other in any stage, and why a trial failed; the compiled loop of the maze is `maze_learning`."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from twonav_cli.events import Clock, Looked, QSnapshot, Sink, StepTaken, TrialEnded, TrialStarted
from twonav_cli.experiments.failure_causes import Passed, failure_of
from twonav_cli.experiments.learning_progress import (
    LearningOutcome,
    after_trials,
    check_learnable,
    choose_goal_if_none,
    clock_of,
    outcome_of,
)
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.goals import is_learned, record_trial
from twonav_cli.navigation.outcomes import REACHED
from twonav_cli.rng import stream
from twonav_cli.stages.stage import Observation, Stage

SNAPSHOT_ROUNDS = 5
"""Rounds (a trial from each start) between two snapshots of the table in another stage (ours)."""

TRIALS_AT_MOST = 10_000
"""Trials after which learning in another stage gives up (ours)."""


@dataclass(frozen=True)
class TrialResult:
    """How one trial ended.

    Attributes:
        outcome: "reached", "false-arrival" or "time-out".
        steps: Actions taken.
        shortest: Length of the shortest way in the maze.
        cause: Why it failed, one of CAUSES; "" when it did not.
        evidence: One sentence for the cause.
        clock: When the trial ended.
        wrong_cells: Actions after which the robot stood in another cell than it should have.
    """

    outcome: str
    steps: int
    shortest: int
    cause: str
    evidence: str
    clock: Clock
    wrong_cells: int = 0


def learn_in_stage(
    stage: Stage,
    agent: Agent,
    seed: int,
    sink: Sink,
    should_stop: Callable[[], bool],
    trials_at_most: int = TRIALS_AT_MOST,
) -> LearningOutcome:
    """Learn every goal in any stage, one trial after the other; a run that was stopped goes on where it was.

    Args:
        stage: Where the trials take place.
        agent: Changed in place; its progress says where the run stands.
        seed: Each trial draws from its own stream of it, so that a stopped run can go on.
        sink: Gets GoalChosen, TrialStarted, StepTaken, TrialEnded, GoalLearned, QSnapshot, and the stage's Ticks.
        should_stop: Asked before every trial.
        trials_at_most: Trials after which the run gives up.

    Raises:
        TwonavError: The agent does not fit the stage's maze, or a goal cannot be reached.
    """
    check_learnable(agent, stage.maze)
    progress = agent.progress
    sink(QSnapshot(clock_of(agent, stage.time_s), agent.table(), agent.td_table()))
    while not progress.learned.all():
        if should_stop():
            return outcome_of("stopped", agent)
        if progress.trial >= trials_at_most:
            return outcome_of("gave-up", agent)
        choose_goal_if_none(agent, seed, sink, stage.time_s)
        trials_before = progress.trial
        learned = _learn_from_trial(stage, agent, seed, sink)
        after_trials(agent, learned, trials_before, SNAPSHOT_ROUNDS * len(stage.maze.starts), stage.time_s, sink)
    return outcome_of("learned", agent)


def _learn_from_trial(stage: Stage, agent: Agent, seed: int, sink: Sink) -> bool:
    """Run the next trial of a learning run and return whether its goal is learned now."""
    progress, starts = agent.progress, list(stage.maze.starts.values())
    goal, start = progress.goal, progress.next_start
    rng = stream(seed, "explore", progress.trial)
    clock = clock_of(agent, stage.time_s)
    stage.draw_from(stream(seed, "world", progress.trial))
    result = run_trial(stage, agent, goal, starts[start], rng, clock, sink, learn=True, explore=True)
    agent.end_trial()
    record_trial(progress.consecutive, progress.window, start, result.steps, result.outcome == "reached")
    progress.trial += 1
    progress.step += result.steps
    progress.trials_of_goal[goal] += 1
    progress.steps_of_goal[goal] += result.steps
    progress.next_start = (start + 1) % len(starts)
    round_over = progress.next_start == 0
    return round_over and is_learned(progress.consecutive, progress.window, agent.config.max_step_difference)


def run_trial(
    stage: Stage,
    agent: Agent,
    goal: int,
    start: Cell,
    rng: np.random.Generator,
    clock: Clock,
    sink: Sink,
    learn: bool,
    explore: bool,
) -> TrialResult:
    """Run one trial: until the agent believes to be in the goal's cell, or its actions are used up.

    Args:
        stage: Where.
        agent: Learns in place when `learn`.
        goal: Index of the goal.
        start: Cell to begin in; the goal's own cell is an arrival without an action.
        rng: Stream "explore".
        clock: When the trial begins.
        sink: Gets TrialStarted, Looked (where there is a camera), StepTaken and TrialEnded.
        learn: Whether the agent observes what happens.
        explore: False takes greedy actions only, which can circle until the actions are used up.

    Raises:
        TwonavError: The start is blocked.
    """
    goal_cell, name = agent.goal_cells[goal], agent.goal_names[goal]
    seen = stage.place(start)
    sink(TrialStarted(clock, name, start, seen.pose_true))
    tell_look(seen, clock, sink)
    passed: list[Passed] = []
    while start != goal_cell and seen.cell != goal_cell and len(passed) < agent.config.trial_limit_steps:
        clock = replace(clock, step=clock.step + 1, time_s=stage.time_s)
        before = seen
        seen, step = _take_step(stage, agent, goal, before, rng, clock, sink, learn, explore)
        passed.append(step)
    return _ended(stage, goal_cell, name, start, seen, passed, replace(clock, time_s=stage.time_s), sink)


def _ended(
    stage: Stage,
    goal_cell: Cell,
    name: str,
    start: Cell,
    seen: Observation,
    passed: list[Passed],
    clock: Clock,
    sink: Sink,
) -> TrialResult:
    """Judge a trial that is over, and send its end."""
    declared = start == goal_cell or seen.cell == goal_cell
    arrived = start == goal_cell or seen.true_cell == goal_cell
    outcome = ("reached" if arrived else "false-arrival") if declared else "time-out"
    cause, evidence = failure_of(outcome, seen, goal_cell, passed)
    steps, shortest = len(passed), int(stage.maze.distances_to(goal_cell)[start])
    poses = (seen.pose_true, seen.pose_estimate)
    sink(TrialEnded(clock, name, start, outcome, steps, shortest, cause, evidence, *poses))
    wrong_cells = sum(step.wrong_cell for step in passed)
    return TrialResult(outcome, steps, shortest, cause, evidence, clock, wrong_cells)


def _take_step(
    stage: Stage,
    agent: Agent,
    goal: int,
    before: Observation,
    rng: np.random.Generator,
    clock: Clock,
    sink: Sink,
    learn: bool,
    explore: bool,
) -> tuple[Observation, Passed]:
    """Choose, act, learn; return what is seen afterwards, and what the trial remembers of the step."""
    values = agent.values(before.cell, goal)
    action, greedy = agent.choose(before.cell, goal, rng, explore)
    result = stage.act(action, clock, sink)
    seen = result.observation
    blocked = result.outcome != REACHED or seen.cell == before.cell
    learning = agent.observe if learn and result.plausible else agent.td_errors
    td_errors = learning(before.cell, action, seen.cell, blocked)
    sink(
        StepTaken(
            clock=replace(clock, time_s=stage.time_s),
            goal=agent.goal_names[goal],
            cell=before.cell,
            action=action,
            next_cell=seen.cell,
            outcome=result.outcome,
            q_values=values,
            td_errors=td_errors,
            greedy=greedy,
            true_cell=seen.true_cell,
            pose_true=seen.pose_true,
            pose_estimate=seen.pose_estimate,
            image=seen.image,
            belief=seen.belief,
            filtered=seen.filtered,
        )
    )
    should_be = stage.maze.moved(before.cell, action) if result.outcome == REACHED else before.true_cell
    return seen, Passed(seen.cell, blocked, seen.pose_true, seen.true_cell != should_be)


def tell_look(seen: Observation, clock: Clock, sink: Sink) -> None:
    """Send what a robot that stands sees and makes of it, in a stage with a camera."""
    if seen.image is not None and seen.pose_true is not None:
        sink(Looked(clock, seen.pose_true, seen.image, seen.pose_estimate, seen.belief, seen.filtered))
