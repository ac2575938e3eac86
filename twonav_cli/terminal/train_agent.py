"""What training the agent shares among its stages: which run is gone on with, its recording, its progress."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import read_card
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Event, GoalLearned, RunEnded, RunStarted, Sink, TrialBatch, TrialEnded, to_all
from twonav_cli.experiments.learning_progress import LearningOutcome
from twonav_cli.learner.agent import Agent
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.learning_place import LearningPlace
from twonav_cli.terminal.recordings import default_recording, recording
from twonav_cli.terminal.train import TrainRequest, card_of

SHOW_EVERY_S, SAY_EVERY_S = 0.5, 10.0
"""Time between two updates of the bar, and between two lines where no bar can be drawn (ours)."""

SAVE_EVERY_S = 30.0

Learn = Callable[[Sink], LearningOutcome]
"""Learns and sends what happens."""


def check_same_run(request: TrainRequest, folder: Path) -> None:
    """Refuse to go on with a run of another stage, seed or maze.

    Raises:
        TwonavError: Says which it was.
    """
    card = read_card(folder)
    if card.get("stage", request.stage) != request.stage:
        raise TwonavError(f"the run in {folder} is of stage {card['stage']}: name another folder with --out")
    if card.get("seed") != request.seed:
        raise TwonavError(
            f"the run in {folder} has seed {card.get('seed')}: go on with that seed, or leave --resume out"
        )


def run_started(request: TrainRequest, place: LearningPlace, agent: Agent) -> RunStarted:
    """Return the event that opens a run, or its continuation."""
    config = asdict(agent.config)
    rewards = {f"reward {name}": value for name, value in config.pop("rewards").items()}
    settings = {name.replace("_", " "): str(value) for name, value in {**config, **rewards}.items()}
    return RunStarted(
        Clock(agent.progress.trial, agent.progress.step), "train", request.stage, place.name, request.seed, settings,
        place.maze, place.maze_frame, place.occupied, place.map_frame,
    )  # fmt: skip


def recorded(request: TrainRequest, begun: RunStarted, agent: Agent, learn: Learn) -> LearningOutcome:
    """Learn with a recording, unless the request wants none; where it is goes to standard error."""
    path = (request.record or default_recording("train", begun.scene, begun.stage)) if request.recording else None
    with recording(path, begun.stage, begun) as recorder:
        result = learn(recorder)
        recorder(RunEnded(Clock(agent.progress.trial, agent.progress.step), result.outcome))
    if path is not None:
        print(f"recording: {path}", file=sys.stderr)
    return result


def with_progress(stage: str, agent: Agent, learn: Learn) -> Learn:
    """Return the same learning with a progress bar."""

    def learn_shown(sink: Sink) -> LearningOutcome:
        with _progress_of(stage, agent) as shown:
            return learn(to_all(sink, shown))

    return learn_shown


def metrics_of(result: LearningOutcome) -> dict[str, Any]:
    """Return the figures of a run for its card and for scripts."""
    return {
        "trials": result.trials,
        "steps": result.steps,
        "goals_learned": len(result.learned),
        "goals": len(result.trials_of_goal),
    }


class Saver:
    """Writes the agent every half minute and at the end, so that a kill loses little; asked between two trials.

    Args:
        request: What the card says.
        place: What the card says.
        folder: Where to.
        agent: What.
        command: On the card, when it is not the request's.
        made_with: What else the card says of how the agent was made.
    """

    def __init__(
        self,
        request: TrainRequest,
        place: LearningPlace,
        folder: Path,
        agent: Agent,
        command: str | None = None,
        made_with: dict[str, Any] | None = None,
    ) -> None:
        self._request, self._place, self._folder, self._agent = request, place, folder, agent
        self._told = {"command": command or request.command(), **(made_with or {})}
        self._saved_at = time.monotonic()

    def due(self) -> bool:
        """Whether the last save is long ago."""
        return time.monotonic() - self._saved_at > SAVE_EVERY_S

    def save_if_due(self) -> None:
        """Write the agent of a run that is under way."""
        if self.due():
            self.save({"unfinished": True})

    def save(self, metrics: dict[str, Any]) -> None:
        """Write the agent with its card."""
        self._agent.save(self._folder, {**card_of(self._request, self._place, metrics), **self._told})
        self._saved_at = time.monotonic()


@contextmanager
def _progress_of(stage: str, agent: Agent) -> Iterator[Sink]:
    """Show goals learned as a bar, or as lines where no bar can be drawn."""
    with progress() as bar:
        task = bar.add_task(f"goals learned, {stage}", total=len(agent.goal_names), result="")

        def show(learned: int, numbers: str) -> None:
            bar.update(task, completed=learned, result=numbers)
            if numbers and not bar.console.is_terminal:
                bar.console.print(f"{learned} of {len(agent.goal_names)} goals learned: {numbers}", soft_wrap=True)

        yield _ProgressSink(show, agent, SHOW_EVERY_S if bar.console.is_terminal else SAY_EVERY_S)


class _ProgressSink:
    """Shows trials, actions, success and goals learned as they come."""

    def __init__(self, show: Callable[[int, str], None], agent: Agent, every_s: float) -> None:
        self._show = show
        self._every_s = every_s
        self._learned = int(agent.progress.learned.sum())
        self._recent: list[bool] = []
        self._shown_at = time.monotonic()
        show(self._learned, "")

    def __call__(self, event: Event) -> None:
        if isinstance(event, TrialEnded):
            self._recent = [*self._recent[-99:], event.outcome == "reached"]
        elif isinstance(event, TrialBatch):
            self._recent = [bool(reached) for reached in event.reached[-100:]]
        elif isinstance(event, GoalLearned):
            self._learned += 1
        else:
            return
        if not isinstance(event, GoalLearned) and time.monotonic() - self._shown_at < self._every_s:
            return
        self._shown_at = time.monotonic()
        share = sum(self._recent) / max(len(self._recent), 1)
        recent = f"success of the last {len(self._recent)}: {share:.0%}"
        self._show(self._learned, f"trial {event.clock.trial}, action {event.clock.step}, {recent}")
