"""`twonav train`: one stage at a time, interruptible, resumable, recorded."""

from __future__ import annotations

import json
import shlex
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.play import BASES

if TYPE_CHECKING:
    from twonav_cli.mapping.floor import Floor

STAGES = ("maze", "localizer", "3d")


@dataclass(frozen=True)
class TrainRequest:
    """Everything the command line says about a training run."""

    stage: str
    scene: str = "apartment"
    seed: int = 0
    resume: bool = False
    out: Path | None = None
    record: Path | None = None
    recording: bool = True
    quick: bool = False
    images: int | None = None
    base: str = "omni"
    as_json: bool = False

    def command(self) -> str:
        """Return the command that repeats this run."""
        parts = ["twonav train", "--stage", self.stage, "--scene", self.scene, "--seed", str(self.seed)]
        if self.images is not None:
            parts += ["--images", str(self.images)]
        if self.stage == "3d":
            parts += ["--base", self.base]
        return shlex.join(parts + (["--quick"] if self.quick else []))

    def resume_command(self) -> str:
        """Return the command that goes on with this run where it stopped."""
        parts = [self.command(), "--resume"]
        parts += ["--out", shlex.quote(str(self.out))] if self.out is not None else []
        return " ".join(parts + ([] if self.recording else ["--no-record"]))


def run_train(request: TrainRequest) -> int:
    """Train a stage; returns 0 when it finished, 130 when it was interrupted and saved, 1 when it did not learn."""
    if request.stage == "2d":
        raise TwonavError("the 2D simulator is not there yet: train --stage maze, localizer or 3d")
    if request.stage not in STAGES:
        raise unknown_name("stage", request.stage, STAGES)
    if request.base not in BASES:
        raise unknown_name("base", request.base, BASES)
    from twonav_cli.mapping.floor import read_floor

    floor = read_floor(request.scene)
    name = f"{request.stage}-quick" if request.quick else request.stage
    folder = request.out or runs_dir() / floor.scene.name / name
    with StopOnInterrupt() as stop:
        if request.stage == "localizer":
            from twonav_cli.terminal.train_localizer import train_localizer

            outcome, metrics = train_localizer(request, floor, folder, stop)
        else:
            from twonav_cli.terminal.train_agent import train_agent

            outcome, metrics = train_agent(request, floor, folder, stop)
    _report(request, folder, outcome, metrics)
    return {"learned": 0, "quick": 0, "stopped": 130}.get(outcome, 1)


def _report(request: TrainRequest, folder: Path, outcome: str, metrics: dict[str, Any]) -> None:
    if request.as_json:
        print(json.dumps({"stage": request.stage, "scene": request.scene, "outcome": outcome, **metrics}))
    else:
        for name, value in metrics.items():
            print(f"{name}: {value}", file=sys.stderr)
    if outcome == "stopped":
        print(f"stopped and saved in {folder}; go on with: {request.resume_command()}", file=sys.stderr)
    elif outcome == "gave-up":
        print(f"gave up before every goal was learned; what was learned is in {folder}", file=sys.stderr)
    elif outcome == "quick":
        print(f"a quick run ends here, before anything is learned well: {folder}", file=sys.stderr)
    else:
        print(f"done: {folder}", file=sys.stderr)


def card_of(request: TrainRequest, floor: Floor, metrics: dict[str, Any]) -> dict[str, Any]:
    """Return what every checkpoint's card says about its origin."""
    return {
        "scene": floor.scene.name,
        "scene_digest": floor.scene.digest,
        "map_digest": floor.map.digest,
        "stage": request.stage,
        "command": request.command(),
        "seed": request.seed,
        "metrics": metrics,
    }
