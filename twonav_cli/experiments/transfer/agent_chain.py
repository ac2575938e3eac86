"""One agent through its stages: learn, then drive every goal from every start; what is there already is kept.

It runs in a process of its own that may be killed at any moment: the agent is written every half minute, with the
trials so far in its card.
"""

from __future__ import annotations

import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.checkpoint import CARD_FILE, Card, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.events import to_all, to_nobody
from twonav_cli.experiments.evaluation import evaluate_pairs
from twonav_cli.experiments.learning_progress import outcome_of
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.experiments.shared_evaluation import Drive, stage_of
from twonav_cli.experiments.transfer.request import CHAINS, FROM_NOTHING, TransferRequest
from twonav_cli.experiments.transfer.stage_history import StageHistory
from twonav_cli.experiments.trials import learn_in_stage
from twonav_cli.learner.agent import Agent, saved_settings
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.stages.opening import localizer_sha256

if TYPE_CHECKING:
    from twonav_cli.stages.stage import Stage

SAVE_EVERY_S = 30.0

TRIALS_AT_MOST, TRIALS_FROM_NOTHING = 20_000, 14_000
"""Trials after which an agent gives up: on the way from the maze (ours), and from nothing (Table 10)."""

QUICK_TRIALS = 4


@dataclass(frozen=True)
class AgentJob:
    """One agent of a table, in words that travel to another process."""

    request: TransferRequest
    chain: str
    agent: int

    @property
    def seed(self) -> int:
        """Its seed."""
        return self.request.agent_seed(self.agent)

    def folder(self, floor: Floor, stage: str) -> Path:
        """Return where its agent of a stage lies."""
        return self.request.folder(floor.scene.name, floor.map.digest, self.chain, stage, self.agent)


def run_agent(job: AgentJob) -> int:
    """Train and measure one agent, from where it was left; return how many of its goals are learned in the last stage.

    Raises:
        TwonavError: A goal cannot be reached, a checkpoint is damaged or of another map, or there is no localizer.
    """
    floor = read_floor(job.request.scene, job.request.map_from, own_first=True)
    before: Agent | None = None
    for stage in CHAINS[job.chain]:
        before = _stage_run(job, floor, stage, before)
    assert before is not None
    return int(before.progress.learned.sum())


def finished_card(job: AgentJob, floor: Floor, stage: str) -> Card | None:
    """Return the card of an agent that has learned a stage and was measured; None where there is none.

    Raises:
        TwonavError: It is damaged, of another version of the scene, or was trained otherwise.
    """
    card = _card_of(job, floor, stage)
    return card if card is not None and card.get("metrics", {}).get("done") else None


def _card_of(job: AgentJob, floor: Floor, stage: str) -> Card | None:
    folder = job.folder(floor, stage)
    if not (folder / CARD_FILE).is_file():
        return None
    card = read_card(folder)
    if not _is_trained_so(job, card, stage):
        raise TwonavError(f"the agent in {folder} was trained with other settings: delete the folder to train it anew")
    if (card.get("scene_digest"), card.get("map_digest")) != (floor.scene.digest, floor.map.digest):
        raise TwonavError(f"the agent in {folder} is of another version of the scene: delete the folder to train anew")
    known = card.get("localizer_sha256")
    if known is not None and known != _localizer(job, floor, stage):
        raise TwonavError(f"the agent in {folder} learned with another localizer: delete the folder to train it anew")
    return card


def _is_trained_so(job: AgentJob, card: Card, stage: str) -> bool:
    """Whether a card's settings are those of the request; a setting that came later counts as the usual one."""
    try:
        return saved_settings(card) == job.request.learning(stage)
    except (KeyError, TypeError):
        return False


def _localizer(job: AgentJob, floor: Floor, stage: str) -> str | None:
    """Return the checksum of the localizer that tells an agent in 3D where it is; None where none is asked."""
    if stage != "3d" or job.request.localizer == "truth":
        return None
    return localizer_sha256(floor, own_first=True)


