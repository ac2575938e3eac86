"""Training the agent where a robot drives, from the command line: in 2D, then in 3D with the localizer's poses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.checkpoint import read_card
from twonav_cli.config import learning_preset
from twonav_cli.errors import TwonavError
from twonav_cli.events import Sink
from twonav_cli.experiments.learning_progress import LearningOutcome, outcome_of
from twonav_cli.experiments.predecessors import STAGE_BEFORE, checkpoint_folder, load_localize, make_stage
from twonav_cli.experiments.transfer.agent_chain import TRIALS_FROM_NOTHING
from twonav_cli.experiments.trials import learn_in_stage
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import Floor
from twonav_cli.stages.fitting import check_robot_fits
from twonav_cli.stages.opening import localizer_sha256
from twonav_cli.terminal.learning_place import place_of_floor
from twonav_cli.terminal.train import ALREADY_LEARNED, USUAL_BASE, TrainRequest
from twonav_cli.terminal.train_agent import Saver, check_same_run, metrics_of, recorded, run_started, with_progress

if TYPE_CHECKING:
    from twonav_cli.stages.sim2d_stage import Sim2dOptions
    from twonav_cli.stages.sim3d_stage import Sim3dOptions
    from twonav_cli.stages.stage import Stage

TRIALS = {"2d": 20_000, "3d": 1_500}
"""Trials after which learning on from the stage before gives up (ours)."""

QUICK_TRIALS = 6


def train_driven(
    request: TrainRequest, floor: Floor, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Learn every goal in 2D or 3D, from what was learned in the stage before or from nothing, and save the agent.

    Returns:
        The outcome ("learned", ALREADY_LEARNED, "quick", "stopped" or "gave-up") and the metrics of the card.

    Raises:
        TwonavError: The stage before is missing, a checkpoint does not belong here, or the robot does not get to a
            goal.
    """
    check_robot_fits(floor)
    agent = _agent(request, floor, folder)
    if request.resume and agent.progress.learned.all():
        return ALREADY_LEARNED, metrics_of(outcome_of("learned", agent))
    stage, place = _stage(request, floor), place_of_floor(floor)
    saver = Saver(request, place, folder, agent, made_with=_made_with(request, floor))

    def saved_and_asked() -> bool:
        saver.save_if_due()
        return should_stop()

    def learn(sink: Sink) -> LearningOutcome:
        try:
            return learn_in_stage(stage, agent, request.seed, sink, saved_and_asked, _last_trial(request, agent))
        finally:
            stage.close()

    begun = run_started(request, place, agent)
    result = recorded(request, begun, agent, with_progress(request.stage, agent, learn))
    metrics = metrics_of(result)
    saver.save(metrics)
    return ("quick" if request.quick and result.outcome == "gave-up" else result.outcome), metrics


def _last_trial(request: TrainRequest, agent: Agent) -> int:
    """Return after which trial the run gives up."""
    if request.quick:
        return agent.progress.trial + QUICK_TRIALS
    most = TRIALS[request.stage] if request.transfer else TRIALS_FROM_NOTHING
    # One that gave up and is to go on gets as many again.
    return most * (agent.progress.trial // most + 1)


def _agent(request: TrainRequest, floor: Floor, folder: Path) -> Agent:
    """Return the agent to train: that of the run to go on with, that of the stage before, or one that knows nothing."""
    scene, digest = floor.scene, floor.map.digest
    if request.resume:
        check_same_run(request, folder)
        card = read_card(folder)
        if (begun := card.get("command")) != request.command():
            raise TwonavError(f"the run in {folder} was begun otherwise: go on with `{begun} --resume`")
        now = _made_with(request, floor)
        if any(card.get(key, value) != value for key, value in now.items()):
            raise TwonavError(f"the run in {folder} was begun with another localizer: train it anew, without --resume")
        return Agent.load(folder, scene.digest, digest)
    config = learning_preset(request.stage)
    if not request.transfer:
        return Agent.for_maze(floor.maze, config, request.seed)
    name = STAGE_BEFORE[request.stage]
    before = checkpoint_folder(scene.name, name, None, True, scene.digest, digest, floor.map_source)
    return Agent.load(before, scene.digest, digest, config)


def _stage(request: TrainRequest, floor: Floor) -> Stage:
    localize = load_localize(floor, own_first=True) if request.stage == "3d" else None
    return make_stage(floor, request.stage, localize, request.seed, _options(request))


def _made_with(request: TrainRequest, floor: Floor) -> dict[str, Any]:
    """Return which localizer an agent in 3D learns with, for its card."""
    return {"localizer_sha256": localizer_sha256(floor, own_first=True)} if request.stage == "3d" else {}


def _options(request: TrainRequest) -> Sim2dOptions | Sim3dOptions:
    base = request.base or USUAL_BASE
    if request.stage == "2d":
        from twonav_cli.stages.sim2d_stage import Sim2dOptions

        return Sim2dOptions(base=base)
    from twonav_cli.stages.sim3d_stage import Sim3dOptions

    return Sim3dOptions(base=base, trace=request.recording)
