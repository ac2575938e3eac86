"""`twonav train`: one stage at a time, interruptible, resumable, recorded."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.checkpoint import CARD_FILE, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.predecessors import localizer_name
from twonav_cli.files import writable
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.choices import check_choices
from twonav_cli.terminal.console import screen_possible
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.learning_choices import LearningChoices, option_of
from twonav_cli.terminal.map_source import tell_source

if TYPE_CHECKING:
    from twonav_cli.terminal.learning_place import LearningPlace

STAGES = ("map", "maze", "2d", "frames", "localizer", "3d", "all")
DRIVEN = ("map", "2d", "3d", "all")
"""Stages in which a robot with a base drives."""
OF_LOCALIZER = ("network", "images", "device")
"""Options that only the localizer's stage looks at."""
USUAL_SCENE, USUAL_BASE = "apartment", "omni"

ALREADY_LEARNED = "already-learned"
"""The outcome of going on with a run that has nothing left to do."""


@dataclass(frozen=True)
class TrainRequest:
    """Everything the command line says about a training run."""

    stage: str
    scene: str | None = None
    seed: int = 0
    resume: bool = False
    out: Path | None = None
    record: Path | None = None
    recording: bool = True
    quick: bool = False
    images: int | None = None
    network: str | None = None
    device: str | None = None
    base: str | None = None
    transfer: bool = True
    as_json: bool = False
    watch: bool = False
    random_maze: int | None = None
    map_from: str | None = None
    choices: LearningChoices = field(default_factory=LearningChoices)

    @property
    def scene_name(self) -> str:
        """The scene that was named, or the usual one."""
        return self.scene or USUAL_SCENE

    def command(self) -> str:
        """Return the command that repeats this run."""
        where = ["--scene", self.scene_name] if self.random_maze is None else ["--random-maze", str(self.random_maze)]
        parts = ["twonav", "train", "--stage", self.stage, *where, "--seed", str(self.seed)]
        for name in OF_LOCALIZER:
            given = getattr(self, name)
            parts += [] if given is None else [f"--{name}", str(given)]
        if self.stage in DRIVEN:
            parts += ["--base", self.base or USUAL_BASE]
        parts += [] if self.transfer else ["--no-transfer"]
        parts += [] if self.map_from is None else ["--map-from", self.map_from]
        parts += self.choices.arguments()
        return shlex.join(parts + (["--quick"] if self.quick else []))

    def resume_command(self) -> str:
        """Return the command that goes on with this run where it stopped."""
        parts = [self.command(), "--resume"]
        parts += ["--out", shlex.quote(str(self.out))] if self.out is not None else []
        return " ".join(parts + ([] if self.recording else ["--no-record"]))

    def check(self) -> None:
        """Refuse what cannot be, before anything is read.

        Raises:
            TwonavError: Says what to leave out or to name instead.
        """
        check_choices(self.stage, STAGES, base=self.base or USUAL_BASE)
        asked = [option_of(name) for name in self.choices.given()]
        asked += ["--random-maze"] * (self.random_maze is not None) + ["--watch"] * self.watch
        if asked and self.stage != "maze":
            raise TwonavError(f"{asked[0]} is for --stage maze only: leave it out, or train the maze")
        for name in OF_LOCALIZER:
            if getattr(self, name) is not None and self.stage not in ("localizer", "all"):
                raise TwonavError(f"--{name} is for --stage localizer only: leave it out, or train the localizer")
        if self.base is not None and self.stage not in DRIVEN:
            raise TwonavError("--base is for --stage map, 2d and 3d only: leave it out, or name one of them")
        if not self.transfer and self.stage not in ("2d", "3d"):
            raise TwonavError("--no-transfer is for --stage 2d and 3d only: the stages before them begin from nothing")
        self._check_all()
        if self.stage == "map" and (self.resume or self.map_from is not None):
            wrong = "--resume" if self.resume else "--map-from"
            raise TwonavError(f"{wrong} is not for --stage map: leave it out, a survey begins anew and takes a minute")
        if self.random_maze is not None and self.map_from is not None:
            raise TwonavError("a random maze has no map: leave --map-from or --random-maze out")
        if self.random_maze is not None and self.scene is not None:
            raise TwonavError("a random maze has no scene: leave --scene or --random-maze out")
        if self.watch and not screen_possible():
            raise TwonavError(
                "--watch needs a terminal that can move its cursor: leave it out to train without watching"
            )
        if self.network is not None:
            from twonav_cli.localizer.networks import network_spec

            network_spec(self.network)
        if self.stage == "frames" and (self.out is not None or self.record is not None):
            option = "--out" if self.out is not None else "--record"
            raise TwonavError(f"{option} is not for --stage frames: leave it out, frames go to the runs folder")
        self.choices.check()

    def _check_all(self) -> None:
        """Refuse what cannot be asked of several stages at once.

        Raises:
            TwonavError: Says what to leave out.
        """
        asked = {
            "--out": self.out, "--record": self.record, "--network": self.network, "--resume": self.resume or None,
            "--quick": self.quick or None,
        }  # fmt: skip
        for option, given in asked.items():
            if self.stage == "all" and given is not None:
                raise TwonavError(f"{option} is not for --stage all: leave it out, what is there already is kept")


