"""Training the agent in the maze from the command line: in a second or two, or while somebody watches."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import read_card
from twonav_cli.events import Sink
from twonav_cli.experiments.learning_progress import LearningOutcome
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.learner.agent import Agent
from twonav_cli.terminal.learning_place import LearningPlace
from twonav_cli.terminal.train import TrainRequest, card_of
from twonav_cli.terminal.train_agent import check_same_run, metrics_of, recorded, run_started, with_progress


def train_maze(
    request: TrainRequest, place: LearningPlace, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Learn every goal of a maze and save the agent.

    Returns:
        The outcome ("learned", "stopped" or "gave-up") and the metrics of the card.

    Raises:
        TwonavError: A setting is out of its range, a goal cannot be learned, or the run to go on with is another one.
    """
    agent = _agent(request, place, folder)
    # A run that goes on has the settings, and so the command, that it began with.
    command = read_card(folder)["command"] if request.resume else request.command()
    begun = run_started(request, place, agent)

    def learn(sink: Sink) -> LearningOutcome:
        return learn_maze(agent, place.maze, request.seed, sink, should_stop)

    def learn_watched(sink: Sink) -> LearningOutcome:
        from twonav_cli.terminal.screen.watch_screen import run_watch
        from twonav_cli.terminal.screen.watch_walk import Walk

        walk = Walk(agent, place.maze, request.seed, sink)
        run_watch(walk, begun)
        return walk.close()

    result = recorded(request, begun, agent, learn_watched if request.watch else with_progress("maze", agent, learn))
    metrics = metrics_of(result)
    agent.save(folder, {**card_of(request, place, metrics), "command": command})
    return ("quick" if request.quick and result.outcome == "gave-up" else result.outcome), metrics


def _agent(request: TrainRequest, place: LearningPlace, folder: Path) -> Agent:
    """Return the agent to train: a new one, or that of the run to go on with."""
    if not request.resume:
        return Agent.for_maze(place.maze, request.choices.config(), request.seed)
    check_same_run(request, folder)
    agent = Agent.load(folder, place.scene_digest, place.map_digest)
    request.choices.check_same(agent.config, str(folder))
    return agent
