"""`twonav reproduce fig9`: looks from random poses, and shows where the camera's pose is wrong, and why."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from twonav_cli.checkpoint import versions
from twonav_cli.config import BASES, ROBOT_FOOTPRINT_M
from twonav_cli.dataset.poses import random_poses
from twonav_cli.events import Clock, Looked, Note, RunEnded, RunStarted
from twonav_cli.experiments.predecessors import load_localize
from twonav_cli.experiments.wrong_places import WRONG_M, LookedAround, look_around
from twonav_cli.files import write_whole
from twonav_cli.geometry import Pose
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.rng import stream
from twonav_cli.terminal.console import out, progress
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.map_source import tell_source
from twonav_cli.terminal.recordings import recording
from twonav_cli.worker_pool import StoppedError

FIGURE = "fig9"
LOOKS, QUICK_LOOKS = 4000, 200
"""Random poses from which the robot looks, and how many show that everything works (ours)."""

SHOWN = 6
"""Places that are shown with their pictures (ours)."""

SECONDS_PER_PLACE = 5.0
"""Time between two places in the recording, where it is only an order."""


@dataclass(frozen=True)
class Fig9Request:
    """What is asked of Fig. 9.

    Attributes:
        scene: Where.
        seed: Of the poses.
        network: A network of the paper's, or None for ours.
        quick: Whether few looks are enough.
        map_from: "survey" or "geometry"; None as `read_floor` chooses.
    """

    scene: str = "apartment"
    seed: int = 0
    network: str | None = None
    quick: bool = False
    map_from: str | None = None

    def command(self) -> str:
        """Return the command that makes the figure again."""
        parts = ["twonav", "reproduce", FIGURE, "--seed", str(self.seed), "--scene", self.scene]
        parts += [] if self.network is None else ["--networks", self.network]
        parts += ["--quick"] if self.quick else []
        return shlex.join(parts + ([] if self.map_from is None else ["--map-from", self.map_from]))


def run_fig9(request: Fig9Request, folder: Path, as_json: bool) -> int:
    """Make, print and write the figure; returns 0, or 130 when interrupted.

    Raises:
        TwonavError: There is no localizer, or no renderer.
    """
    floor = read_floor(request.scene, request.map_from)
    with StopOnInterrupt("stopping: nothing is kept") as stop:
        try:
            found = _looked(request, floor, stop)
        except StoppedError:
            return 130
    report = _report(request, floor, found)
    name = FIGURE + ("-quick" if request.quick else "")
    if not as_json:
        _print(report)
    _write(request, floor, found, report, folder, name)
    tell_source(floor, request.scene, request.map_from)
    if as_json:
        print(json.dumps(report, allow_nan=False))
    return 0


def _looked(request: Fig9Request, floor: Floor, should_stop: Callable[[], bool]) -> LookedAround:
    """Look from random poses."""
    from twonav_cli.scene.camera import Camera
    from twonav_cli.scene.world import World

    localize = load_localize(floor, network=request.network)
    rng, count = stream(request.seed, "fig9"), QUICK_LOOKS if request.quick else LOOKS
    poses = random_poses(~floor.map.free, floor.map.frame, list(floor.scene.starts.values()), count, rng)
    world = World(floor.scene, BASES[0])
    camera = Camera(world)

    def picture(pose: Pose) -> Any:
        world.place(pose)
        return camera.image()

    try:
        with progress() as bar:
            task = bar.add_task(f"{floor.scene.name}, looks", total=count, result="")

            def on_look() -> None:
                bar.update(task, advance=1)
                if should_stop():
                    raise StoppedError

            return look_around(floor, poses, picture, localize, SHOWN, on_look)
    finally:
        camera.close()


def _report(request: Fig9Request, floor: Floor, found: LookedAround) -> dict[str, Any]:
    errors_m = found.errors_m
    return {
        "figure": FIGURE,
        "title": "Fig. 9: places where the estimated pose is wrong",
        "looks": found.looks,
        "wrong": len(found.wrong),
        "wrong_above_m": WRONG_M,
        "median_m": float(np.median(errors_m)),
        "mean_m": float(np.mean(errors_m)),
        "places": [place.figures() for place in found.shown],
        "settings": {
            "scene": floor.scene.name,
            "map": floor.map_source,
            "network": request.network or "belief",
            "seed": request.seed,
            "quick": request.quick,
            "command": request.command(),
            "versions": versions(),
        },
    }


def _print(report: dict[str, Any]) -> None:
    console = out()
    console.print(f"\n[bold]{report['title']}[/bold] ({report['settings']['scene']}, {report['settings']['network']})")
    share = 100 * report["wrong"] / max(report["looks"], 1)
    said = f"{report['wrong']} of {report['looks']:,} looks are more than {report['wrong_above_m']} m off"
    console.print(f"{said} ({share:.1f} %); median {report['median_m']:.3f} m, mean {report['mean_m']:.3f} m")
    for number, place in enumerate(report["places"], start=1):
        console.print(f"{number}. {place['sentence']}", markup=False)
    console.print(report["settings"]["command"], markup=False, soft_wrap=True)


def _write(
    request: Fig9Request, floor: Floor, found: LookedAround, report: dict[str, Any], folder: Path, name: str
) -> None:
    """Write NAME.json, NAME.png and NAME.rrd, and print their paths."""
    from twonav_cli.plotting.pictures import picture_of_wrong_places

    text = json.dumps(report, indent=1, allow_nan=False) + "\n"
    print(write_whole(folder / f"{name}.json", text), file=sys.stderr)
    title = f"{report['title']} ({floor.scene.name}, {report['settings']['network']})"
    outline_m = np.array(ROBOT_FOOTPRINT_M)
    picture = picture_of_wrong_places(title, found, floor.map.occupied, floor.map.frame, outline_m)
    print(write_whole(folder / f"{name}.png", picture), file=sys.stderr)
    print(_recorded(request, floor, found, folder / f"{name}.rrd"), file=sys.stderr)


def _recorded(request: Fig9Request, floor: Floor, found: LookedAround, path: Path) -> Path:
    """Write the recording: place after place, what the robot saw and what it believed."""
    begun = RunStarted(
        Clock(), "reproduce fig9", "3d", floor.scene.name, request.seed, {"network": request.network or "belief"},
        floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame,
    )  # fmt: skip
    with recording(path, "3d", begun, every_trial=True) as recorder:
        for number, place in enumerate(found.shown):
            clock = Clock(number, number, number * SECONDS_PER_PLACE)
            recorder(Looked(clock, place.true, place.image, place.estimate, place.belief))
            recorder(Note(clock, "WARN", f"Place {number + 1}: {place.sentence}"))
        ended = Clock(len(found.shown), len(found.shown), len(found.shown) * SECONDS_PER_PLACE)
        recorder(RunEnded(ended, f"{len(found.wrong)} of {found.looks} looks are wrong"))
    return path
