"""`twonav evaluate`: the figures, as a table for people or one JSON object for scripts."""

from __future__ import annotations

import contextlib
import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.table import Table

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, RunEnded, RunStarted
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.terminal.choices import check_choices
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.map_source import tell_source

if TYPE_CHECKING:
    from twonav_cli.experiments.evaluation import PairResult, PairTable
    from twonav_cli.experiments.shared_evaluation import Drive

STAGES = ("maze", "2d", "3d", "localizer")


@dataclass(frozen=True)
class EvaluateRequest:
    """Everything the command line says about an evaluation."""

    stage: str = "3d"
    localizer: str = "raw"
    scene: str = "apartment"
    seed: int = 0
    record: Path | None = None
    base: str = "omni"
    frames: int | None = None
    track_frames: int | None = None
    kidnap_frames: int | None = None
    network: str | None = None
    checkpoints: Path | None = None
    map_from: str | None = None
    repeats: int = 1
    workers: int = 1
    as_json: bool = False


OF_LOCALIZER = ("network", "frames", "track_frames", "kidnap_frames")
"""Options that only the localizer's stage looks at."""


def run_evaluate(request: EvaluateRequest) -> int:
    """Measure and print; returns 0, or 130 when interrupted (the pairs that were driven are printed)."""
    check_choices(request.stage, STAGES, request.localizer, request.base)
    _check_options(request)
    floor = read_floor(request.scene, request.map_from, chosen=request.checkpoints)
    if request.stage == "localizer":
        return _measure_localizer(request, floor)
    with StopOnInterrupt("stopping after this pair") as stop:
        report = _pairs(request, floor, stop)
        print(json.dumps(report)) if request.as_json else _print_pairs(report)
        tell_source(floor, request.scene, request.map_from)
        return 130 if stop() else 0


def _measure_localizer(request: EvaluateRequest, floor: Floor) -> int:
    """Measure a localizer and print its figures; returns 0, or 130 when interrupted."""
    from twonav_cli.terminal.localizer_figures import print_figures
    from twonav_cli.worker_pool import StoppedError

    with StopOnInterrupt("stopping: nothing is kept") as stop:
        try:
            report = _localizer_report(request, floor, stop)
        except StoppedError:
            return 130
    print(json.dumps(report)) if request.as_json else print_figures(report)
    tell_source(floor, request.scene, request.map_from)
    return 0


def _check_options(request: EvaluateRequest) -> None:
    """Refuse what the stage would not look at.

    Raises:
        TwonavError: Says what to leave out, or that there is no network of that name.
    """
    if request.stage == "localizer":
        asked = {"--record": request.record, "--repeats": request.repeats > 1, "--workers": request.workers > 1}
        for option, given in asked.items():
            if given:
                raise TwonavError(f"{option} is not for --stage localizer: leave it out")
        if request.network is not None:
            from twonav_cli.localizer.networks import network_spec

            network_spec(request.network)
        return
    if request.record is not None and request.workers > 1:
        raise TwonavError("--record needs one worker: leave --workers out")
    for name in OF_LOCALIZER:
        if getattr(request, name) is not None:
            option = "--" + name.replace("_", "-")
            raise TwonavError(f"{option} is for --stage localizer only: leave it out, or evaluate the localizer")


def _pairs(request: EvaluateRequest, floor: Floor, should_stop: Callable[[], bool]) -> dict[str, Any]:
    from twonav_cli.experiments.shared_evaluation import Drive, evaluate_shared

    drive = Drive(
        request.scene, request.stage, request.localizer, request.base, request.seed, request.checkpoints,
        request.map_from, watched=request.record is not None,
    )  # fmt: skip
    wanted = len(floor.maze.goals) * len(floor.maze.starts) * request.repeats
    title = f"pairs, {request.stage}" + (f" {request.localizer}" if request.stage == "3d" else "")
    with progress() as bar:
        task = bar.add_task(title, total=wanted, result="")
        reached = 0

        def show(pair: PairResult) -> None:
            nonlocal reached
            reached += pair.success
            bar.update(task, advance=1, result=f"{reached} reached")
            if not pair.success:
                bar.console.print(f"{pair.start} to {pair.goal}: {pair.outcome}, {pair.cause}")

        if request.workers > 1:
            table = evaluate_shared(drive, floor, request.repeats, request.workers, show, should_stop)
        else:
            table = _driven_here(request, drive, floor, show, should_stop)
    settings = {
        "scene": floor.scene.name, "stage": request.stage, "localizer": request.localizer, "base": request.base,
        "seed": request.seed, "repeats": request.repeats, "workers": request.workers,
    }  # fmt: skip
    return {**table.report(), "settings": settings}