def run_train(request: TrainRequest) -> int:
    """Train a stage; returns 0 when it finished, 130 when it was interrupted and saved, 1 when it did not learn.

    Raises:
        TwonavError: What is asked for cannot be, or something that it needs is missing or damaged.
    """
    request.check()
    if request.stage == "all":
        from twonav_cli.terminal.train_all import run_all

        return run_all(request)
    saying = "stopping: a survey is kept only when it is over" if request.stage == "map" else "stopping: saving first"
    with StopOnInterrupt(saying) as stop:
        folder, outcome, metrics = _trained(request, stop)
    _report(request, folder, outcome, metrics)
    return {"learned": 0, "surveyed": 0, "collected": 0, ALREADY_LEARNED: 0, "quick": 0, "stopped": 130}.get(outcome, 1)


def _trained(request: TrainRequest, stop: StopOnInterrupt) -> tuple[Path, str, dict[str, Any]]:
    """Train what was asked for; return the checkpoint's folder, the outcome, and the metrics of the card."""
    from twonav_cli.terminal.learning_place import place_of_random_maze

    name = localizer_name(request.network) if request.stage == "localizer" else request.stage
    name += "" if request.transfer else "-no-transfer"
    name += "-quick" if request.quick else ""
    if request.stage == "map":
        from twonav_cli.scene.catalog import read_scene
        from twonav_cli.terminal.train_map import train_map

        scene = read_scene(request.scene_name)
        folder = _checked_folder(request, request.out or runs_dir() / scene.name / name)
        return folder, *train_map(request, scene, folder, stop)
    if request.random_maze is None:
        return _trained_on_floor(request, name, stop)
    from twonav_cli.terminal.train_maze import train_maze

    place = place_of_random_maze(request.seed, request.random_maze)
    # Another seed draws another random maze of the same number.
    where = f"random-{request.seed}-{request.random_maze}"
    folder = _checked_folder(request, request.out or runs_dir() / where / name)
    return folder, *train_maze(request, place, folder, stop)


def _trained_on_floor(request: TrainRequest, name: str, stop: StopOnInterrupt) -> tuple[Path, str, dict[str, Any]]:
    """Train a stage that begins from a scene's map."""
    from twonav_cli.mapping.floor import read_floor
    from twonav_cli.terminal.learning_place import place_of_floor

    floor = read_floor(request.scene_name, request.map_from, own_first=True)
    if request.stage == "frames":
        from twonav_cli.terminal.train_frames import train_frames

        collected = train_frames(request, floor, stop)
        tell_source(floor, request.scene_name, request.map_from)
        return collected
    place = place_of_floor(floor)
    folder = _checked_folder(request, request.out or runs_dir() / place.name / name)
    if request.stage == "maze":
        from twonav_cli.terminal.train_maze import train_maze

        result = train_maze(request, place, folder, stop)
    elif request.stage == "localizer":
        from twonav_cli.terminal.train_localizer import train_localizer

        result = train_localizer(request, floor, folder, stop)
    else:
        from twonav_cli.terminal.train_driven import train_driven

        result = train_driven(request, floor, folder, stop)
    tell_source(floor, request.scene_name, request.map_from)
    return folder, *result


