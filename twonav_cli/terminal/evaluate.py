"""`twonav evaluate`: the figures, as a table for people or one JSON object for scripts."""

from __future__ import annotations

import contextlib
import json
import time
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
    from twonav_cli.experiments.repeats import StoppedError
    from twonav_cli.terminal.localizer_figures import print_figures

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
        if request.record is not None:
            raise TwonavError("--record is not for --stage localizer: leave it out")
        if request.network is not None:
            from twonav_cli.localizer.networks import network_spec

            network_spec(request.network)
        return
    for name in OF_LOCALIZER:
        if getattr(request, name) is not None:
            option = "--" + name.replace("_", "-")
            raise TwonavError(f"{option} is for --stage localizer only: leave it out, or evaluate the localizer")


def _pairs(request: EvaluateRequest, floor: Floor, should_stop: Callable[[], bool]) -> dict[str, Any]:
    from twonav_cli.experiments.evaluation import evaluate_pairs
    from twonav_cli.experiments.predecessors import load_agent, load_localize, make_stage
    from twonav_cli.terminal.recordings import recording

    agent = load_agent(floor, request.stage, request.checkpoints)
    uses_camera, filtered = request.stage == "3d" and request.localizer != "truth", request.localizer == "filtered"
    localize = load_localize(floor, request.checkpoints, filtered=filtered, seed=request.seed) if uses_camera else None
    stage = make_stage(floor, request.stage, localize, request.seed, _options(request))
    begun = RunStarted(
        Clock(), "evaluate", request.stage, floor.scene.name, request.seed, {"localizer": request.localizer},
        floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame,
    )  # fmt: skip
    wanted = len(floor.maze.goals) * len(floor.maze.starts)
    with contextlib.closing(stage), progress() as bar, recording(request.record, request.stage, begun) as recorder:
        task = bar.add_task(f"pairs, {request.stage} {request.localizer}", total=wanted, result="")
        reached = 0

        def show(pair: PairResult) -> None:
            nonlocal reached
            reached += pair.success
            bar.update(task, advance=1, result=f"{reached} reached")
            if not pair.success:
                bar.console.print(f"{pair.start} to {pair.goal}: {pair.outcome}, {pair.cause}")

        begun_s = time.monotonic()
        table: PairTable = evaluate_pairs(stage, agent, request.seed, recorder, show, should_stop)
        wall_s = time.monotonic() - begun_s
        recorder(RunEnded(Clock(len(table.pairs)), f"{reached} of {len(table.pairs)}"))
    actions = sum(pair.actions for pair in table.pairs)
    settings = {"scene": floor.scene.name, "stage": request.stage, "localizer": request.localizer, "seed": request.seed}
    return {**table.report(), "actions_per_s": actions / wall_s if wall_s else None, "settings": settings}


def _options(request: EvaluateRequest) -> Any:
    if request.stage == "maze":
        return None
    watched = request.record is not None
    if request.stage == "2d":
        from twonav_cli.stages.sim2d_stage import Sim2dOptions

        return Sim2dOptions(base=request.base, ticks=watched, trace=watched)
    from twonav_cli.stages.sim3d_stage import Sim3dOptions

    return Sim3dOptions(base=request.base, trace=watched)


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
    for heading in ("goal", "reached", "actions", "shortest", "ratio", "SPL"):
        table.add_column(heading, justify="left" if heading == "goal" else "right")
    for goal, row in [*report["per_goal"].items(), ("all", report)]:
        numbers = [_number(row[key], 2) for key in ("actions_mean", "shortest_mean", "ratio", "spl")]
        table.add_row(goal, f"{row['successes']} of {row['pairs']}", *numbers)
    out().print(table)
    causes = ", ".join(f"{cause} {count}" for cause, count in report["causes"].items()) or "none"
    out().print(f"failures: {causes}; collisions: {report['collisions']}")
    out().print(f"{_number(report['actions_per_s'], 1)} actions per second")


def _number(value: float | None, digits: int) -> str:
    return "-" if value is None else f"{value:.{digits}f}"
