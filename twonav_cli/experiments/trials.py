"""The learning loops: a compiled one for the maze, and a slow one over any stage.

G goals, R rows, C columns, A actions, n trials.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.events import (
    Clock,
    GoalChosen,
    GoalLearned,
    QSnapshot,
    Sink,
    StepTaken,
    TrialBatch,
    TrialEnded,
    TrialStarted,
)
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.goals import GOAL_SELECTIONS, NO_GOAL, is_learned, next_goal, record_trial
from twonav_cli.learner.maze_loop import Columns, MazeLoop
from twonav_cli.maze import UNREACHABLE, Maze
from twonav_cli.rng import stream
from twonav_cli.stages.stage import REACHED, Observation, Stage

SNAPSHOT_TRIALS = 5000
"""Trials between two snapshots of the table in the maze (ours); one more is taken when a goal is learned."""

SNAPSHOT_ROUNDS = 5
"""Rounds (a trial from each start) between two snapshots of the table in another stage (ours)."""

MAZE_STEPS_AT_MOST = 20_000_000
"""Actions after which learning in the maze gives up (ours): about a hundred times what the apartment takes."""

TRIALS_AT_MOST = 10_000
"""Trials after which learning in another stage gives up (ours)."""

BLOCKED_LOOK_BACK, BLOCKED_AT_LEAST = 20, 10
"""A failed trial was "blocked" when so many of its last actions were."""

LOOP_LOOK_BACK, LOOP_CELLS_AT_MOST = 40, 8
"""A failed trial was a "loop" when its last steps saw so few cells."""


@dataclass(frozen=True)
class LearningOutcome:
    """How a learning run ended.

    Attributes:
        outcome: "learned", "stopped" (asked to) or "gave-up" (the limit of steps or trials).
        trials: Trials over the whole run.
        steps: Actions over the whole run.
        learned: Names of the goals learned.
        trials_of_goal: Name of each goal to the trials spent on it.
        steps_of_goal: Name of each goal to the actions spent on it.
    """

    outcome: str
    trials: int
    steps: int
    learned: tuple[str, ...]
    trials_of_goal: dict[str, int]
    steps_of_goal: dict[str, int]


@dataclass(frozen=True)
class TrialResult:
    """How one trial ended.

    Attributes:
        outcome: "reached", "false-arrival" or "time-out".
        steps: Actions taken.
        shortest: Length of the shortest way in the maze.
        cause: Why it failed: "", "mislocalized", "blocked", "loop" or "time-out".
        evidence: One sentence for the cause.
        clock: When the trial ended.
    """

    outcome: str
    steps: int
    shortest: int
    cause: str
    evidence: str
    clock: Clock


def check_learnable(agent: Agent, maze: Maze) -> None:
    """Make sure that the agent fits the maze and that every goal can be reached from every start.

    Raises:
        TwonavError: It does not, there is no start, or a goal is cut off.
    """
    agent.check_fits(maze)
    if not maze.starts:
        raise TwonavError("there is no start to learn from: add one to the scene")
    for goal, cell in maze.goals.items():
        distances = maze.distances_to(cell)
        for start, start_cell in maze.starts.items():
            if distances[start_cell] == UNREACHABLE:
                raise TwonavError(f"goal {goal!r} cannot be reached from start {start!r}: move one of them")


def learn_maze(
    agent: Agent,
    maze: Maze,
    seed: int,
    sink: Sink,
    should_stop: Callable[[], bool],
    steps_at_most: int = MAZE_STEPS_AT_MOST,
) -> LearningOutcome:
    """Learn every goal of a maze with the compiled loop (§4.3); a run that was stopped goes on where it was.

    Args:
        agent: Changed in place; its progress says where the run stands.
        maze: The agent's.
        seed: Of a run that begins; one that goes on has its own.
        sink: Gets GoalChosen, TrialBatch, GoalLearned and QSnapshot.
        should_stop: Asked every few hundred trials.
        steps_at_most: Actions after which the run gives up.

    Raises:
        TwonavError: The agent does not fit the maze, or a goal cannot be reached.
    """
    check_learnable(agent, maze)
    loop = MazeLoop(agent, maze, seed)
    progress = agent.progress
    try:
        while not progress.learned.all():
            if should_stop():
                return _outcome_of("stopped", agent)
            if progress.step >= steps_at_most:
                return _outcome_of("gave-up", agent)
            _choose_goal_if_none(agent, seed, sink)
            steps_before, trials_before = progress.step, progress.trial
            rows, learned = loop.run()
            sink(_batch_of(rows, loop, agent, steps_before))
            _after_trials(agent, learned, trials_before, SNAPSHOT_TRIALS, 0.0, sink)
    finally:
        loop.close()
    return _outcome_of("learned", agent)


def _outcome_of(outcome: str, agent: Agent) -> LearningOutcome:
    progress, names = agent.progress, agent.goal_names
    learned = tuple(name for name, done in zip(names, progress.learned, strict=True) if done)
    trials = dict(zip(names, progress.trials_of_goal, strict=True))
    steps = dict(zip(names, progress.steps_of_goal, strict=True))
    return LearningOutcome(outcome, progress.trial, progress.step, learned, trials, steps)


def _clock_of(agent: Agent, time_s: float = 0.0) -> Clock:
    return Clock(agent.progress.trial, agent.progress.step, time_s)


def _choose_goal_if_none(agent: Agent, seed: int, sink: Sink, time_s: float = 0.0) -> None:
    progress = agent.progress
    if progress.goal != NO_GOAL:
        return
    td_errors, rule = agent.td_error_of_goals(), agent.config.goal_selection
    rng = stream(seed, "goals", int(progress.learned.sum()))
    agent.begin_goal(next_goal(rule, td_errors, progress.learned, rng))
    name = agent.goal_names[progress.goal]
    sink(GoalChosen(_clock_of(agent, time_s), name, GOAL_SELECTIONS[rule], td_errors))


def _batch_of(rows: Columns, loop: MazeLoop, agent: Agent, steps_before: int) -> TrialBatch:
    goal = agent.progress.goal
    return TrialBatch(
        clock=_clock_of(agent),
        goal=np.full(len(rows.steps), goal, dtype=np.int64),
        start=rows.start,
        steps=rows.steps,
        reached=rows.reached,
        shortest=loop.ways.shortest[rows.start, goal],
        td_errors=rows.td_errors,
        last_step=steps_before + np.cumsum(rows.steps),
    )


def _after_trials(agent: Agent, learned: bool, trials_before: int, period: int, time_s: float, sink: Sink) -> None:
    """Close a learned goal, and send the table when it is due."""
    clock, progress = _clock_of(agent, time_s), agent.progress
    if learned:
        sink(GoalLearned(clock, agent.goal_names[progress.goal]))
        progress.finish_goal()
    if learned or progress.trial // period > trials_before // period:
        sink(QSnapshot(clock, agent.table()))


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
    while not progress.learned.all():
        if should_stop():
            return _outcome_of("stopped", agent)
        if progress.trial >= trials_at_most:
            return _outcome_of("gave-up", agent)
        _choose_goal_if_none(agent, seed, sink, stage.time_s)
        trials_before = progress.trial
        learned = _learn_from_trial(stage, agent, seed, sink)
        _after_trials(agent, learned, trials_before, SNAPSHOT_ROUNDS * len(stage.maze.starts), stage.time_s, sink)
    return _outcome_of("learned", agent)


def _learn_from_trial(stage: Stage, agent: Agent, seed: int, sink: Sink) -> bool:
    """Run the next trial of a learning run and return whether its goal is learned now."""
    progress, starts = agent.progress, list(stage.maze.starts.values())
    goal, start = progress.goal, progress.next_start
    rng = stream(seed, "explore", progress.trial)
    clock = _clock_of(agent, stage.time_s)
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


@dataclass(frozen=True)
class Passed:
    """What a trial remembers of a step to explain a failure."""

    cell: Cell
    blocked: bool


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
        sink: Gets TrialStarted, StepTaken and TrialEnded.
        learn: Whether the agent observes what happens.
        explore: False takes greedy actions only, which can circle until the actions are used up.

    Raises:
        TwonavError: The start is blocked.
    """
    goal_cell, name = agent.goal_cells[goal], agent.goal_names[goal]
    seen = stage.place(start)
    sink(TrialStarted(clock, name, start, seen.pose_true))
    passed: list[Passed] = []
    while start != goal_cell and seen.cell != goal_cell and len(passed) < agent.config.trial_limit_steps:
        clock = replace(clock, step=clock.step + 1, time_s=stage.time_s)
        before = seen
        seen, blocked = _take_step(stage, agent, goal, before, rng, clock, sink, learn, explore)
        passed.append(Passed(seen.cell, blocked))
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
    return TrialResult(outcome, steps, shortest, cause, evidence, clock)


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
) -> tuple[Observation, bool]:
    """Choose, act, learn; return what is seen afterwards, and whether the action counts as blocked."""
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
        )
    )
    return seen, blocked


def failure_of(outcome: str, seen: Observation, goal_cell: Cell, passed: list[Passed]) -> tuple[str, str]:
    """Return why a trial failed, from a closed list, and one sentence of evidence; empty when it did not."""
    if outcome == "reached":
        return "", ""
    believed, true = tuple(seen.cell), tuple(seen.true_cell)
    if outcome == "false-arrival":
        return "mislocalized", f"Arrival was declared in {believed}, but the robot stands in {true}."
    if believed != true:
        return "mislocalized", f"At the end the robot believes to be in {believed} and stands in {true}."
    last = passed[-BLOCKED_LOOK_BACK:]
    blocked = sum(step.blocked for step in last)
    if blocked >= BLOCKED_AT_LEAST:
        return "blocked", f"{blocked} of the last {len(last)} actions were blocked."
    recent = passed[-LOOP_LOOK_BACK:]
    cells = len({step.cell for step in recent})
    if len(recent) == LOOP_LOOK_BACK and cells <= LOOP_CELLS_AT_MOST:
        return "loop", f"The last {len(recent)} steps saw only {cells} cells."
    return "time-out", f"After {len(passed)} actions the robot is in {true} and the goal in {tuple(goal_cell)}."
