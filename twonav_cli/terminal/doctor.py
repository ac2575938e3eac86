"""`twonav doctor`: what works on this machine, and what to do about the rest."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import CARD_FILE, load_checkpoint, versions
from twonav_cli.errors import TwonavError
from twonav_cli.mapping.floor import survey_command
from twonav_cli.paths import checkpoints_dir, runs_dir
from twonav_cli.terminal.console import out

"""What `twonav play` plays in unless told otherwise."""


def run_doctor(as_json: bool, warm_up: bool = False) -> int:
    """Report renderer, versions, device, scenes and checkpoints.

    Args:
        as_json: Print one JSON object instead of lines.
        warm_up: Drive a few actions too, so that everything compiled is on disk before the first play.

    Returns:
        0 when everything that play needs works, else 1.
    """
    report: dict[str, Any] = {"versions": versions(), "device": _device(), "runs": str(runs_dir())}
    report["renderer"] = _renderer()
    report["scenes"] = _scenes()
    report["checkpoints"] = _checkpoints()
    if warm_up:
        report["warm_up"] = _warm_up()
    healthy = not any(str(value).startswith("error") for value in _flat(report))
    if as_json:
        print(json.dumps(report | {"healthy": healthy}))
    else:
        _print(report)
    return 0 if healthy else 1


def _renderer() -> str:
    from twonav_cli.scene.camera import Camera, choose_renderer
    from twonav_cli.scene.catalog import read_scene
    from twonav_cli.scene.world import World

    try:
        choose_renderer()
        camera = Camera(World(read_scene("kitchen")))
        shown = int(camera.image().max()) > 0
        camera.close()
    except TwonavError as error:
        return f"error: {error}"
    name = os.environ.get("MUJOCO_GL", "window system")
    return f"{name}, draws" if shown else f"error: {name} draws black pictures"


def _device() -> str:
    import torch

    if torch.cuda.is_available():
        return f"cuda ({torch.cuda.get_device_name(0)}), {torch.get_num_threads()} CPU threads"
    return f"cpu, {torch.get_num_threads()} threads"


def _scenes() -> dict[str, str]:
    from twonav_cli.scene.catalog import read_scene, scene_names

    found: dict[str, str] = {}
    for name in scene_names():
        try:
            scene = read_scene(name)
            found[name] = f"{len(scene.goals)} goals, {len(scene.starts)} starts"
        except TwonavError as error:
            found[name] = f"error: {error}"
    return found


def _checkpoints() -> dict[str, str]:
    from twonav_cli.scene.catalog import read_scene, scene_names

    found: dict[str, str] = {
        f"{name}/{kind}": "error: missing, restore it" for name in scene_names() for kind in ("localizer", "maze")
    }
    for card in sorted(checkpoints_dir().glob(f"*/*/{CARD_FILE}")):
        folder = card.parent
        name = f"{folder.parent.name}/{folder.name}"
        if folder.name == "map":
            found[name] = _map_said(folder)
            continue
        kind = "localizer" if folder.name.startswith("localizer") else "agent"
        try:
            _, read = load_checkpoint(folder, kind, read_scene(folder.parent.name).digest)
            found[name] = f"{kind}, {read.get('date', 'undated')}"
        except TwonavError as error:
            found[name] = f"error: {error}"
    return found


def _map_said(folder: Path) -> str:
    """Return who made a shipped map, or what is wrong with it."""
    from twonav_cli.mapping.known_maps import find_map
    from twonav_cli.scene.catalog import read_scene

    try:
        scene = read_scene(folder.parent.name)
        known = find_map(scene, None, chosen=folder.parent)
    except TwonavError as error:
        return f"error: {error}"
    if known is None or known.folder != folder:
        return f"error: damaged, or of another version of the scene: restore it or type `{survey_command(scene.name)}`"
    return "map, made by the robot" if known.source == "survey" else "map, from the scene's geometry"


def _warm_up() -> str:
    from twonav_cli.learner.relabel import compile_now
    from twonav_cli.terminal.play import PlayRequest, run_play

    compile_now()
    request = PlayRequest(goals=("kitchen",), recording=False, plain=True, quiet=True)
    try:
        return "done, the goal was reached" if run_play(request) == 0 else "done, the goal was not reached"
    except TwonavError as error:
        return f"error: {error}"


def _flat(value: Any) -> list[Any]:
    if isinstance(value, dict):
        return [leaf for part in value.values() for leaf in _flat(part)]
    return [value]


def _print(report: dict[str, Any]) -> None:
    console = out()
    for heading, value in report.items():
        if isinstance(value, dict):
            console.print(f"{heading}:" if value else f"{heading}: none")
            for name, text in value.items():
                console.print(f"  {name}: {text}", soft_wrap=True, highlight=False)
        else:
            console.print(f"{heading}: {value}", soft_wrap=True, highlight=False)
