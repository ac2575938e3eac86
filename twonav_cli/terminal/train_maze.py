"""Training the agent in the maze from the command line: in a second or two, or while somebody watches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.checkpoint import read_card
from twonav_cli.events import RunStarted, Sink
from twonav_cli.experiments.learning_progress import LearningOutcome, outcome_of
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.learner.agent import Agent
from twonav_cli.terminal.learning_place import LearningPlace
from twonav_cli.terminal.train import ALREADY_LEARNED, TrainRequest
from twonav_cli.terminal.train_agent import Saver, check_same_run, metrics_of, recorded, run_started, with_progress

if TYPE_CHECKING:
    from twonav_cli.terminal.train_agent import Learn


def train_maze(
    request: TrainRequest, place: LearningPlace, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Learn every goal of a maze and save the agent; one that has learned them all is left as it is.

    Returns:
        The outcome ("learned", ALREADY_LEARNED, "stopped" or "gave-up") and the metrics of the card.

    Raises:
        TwonavError: A setting is out of its range, a goal cannot be learned, or the run to go on with is another one.
    """
    agent = _agent(request, place, folder)
    if request.resume and agent.progress.learned.all():
        return ALREADY_LEARNED, metrics_of(outcome_of("learned", agent))
    # A run that goes on has the settings, and so the command, that it began with.
    command = read_card(folder)["command"] if request.resume else request.command()
    saver = Saver(request, place, folder, agent, command)
    begun = run_started(request, place, agent)

    def learn(sink: Sink) -> LearningOutcome:
        return learn_maze(agent, place.maze, request.seed, sink, should_stop)

    learn_shown = _watched(agent, place, request.seed, begun, saver) if request.watch else None
    result = recorded(request, begun, agent, learn_shown or with_progress("maze", agent, learn))
    metrics = metrics_of(result)
    saver.save(metrics)
    return ("quick" if request.quick and result.outcome == "gave-up" else result.outcome), metrics


def _watched(agent: Agent, place: LearningPlace, seed: int, begun: RunStarted, saver: Saver) -> Learn:
    """Return learning while somebody watches, which may take hours and so is saved between trials."""

    def save() -> None:
        learned = agent.progress.learned.all()
        saver.save(metrics_of(outcome_of("learned", agent)) if learned else {"unfinished": True})

    def learn(sink: Sink) -> LearningOutcome:
        from twonav_cli.terminal.screen.watch_screen import run_watch
        from twonav_cli.terminal.screen.watch_walk import Walk

        walk = Walk(agent, place.maze, seed, sink, saver.due, save)
        run_watch(walk, begun)
        return walk.close()

    return learn


def _agent(request: TrainRequest, place: LearningPlace, folder: Path) -> Agent:
    """Return the agent to train: a new one, or that of the run to go on with."""
    if not request.resume:
        return Agent.for_maze(place.maze, request.choices.config(), request.seed)
    check_same_run(request, folder)
    agent = Agent.load(folder, place.scene_digest, place.map_digest)
    request.choices.check_same(agent.config, str(folder))
    return agent