def _checked_folder(request: TrainRequest, folder: Path) -> Path:
    """Return the folder of the checkpoint, once it is sure that the run can be saved there and destroys no other.

    Raises:
        TwonavError: It cannot be written, or holds an unfinished run of other settings.
    """
    if request.resume:
        return writable(folder) if folder.is_dir() else folder
    if request.stage == "map":
        from twonav_cli.mapping.known_maps import holds_another

        if holds_another(folder, "scene", request.out is not None):
            raise TwonavError(f"{folder} holds something else than the map of a scene: name another --out")
    if request.out is None and not request.quick and (folder / CARD_FILE).is_file():
        _keep_unfinished(request, folder)
    return writable(folder)


def _keep_unfinished(request: TrainRequest, folder: Path) -> None:
    """Refuse to write over a run that was left in the middle, unless this is the same run from its beginning."""
    try:
        card = read_card(folder)
    except TwonavError:  # nobody can go on with a damaged one
        return
    metrics, command = card.get("metrics", {}), card.get("command", "")
    unfinished = metrics.get("unfinished") or metrics.get("goals_learned", 0) < metrics.get("goals", 0)
    if unfinished and command != request.command():
        raise TwonavError(
            f"an unfinished run of other settings is in {folder}: go on with it ({command} --resume), "
            "or name another folder with --out"
        )


def _report(request: TrainRequest, folder: Path, outcome: str, metrics: dict[str, Any]) -> None:
    if request.as_json:
        place = request.scene_name if request.random_maze is None else f"random-{request.random_maze}"
        told = "learned" if outcome == ALREADY_LEARNED else outcome
        kept = {"folder": str(folder)} if request.stage == "map" else {}
        print(json.dumps({"stage": request.stage, "scene": place, "outcome": told, **metrics, **kept}))
    elif request.stage == "map" and metrics:
        from twonav_cli.terminal.survey_report import survey_sentences

        for sentence in survey_sentences(metrics, shlex.quote(request.scene_name)):
            print(sentence, file=sys.stderr)
    else:
        for name, value in metrics.items():
            print(f"{name}: {value}", file=sys.stderr)
    if outcome == "stopped" and request.stage == "map":
        print(f"stopped: no map was written to {folder}", file=sys.stderr)
    elif outcome == "timed-out":
        print(f"out of time before everything was seen; what was seen is in {folder}", file=sys.stderr)
    elif outcome == "stopped":
        print(f"stopped and saved in {folder}; go on with: {request.resume_command()}", file=sys.stderr)
    elif outcome == ALREADY_LEARNED:
        print(f"already learned: nothing left to do in {folder}", file=sys.stderr)
    elif outcome == "gave-up":
        print(f"gave up before every goal was learned; what was learned is in {folder}", file=sys.stderr)
    elif outcome == "quick":
        done = "mapped" if request.stage == "map" else "learned"
        print(f"a quick run ends here, before anything is {done} well: {folder}", file=sys.stderr)
    else:
        print(f"done: {folder}", file=sys.stderr)


def card_of(request: TrainRequest, place: LearningPlace, metrics: dict[str, Any]) -> dict[str, Any]:
    """Return what every agent's card says about its origin; that of a random maze names the maze."""
    origin = {} if request.random_maze is None else {"random_maze": request.random_maze}
    return {
        "scene": place.name,
        "scene_digest": place.scene_digest,
        "map_digest": place.map_digest,
        "stage": request.stage,
        "command": request.command(),
        "seed": request.seed,
        "metrics": metrics,
        **origin,
    }