def _settings(request: EvaluateRequest) -> dict[str, str]:
    """Return what a stage looks at."""
    base = {} if request.stage == "maze" else {"base": request.base}
    return base | ({"localizer": request.localizer} if request.stage == "3d" else {})


def _driven_here(
    request: EvaluateRequest,
    drive: Drive,
    floor: Floor,
    on_pair: Callable[[PairResult], None],
    should_stop: Callable[[], bool],
) -> PairTable:
    """Drive all pairs in this process, and record them if that is wanted."""
    from twonav_cli.experiments.evaluation import evaluate_pairs, pairs_of
    from twonav_cli.experiments.shared_evaluation import open_drive
    from twonav_cli.terminal.recordings import recording

    stage, agent = open_drive(drive, floor)
    begun = RunStarted(
        Clock(), "evaluate", request.stage, floor.scene.name, request.seed, _settings(request),
        floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame,
    )  # fmt: skip
    pairs = pairs_of(floor.maze, request.repeats)
    with contextlib.closing(stage), recording(request.record, request.stage, begun) as recorder:
        table = evaluate_pairs(stage, agent, request.seed, recorder, on_pair, should_stop, pairs)
        reached = sum(pair.success for pair in table.pairs)
        recorder(RunEnded(Clock(len(table.pairs)), f"{reached} of {len(table.pairs)}"))
    return table


def _localizer_report(request: EvaluateRequest, floor: Floor, should_stop: Callable[[], bool]) -> dict[str, Any]:
    """Return the figures of a localizer, beside the rows of the most alike training frame."""
    from twonav_cli.experiments.localizer_report import ReportConfig
    from twonav_cli.experiments.predecessors import checkpoint_folder, localizer_name
    from twonav_cli.terminal.localizer_figures import figures_of

    scene, digest = floor.scene, floor.map.digest
    name = localizer_name(request.network)
    folder = checkpoint_folder(scene.name, name, request.checkpoints, False, scene.digest, digest, floor.map_source)
    asked = {name: value for name in OF_LOCALIZER[1:] if (value := getattr(request, name)) is not None}
    config = ReportConfig(**asked)
    return figures_of(floor, folder, config, request.seed, should_stop)


def _print_pairs(report: dict[str, Any]) -> None:
    from twonav_cli.terminal.console import out

    table = Table(box=None, pad_edge=False)
    for heading in ("goal", "reached", "actions", "±", "shortest", "ratio", "SPL"):
        table.add_column(heading, justify="left" if heading == "goal" else "right")
    for goal, row in [*report["per_goal"].items(), ("all", report)]:
        numbers = [_number(row[key], 2) for key in ("actions_mean", "actions_std", "shortest_mean", "ratio", "spl")]
        table.add_row(goal, f"{row['successes']} of {row['pairs']}", *numbers)
    out().print(table)
    causes = ", ".join(f"{cause} {count}" for cause, count in report["causes"].items()) or "none"
    per_100 = [_number(report[f"{name}_per_100_actions"], 2) for name in ("collisions", "wrong_cells")]
    out().print(f"failures: {causes}")
    out().print(f"of 100 actions {per_100[0]} control periods at an obstacle, {per_100[1]} ends in another cell")
    out().print(
        f"an action takes {_number(report['sim_s_per_action'], 2)} s; "
        f"{_number(report['actions_per_s'], 1)} actions per second and process here"
    )


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
