"""`twonav train --stage all`: everything that a scene is missing, from its map to the agent in 3D."""

from __future__ import annotations

import json
import sys
import time
from dataclasses import replace

from twonav_cli.checkpoint import CARD_FILE, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.train import TrainRequest, run_train

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
    for stage in ORDER:
        own = _request_of(request, stage)
        state = _state_of(own, scene.name, scene.digest)
        if state == "done":
            print(f"{stage}: there already", file=sys.stderr)
            continue
        print(f"{stage}:", file=sys.stderr)
        begun_s = time.monotonic()
        code = run_train(replace(own, resume=state == "begun" and stage != "map"))
        if code != 0:
            print(f"stopped at stage {stage}; go on with: {request.command()}", file=sys.stderr)
            return code
        took_s[stage] = round(time.monotonic() - begun_s, 1)
    if request.as_json:
        print(json.dumps({"stage": "all", "scene": scene.name, "seconds": took_s}))
    else:
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


def _state_of(request: TrainRequest, scene: str, digest: str) -> str:
    """Return "done", "begun" or "missing": whether the user's own run of a stage is there, for this scene's version."""
    folder = runs_dir() / scene / (request.stage + ("-quick" if request.quick else ""))
    if not (folder / CARD_FILE).is_file():
        begun = request.stage == "localizer" and folder.is_dir() and any(folder.iterdir())
        return "begun" if begun else "missing"
    try:
        card = read_card(folder)
    except TwonavError:
        return "missing"
    if card.get("scene_digest") != digest:
        return "missing"
    metrics = card.get("metrics", {})
    unfinished = metrics.get("unfinished") or metrics.get("goals_learned", 0) < metrics.get("goals", 0)
    return "begun" if unfinished and not request.quick else "done"
