"""An evaluation shared among processes: each opens the stage once and drives some of the pairs."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.events import to_nobody
from twonav_cli.experiments.evaluation import Pair, PairResult, PairTable, evaluate_pairs, pairs_of
from twonav_cli.worker_pool import StoppedError, done_in_workers

if TYPE_CHECKING:
    from twonav_cli.learner.agent import Agent
    from twonav_cli.mapping.floor import Floor
    from twonav_cli.stages.stage import Stage

PAIRS_PER_CHUNK = 10
"""Pairs that a worker drives at once, so that the progress bar moves (ours)."""


@dataclass(frozen=True)
class Drive:
    """What is driven, in words that travel to another process.

    Attributes:
        scene: Name or path.
        stage: "maze", "2d" or "3d".
        localizer: "truth", "raw" or "filtered"; 3d only.
        base: "omni" or "differential".
        seed: Of the evaluation.
        checkpoints: Folder of a scene's checkpoints; None for those that are shipped.
        map_from: "survey", "geometry" or None.
        watched: Whether every control period is sent, with what the controller weighed.
        own_first: Whether a localizer of the user's own goes before the shipped one.
    """

    scene: str
    stage: str
    localizer: str = "raw"
    base: str = "omni"
    seed: int = 0
    checkpoints: Path | None = None
    map_from: str | None = None
    watched: bool = False
    own_first: bool = False


def open_drive(drive: Drive, floor: Floor) -> tuple[Stage, Agent]:
    """Return the stage and the agent of a drive.

    Raises:
        TwonavError: A checkpoint is missing or does not belong here, or there is no renderer.
    """
    from twonav_cli.experiments.predecessors import load_agent

    agent = load_agent(floor, drive.stage, drive.checkpoints)
    return stage_of(drive, floor), agent


def stage_of(drive: Drive, floor: Floor) -> Stage:
    """Return the stage of a drive.

    Raises:
        TwonavError: There is no localizer, or no renderer.
    """
    from twonav_cli.experiments.predecessors import load_localize, make_stage

    localize = None
    if drive.stage == "3d" and drive.localizer != "truth":
        filtered = drive.localizer == "filtered"
        localize = load_localize(floor, drive.checkpoints, drive.own_first, filtered=filtered, seed=drive.seed)
    return make_stage(floor, drive.stage, localize, drive.seed, _options(drive))


def _options(drive: Drive) -> Any:
    if drive.stage == "maze":
        return None
    if drive.stage == "2d":
        from twonav_cli.stages.sim2d_stage import Sim2dOptions

        return Sim2dOptions(base=drive.base, ticks=drive.watched, trace=drive.watched)
    from twonav_cli.stages.sim3d_stage import Sim3dOptions

    return Sim3dOptions(base=drive.base, trace=drive.watched)


@dataclass(frozen=True)
class Chunk:
    """Some pairs that a worker drives at once."""

    drive: Drive
    pairs: tuple[Pair, ...]


@lru_cache(maxsize=1)
def _opened(drive: Drive) -> tuple[Stage, Agent]:
    """Return the stage and the agent of a drive: each worker opens them once."""
    from twonav_cli.mapping.floor import read_floor

    return open_drive(drive, read_floor(drive.scene, drive.map_from, chosen=drive.checkpoints))


def drive_chunk(chunk: Chunk) -> list[PairResult]:
    """Drive the pairs of a chunk."""
    stage, agent = _opened(chunk.drive)
    return evaluate_pairs(
        stage, agent, chunk.drive.seed, to_nobody, lambda pair: None, lambda: False, chunk.pairs
    ).pairs


def evaluate_shared(
    drive: Drive,
    floor: Floor,
    repeats: int,
    workers: int,
    on_pair: Callable[[PairResult], None],
    should_stop: Callable[[], bool],
) -> PairTable:
    """Drive every goal from every start, as often as asked, in several processes; the results are those of one.

    Args:
        drive: What is driven.
        floor: Its floor.
        repeats: How often.
        workers: How many processes.
        on_pair: Called after each pair, as they end.
        should_stop: Asked several times a second; True ends the evaluation early.

    Raises:
        TwonavError: A checkpoint is missing or does not belong here, or a worker was killed.
    """
    pairs = pairs_of(floor.maze, repeats)
    chunks = [
        Chunk(drive, tuple(pairs[first : first + PAIRS_PER_CHUNK])) for first in range(0, len(pairs), PAIRS_PER_CHUNK)
    ]
    found: dict[int, list[PairResult]] = {}
    try:
        for number, results in done_in_workers(drive_chunk, chunks, workers, should_stop, "try again with --workers 1"):
            found[number] = results
            for result in results:
                on_pair(result)
    except StoppedError:
        pass  # what was driven counts
    return PairTable([result for number in sorted(found) for result in found[number]])