def _stage_run(job: AgentJob, floor: Floor, name: str, before: Agent | None) -> Agent:
    """Return the agent of a stage, trained and measured."""
    folder = job.folder(floor, name)
    card, digests = _card_of(job, floor, name), (floor.scene.digest, floor.map.digest)
    if card is None:
        agent = _fresh(job, floor, name, folder, before)
    else:
        agent = Agent.load(folder, *digests)
        if card.get("metrics", {}).get("done"):
            return agent
    history = StageHistory.of_card(card or {}, agent.goal_names)
    saver = _Saver(job, floor, name, folder, agent, history)
    world = stage_of(_drive(job, name), floor)
    try:
        if not _ended(job, world, agent):
            _learn(job, floor, world, agent, history, saver)
            saver.save({})
        # As everybody drives it who loads it: with nothing in its replay buffer.
        driven = Agent.load(folder, *digests, job.request.learning(name))
        pairs = evaluate_pairs(world, driven, job.seed, to_nobody, lambda pair: None, lambda: False).pairs
    finally:
        world.close()
    saver.save({"done": True, "pairs": [asdict(pair) for pair in pairs]})
    return agent


def _fresh(job: AgentJob, floor: Floor, name: str, folder: Path, before: Agent | None) -> Agent:
    """Return the agent with which a stage begins."""
    config = job.request.learning(name)
    if before is None:
        return Agent.for_maze(floor.maze, config, job.seed)
    earlier = CHAINS[job.chain][CHAINS[job.chain].index(name) - 1]
    return Agent.load(job.folder(floor, earlier), floor.scene.digest, floor.map.digest, config)


def _drive(job: AgentJob, name: str) -> Drive:
    request = job.request
    return Drive(
        request.scene, name, request.localizer, request.base, job.seed, map_from=request.map_from, own_first=True
    )


def trials_at_most(chain: str, quick: bool) -> int:
    """Return after how many trials of a stage an agent of a chain gives up."""
    if quick:
        return QUICK_TRIALS
    return TRIALS_FROM_NOTHING if chain == FROM_NOTHING else TRIALS_AT_MOST


def _last_trial(job: AgentJob) -> int:
    return trials_at_most(job.chain, job.request.quick)


def _ended(job: AgentJob, world: Stage, agent: Agent) -> bool:
    """Whether learning is over: in the maze when everything is learned, elsewhere also when it gives up."""
    gave_up = world.name != "maze" and agent.progress.trial >= _last_trial(job)
    return bool(agent.progress.learned.all()) or gave_up


def _learn(job: AgentJob, floor: Floor, world: Stage, agent: Agent, history: StageHistory, saver: _Saver) -> None:
    """Learn every goal of a stage; the maze has its compiled loop."""
    begun_s, spent_s = time.monotonic(), history.wall_s

    def saved_and_never() -> bool:
        history.wall_s = spent_s + time.monotonic() - begun_s
        saver.save_if_due()
        return False

    if world.name == "maze":
        # Seconds, and its loop holds the replay buffer until it ends: not saved in between.
        learn_maze(agent, floor.maze, job.seed, history, lambda: False)
    else:
        learn_in_stage(world, agent, job.seed, to_all(history), saved_and_never, _last_trial(job))
    history.wall_s = spent_s + time.monotonic() - begun_s


class _Saver:
    """Writes an agent with its history."""

    def __init__(
        self, job: AgentJob, floor: Floor, stage: str, folder: Path, agent: Agent, history: StageHistory
    ) -> None:
        self._job, self._floor, self._stage = job, floor, stage
        self._folder, self._agent, self._history = folder, agent, history
        self._saved_at = time.monotonic()

    def save_if_due(self) -> None:
        """Write it if the last time is long ago."""
        if time.monotonic() - self._saved_at > SAVE_EVERY_S:
            self.save({})

    def save(self, metrics: dict[str, Any]) -> None:
        """Write it, with some metrics more."""
        job, floor = self._job, self._floor
        told = outcome_of("learned" if self._agent.progress.learned.all() else "gave-up", self._agent)
        card = {
            "scene": floor.scene.name,
            "scene_digest": floor.scene.digest,
            "map_digest": floor.map.digest,
            "stage": self._stage,
            "command": job.request.command(),
            **({"localizer_sha256": found} if (found := _localizer(job, self._floor, self._stage)) else {}),
            "seed": job.seed,
            "metrics": {"trials": told.trials, "steps": told.steps, "history": self._history.kept(), **metrics},
        }
        self._agent.save(self._folder, card)
        self._saved_at = time.monotonic()
