"""`twonav play`: puts scene, stage, agent, recorder and screen together."""

from __future__ import annotations

import contextlib
import queue
import sys
import threading
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.events import Clock, Looked, Note, RunEnded, RunStarted, Sink, to_all
from twonav_cli.terminal.choices import check_choices
from twonav_cli.terminal.commands import Command
from twonav_cli.terminal.console import screen_possible
from twonav_cli.terminal.map_source import notice_of

if TYPE_CHECKING:
    from twonav_cli.experiments.journey import Wishes
    from twonav_cli.grid import Cell
    from twonav_cli.mapping.floor import Floor
    from twonav_cli.stages.sim2d_stage import Sim2dOptions
    from twonav_cli.stages.sim3d_stage import Sim3dOptions
    from twonav_cli.stages.stage import Stage

STAGES = ("maze", "2d", "3d")


@dataclass(frozen=True)
class PlayRequest:
    """Everything the command line says about a play run."""

    scene: str = "apartment"
    stage: str = "3d"
    goals: tuple[str, ...] = ()
    start: str | None = None
    seed: int = 0
    record: Path | None = None
    recording: bool = True
    plain: bool = False
    localizer: str = "filtered"
    base: str = "omni"
    speed: float = 4.0
    checkpoints: Path | None = None
    map_from: str | None = None
    keys: str | None = None
    quiet: bool = False


def run_play(request: PlayRequest) -> int:
    """Play; returns 0 when every goal was reached, else 1."""
    check_choices(request.stage, STAGES, request.localizer, request.base)
    path = _recording_path(request) if request.recording else None
    if not request.plain and screen_possible():
        from twonav_cli.terminal.screen.play_screen import run_screen

        def start(sink: Sink, commands: queue.Queue[Command], stop: threading.Event) -> int:
            from twonav_cli.terminal.wishes import QueuedWishes

            return _drive(request, sink, QueuedWishes(commands, stop, request.speed), path, stay=True)

        title = f"twonav: {request.scene}, {request.stage}"
        code = run_screen(start, title=title, keys=request.keys, speed=request.speed)
    else:
        code = _play_plainly(request, path)
    if path is not None and path.exists():
        print(path, file=sys.stderr if request.quiet else sys.stdout)
    return code


def _play_plainly(request: PlayRequest, path: Path | None) -> int:
    from twonav_cli.events import to_nobody
    from twonav_cli.experiments.journey import NoWishes
    from twonav_cli.terminal.plain import PlainPrinter

    if not request.goals:
        raise TwonavError("without a terminal, name at least one goal: --goal NAME")
    stop = threading.Event()
    printer = to_nobody if request.quiet else PlainPrinter(sys.stdout)
    return _drive(request, printer, NoWishes(stop), path, stay=False)


def _drive(request: PlayRequest, sink: Sink, wishes: Wishes, path: Path | None, stay: bool) -> int:
    """Build everything and run the journey; the floor plan leaves before anything slow is loaded."""
    from twonav_cli.mapping.floor import read_floor

    floor = read_floor(request.scene, request.map_from, chosen=request.checkpoints)
    start = _start_cell(floor, request)
    begun = RunStarted(
        Clock(), "play", request.stage, floor.scene.name, request.seed, _settings(request),
        floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame,
    )  # fmt: skip
    sink(begun)
    from twonav_cli.experiments.journey import Journey
    from twonav_cli.experiments.predecessors import load_agent
    from twonav_cli.rng import stream
    from twonav_cli.terminal.recordings import recording

    agent = load_agent(floor, request.stage, request.checkpoints)
    stage = _make_stage(request, floor, start, sink)
    notice = notice_of(floor, request.scene, request.map_from)
    if notice is not None and stay:
        sink(Note(Clock(), "INFO", notice))
    with contextlib.closing(stage), recording(path, request.stage, begun, every_trial=True) as recorder:
        journey = Journey(
            stage, floor.maze_frame, agent, stream(request.seed, "explore"), to_all(recorder, sink), wishes
        )
        visits = journey.run(request.goals, start, stay)
        reached = [visit.goal for visit in visits if visit.outcome == "reached"]
        ended = RunEnded(
            Clock(len(visits), sum(visit.steps for visit in visits), stage.time_s),
            f"{len(reached)} of {len(visits)} goals reached",
        )
        to_all(recorder, sink)(ended)
    if notice is not None and not stay and not request.quiet:
        print(notice, file=sys.stderr)
    failed = any(visit.outcome not in ("reached", "given-up") for visit in visits)
    return 1 if failed or Counter(request.goals) - Counter(reached) else 0


def _make_stage(request: PlayRequest, floor: Floor, start: Cell, sink: Sink) -> Stage:
    """Return the stage; in 3D the first picture leaves before the localizer, which is slow to load, is there."""
    from twonav_cli.experiments.predecessors import checkpoint_folder, load_localize, make_stage
    from twonav_cli.stages.sim3d_stage import Sim3dStage

    uses_camera = request.localizer != "truth"
    if request.stage == "3d" and uses_camera:
        # Known to be there before anything is built.
        checkpoint_folder(floor.scene.name, "localizer", request.checkpoints, map_source=floor.map_source)
    stage = make_stage(floor, request.stage, None, request.seed, _options(request))
    if not isinstance(stage, Sim3dStage):
        return stage
    sink(Looked(Clock(), *stage.picture(start)))
    if uses_camera:
        filtered = request.localizer == "filtered"
        stage.localize = load_localize(floor, request.checkpoints, filtered=filtered, seed=request.seed)
    return stage


def _options(request: PlayRequest) -> Sim2dOptions | Sim3dOptions | None:
    if request.stage == "maze":
        return None
    if request.stage == "2d":
        from twonav_cli.stages.sim2d_stage import Sim2dOptions

        return Sim2dOptions(base=request.base, ticks=not request.quiet, trace=request.recording)
    from twonav_cli.stages.sim3d_stage import Sim3dOptions

    return Sim3dOptions(base=request.base, image_every_tick=not request.quiet, trace=request.recording)


def _settings(request: PlayRequest) -> dict[str, str]:
    if request.stage == "2d":
        return {"base": request.base}
    return {"localizer": request.localizer, "base": request.base} if request.stage == "3d" else {}


def _start_cell(floor: Floor, request: PlayRequest) -> Cell:
    """Return the named start's cell, or one drawn from the seed; check the goals' names before anything is loaded."""
    from twonav_cli.rng import stream

    for goal in request.goals:
        if goal not in floor.maze.goals:
            raise unknown_name("goal", goal, floor.maze.goals)
    starts = floor.maze.starts
    if request.start is None:
        names = list(starts)
        return starts[names[int(stream(request.seed, "start").integers(len(names)))]]
    if request.start not in starts:
        raise unknown_name("start", request.start, starts)
    return starts[request.start]


def _recording_path(request: PlayRequest) -> Path:
    if request.record is not None:
        return request.record
    from twonav_cli.terminal.recordings import default_recording

    return default_recording("play", request.scene, request.stage)
