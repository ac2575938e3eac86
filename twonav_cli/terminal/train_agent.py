"""Training the agent, in the maze or in 3D, from the command line."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.checkpoint import read_card
from twonav_cli.config import learning_preset
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Event, GoalLearned, RunEnded, RunStarted, Sink, TrialBatch, TrialEnded, to_all
from twonav_cli.experiments.predecessors import checkpoint_folder, load_localize, make_stage
from twonav_cli.experiments.trials import LearningOutcome, learn_in_stage, learn_maze
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.recordings import default_recording, recording
from twonav_cli.terminal.train import TrainRequest, card_of

if TYPE_CHECKING:
    from twonav_cli.stages.sim3d_stage import Sim3dStage

SAVE_EVERY_S = 30.0
SHOW_EVERY_S = 0.5
TRIALS_IN_3D = 1500
QUICK_TRIALS_IN_3D = 6


def train_agent(
    request: TrainRequest, floor: Floor, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Learn every goal in a stage and save the agent.

    Returns:
        The outcome ("learned", "quick", "stopped" or "gave-up") and the metrics of the card.

    Raises:
        TwonavError: The stage before is missing, or a checkpoint does not belong here.
    """
    agent = _agent(request, floor, folder)
    stage = None if request.stage == "maze" else _stage_3d(request, floor)
    path = (
        (request.record or default_recording("train", floor.scene.name, request.stage)) if request.recording else None
    )
    begun = RunStarted(
        Clock(agent.progress.trial, agent.progress.step), "train", request.stage, floor.scene.name, request.seed, {},
        floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame,
    )  # fmt: skip
    saver = _Saver(request, floor, folder, agent, should_stop)
    with progress() as bar, recording(path, request.stage, begun) as recorder:
        task = bar.add_task(f"goals learned, {request.stage}", total=len(agent.goal_names), result="")

        def show(learned: int, numbers: str) -> None:
            bar.update(task, completed=learned, result=numbers)
            if numbers and not bar.console.is_terminal:
                bar.console.print(f"{learned} of {len(agent.goal_names)} goals learned: {numbers}", soft_wrap=True)

        sink = to_all(recorder, _ProgressSink(show, agent))
        if stage is None:
            result = learn_maze(agent, floor.maze, request.seed, sink, should_stop)
        else:
            result = _learn_3d(request, stage, agent, sink, saver)
        recorder(RunEnded(Clock(agent.progress.trial, agent.progress.step), result.outcome))
    metrics = _metrics(result)
    saver.save(metrics)
    if path is not None:
        print(f"recording: {path}", file=sys.stderr)
    return ("quick" if request.quick and result.outcome == "gave-up" else result.outcome), metrics


def _agent(request: TrainRequest, floor: Floor, folder: Path) -> Agent:
    """Return the agent to train: resumed, or new (maze), or that of the stage before (3D)."""
    scene, digest = floor.scene, floor.map.digest
    if request.resume:
        _check_same_run(request, folder)
        return Agent.load(folder, scene.digest, digest)
    config = learning_preset(request.stage)
    if request.stage == "maze":
        return Agent.for_maze(floor.maze, config, request.seed)
    before = checkpoint_folder(scene.name, "maze", own_first=True)
    return Agent.load(before, scene.digest, digest, config)


def _check_same_run(request: TrainRequest, folder: Path) -> None:
    """Refuse to go on with a run of another stage or seed.

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


def _stage_3d(request: TrainRequest, floor: Floor) -> Sim3dStage:
    from twonav_cli.stages.sim3d_stage import Sim3dOptions

    localize = load_localize(floor, own_first=True)
    options = Sim3dOptions(base=request.base, trace=request.recording)
    return make_stage(floor, "3d", localize, request.seed, options)  # type: ignore[return-value]  # by name


def _learn_3d(
    request: TrainRequest, stage: Sim3dStage, agent: Agent, sink: Sink, should_stop: Callable[[], bool]
) -> LearningOutcome:
    try:
        trials = QUICK_TRIALS_IN_3D if request.quick else TRIALS_IN_3D
        return learn_in_stage(stage, agent, request.seed, sink, should_stop, agent.progress.trial + trials)
    finally:
        stage.close()


def _metrics(result: LearningOutcome) -> dict[str, Any]:
    return {
        "trials": result.trials,
        "steps": result.steps,
        "goals_learned": len(result.learned),
        "goals": len(result.trials_of_goal),
    }


class _Saver:
    """Writes the agent every half minute and at the end, so that a kill loses little.

    It stands before the question whether to stop, which the learning loop asks between two trials, where the agent can
    be saved.
    """

    def __init__(
        self, request: TrainRequest, floor: Floor, folder: Path, agent: Agent, should_stop: Callable[[], bool]
    ) -> None:
        self._request, self._floor, self._folder, self._agent = request, floor, folder, agent
        self._should_stop = should_stop
        self._saved_at = time.monotonic()

    def __call__(self) -> bool:
        """Whether to stop."""
        if time.monotonic() - self._saved_at > SAVE_EVERY_S:
            self.save({"unfinished": True})
        return self._should_stop()

    def save(self, metrics: dict[str, Any]) -> None:
        """Write the agent with its card."""
        self._agent.save(self._folder, card_of(self._request, self._floor, metrics))
        self._saved_at = time.monotonic()


class _ProgressSink:
    """Shows trials, actions, success and goals learned as they come."""

    def __init__(self, show: Callable[[int, str], None], agent: Agent) -> None:
        self._show = show
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
        if not isinstance(event, GoalLearned) and time.monotonic() - self._shown_at < SHOW_EVERY_S:
            return
        self._shown_at = time.monotonic()
        share = sum(self._recent) / max(len(self._recent), 1)
        recent = f"success of the last {len(self._recent)}: {share:.0%}"
        self._show(self._learned, f"trial {event.clock.trial}, action {event.clock.step}, {recent}")
