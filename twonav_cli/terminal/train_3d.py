"""Training the agent in 3D from the command line, with the localizer's poses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.config import learning_preset
from twonav_cli.events import Sink
from twonav_cli.experiments.learning_progress import LearningOutcome
from twonav_cli.experiments.predecessors import checkpoint_folder, load_localize, make_stage
from twonav_cli.experiments.trials import learn_in_stage
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import Floor
from twonav_cli.terminal.learning_place import place_of_floor
from twonav_cli.terminal.train import USUAL_BASE, TrainRequest
from twonav_cli.terminal.train_agent import Saver, check_same_run, metrics_of, recorded, run_started, with_progress

if TYPE_CHECKING:
    from twonav_cli.stages.sim3d_stage import Sim3dStage

TRIALS = 1500
QUICK_TRIALS = 6


def train_3d(
    request: TrainRequest, floor: Floor, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Learn every goal in 3D, from what was learned in the maze, and save the agent.

    Returns:
        The outcome ("learned", "quick", "stopped" or "gave-up") and the metrics of the card.

    Raises:
        TwonavError: The stage before is missing, or a checkpoint does not belong here.
    """
    agent = _agent(request, floor, folder)
    stage, place = _stage(request, floor), place_of_floor(floor)
    saver = Saver(request, place, folder, agent)

    def saved_and_asked() -> bool:
        saver.save_if_due()
        return should_stop()

    def learn(sink: Sink) -> LearningOutcome:
        trials = QUICK_TRIALS if request.quick else TRIALS
        try:
            return learn_in_stage(stage, agent, request.seed, sink, saved_and_asked, agent.progress.trial + trials)
        finally:
            stage.close()

    result = recorded(request, run_started(request, place, agent), agent, with_progress("3d", agent, learn))
    metrics = metrics_of(result)
    saver.save(metrics)
    return ("quick" if request.quick and result.outcome == "gave-up" else result.outcome), metrics


def _agent(request: TrainRequest, floor: Floor, folder: Path) -> Agent:
    """Return the agent to train: that of the run to go on with, or the maze's."""
    scene, digest = floor.scene, floor.map.digest
    if request.resume:
        check_same_run(request, folder)
        return Agent.load(folder, scene.digest, digest)
    before = checkpoint_folder(scene.name, "maze", None, True, scene.digest, digest, floor.map_source)
    return Agent.load(before, scene.digest, digest, learning_preset("3d"))


def _stage(request: TrainRequest, floor: Floor) -> Sim3dStage:
    from twonav_cli.stages.sim3d_stage import Sim3dOptions

    localize = load_localize(floor, own_first=True)
    options = Sim3dOptions(base=request.base or USUAL_BASE, trace=request.recording)
    return make_stage(floor, "3d", localize, request.seed, options)  # type: ignore[return-value]  # by name
