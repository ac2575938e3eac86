"""What all learning runs share: whether one can begin, which goal is next, what is sent between trials, how it ends.

G goals.
"""

from __future__ import annotations

from dataclasses import dataclass

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, GoalChosen, GoalLearned, QSnapshot, Sink
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.goals import GOAL_SELECTIONS, NO_GOAL, next_goal
from twonav_cli.maze import UNREACHABLE, Maze
from twonav_cli.rng import stream


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
        optimal_at: Actions after which every greedy way was first a shortest one; -1 when that was not seen.
    """

    outcome: str
    trials: int
    steps: int
    learned: tuple[str, ...]
    trials_of_goal: dict[str, int]
    steps_of_goal: dict[str, int]
    optimal_at: int = -1


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


def outcome_of(outcome: str, agent: Agent) -> LearningOutcome:
    """Return how a run ended, from where the agent stands."""
    progress, names = agent.progress, agent.goal_names
    learned = tuple(name for name, done in zip(names, progress.learned, strict=True) if done)
    trials = dict(zip(names, progress.trials_of_goal, strict=True))
    steps = dict(zip(names, progress.steps_of_goal, strict=True))
    return LearningOutcome(outcome, progress.trial, progress.step, learned, trials, steps, progress.optimal_at)


def clock_of(agent: Agent, time_s: float = 0.0) -> Clock:
    """Return the moment of an event: trials and actions of the agent's run."""
    return Clock(agent.progress.trial, agent.progress.step, time_s)


def choose_goal_if_none(agent: Agent, seed: int, sink: Sink, time_s: float = 0.0) -> None:
    """Choose the next goal by the agent's rule, unless one is under way, and say why (§3.1.2)."""
    progress = agent.progress
    if progress.goal != NO_GOAL:
        return
    td_errors, rule, learned = agent.td_error_of_goals(), agent.config.goal_selection, progress.learned.copy()
    rng = stream(seed, "goals", int(progress.learned.sum()))
    agent.begin_goal(next_goal(rule, td_errors, progress.learned, rng))
    name = agent.goal_names[progress.goal]
    sink(GoalChosen(clock_of(agent, time_s), name, GOAL_SELECTIONS[rule], td_errors, learned))


def after_trials(agent: Agent, learned: bool, trials_before: int, period: int, time_s: float, sink: Sink) -> None:
    """Close a learned goal, and send the table when it is due."""
    clock, progress = clock_of(agent, time_s), agent.progress
    if learned:
        sink(GoalLearned(clock, agent.goal_names[progress.goal]))
        progress.finish_goal()
    if learned or progress.trial // period > trials_before // period:
        sink(QSnapshot(clock, agent.table(), agent.td_table()))
