"""`twonav train --stage all`: everything that a scene is missing, from its map to the agent in 3D."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace
from typing import TYPE_CHECKING

from twonav_cli.checkpoint import CARD_FILE, Card, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.mapping.floor import read_floor
from twonav_cli.mapping.known_maps import GEOMETRY
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.train import TrainRequest, run_train

if TYPE_CHECKING:
    from pathlib import Path

    from twonav_cli.scene.catalog import Scene

ORDER = ("map", "maze", "2d", "localizer", "3d")
"""Stages one after the other; the localizer takes the frames that are missing."""


def run_all(request: TrainRequest) -> int:
    """Train what is missing among the user's own runs; a run that was left in the middle goes on.

    Returns:
        0, or the first exit code of a stage that is not: 130 when it was interrupted, 1 when it did not learn.
    """
    from twonav_cli.scene.catalog import read_scene

    scene = read_scene(request.scene_name)
    took_s: dict[str, float] = {}
    for stage in ORDER if request.map_from != GEOMETRY else ORDER[1:]:
        own = _request_of(request, stage)
        state, command = _state_of(own, scene)
        if state == "done":
            print(f"{stage}: there already ({command})", file=sys.stderr)
            continue
        print(f"{stage}:", file=sys.stderr)
        begun_s = time.monotonic()
        code = run_train(replace(own, resume=state == "begun" and stage != "map"))
        if code != 0:
            print(f"stopped at stage {stage}; go on with: {request.command()}", file=sys.stderr)
            _print_json(request, scene.name, took_s, stage)
            return code
        took_s[stage] = round(time.monotonic() - begun_s, 1)
    _print_json(request, scene.name, took_s, None)
    if not request.as_json:
        minutes = ", ".join(f"{stage} {seconds / 60:.1f}" for stage, seconds in took_s.items()) or "nothing to do"
        print(f"minutes: {minutes}; together {sum(took_s.values()) / 60:.1f}", file=sys.stderr)
    return 0


def _request_of(request: TrainRequest, stage: str) -> TrainRequest:
    """Return what is asked of one stage; options that are not its own are left out, its figures are not printed."""
    of_localizer = stage == "localizer"
    return replace(
        request,
        stage=stage,
        as_json=False,
        images=request.images if of_localizer else None,
        device=request.device if of_localizer else None,
        base=request.base if stage in ("map", "2d", "3d") else None,
        map_from=None if stage == "map" else request.map_from,
    )


def _print_json(request: TrainRequest, scene: str, took_s: dict[str, float], stopped_at: str | None) -> None:
    """Print the one object for scripts, if it is wanted."""
    if request.as_json:
        print(json.dumps({"stage": "all", "scene": scene, "seconds": took_s, "stopped_at": stopped_at}))


def _state_of(request: TrainRequest, scene: Scene) -> tuple[str, str]:
    """Return "done", "begun" or "missing" of the user's own run of a stage, and the command that made it.

    A run of another version of the scene, or of another map than the stage would use now, counts as missing.
    """
    folder = runs_dir() / scene.name / request.stage
    if request.stage == "localizer" and _training_is_begun(folder):
        return "begun", ""
    if not (folder / CARD_FILE).is_file():
        return "missing", ""
    try:
        card = read_card(folder)
    except TwonavError:
        return "missing", ""
    if card.get("scene_digest") != scene.digest or not _on_this_map(request, card):
        return "missing", ""
    return "begun" if _is_unfinished(request.stage, card) else "done", str(card.get("command", ""))


def _training_is_begun(folder: Path) -> bool:
    """Whether a network is half trained in a folder."""
    from twonav_cli.localizer.training_state import STATE_FILE

    return (folder / STATE_FILE).exists()


def _is_unfinished(stage: str, card: Card) -> bool:
    """Whether a run left a card but is not at its end: goals are left to learn, or a network was not measured."""
    metrics = card.get("metrics", {})
    if stage == "localizer":
        from twonav_cli.terminal.train_localizer import MEASURED

        return MEASURED not in metrics
    return bool(metrics.get("unfinished") or metrics.get("goals_learned", 0) < metrics.get("goals", 0))


def _on_this_map(request: TrainRequest, card: Card) -> bool:
    if request.stage == "map":
        return True
    return bool(card.get("map_digest") == read_floor(request.scene_name, request.map_from, own_first=True).map.digest)
