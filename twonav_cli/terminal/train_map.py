"""`twonav train --stage map`: the robot surveys a scene by itself, and its map is measured against the simulator."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from twonav_cli.events import Clock, Event, KeyframeMapped, MapDrawn, Note, RunEnded, RunStarted, to_all
from twonav_cli.experiments.map_errors import (
    connected_floor,
    map_agreement,
    maze_differences,
    paired,
    pose_errors,
)
from twonav_cli.geometry import Pose
from twonav_cli.mapping.floor import geometry_map
from twonav_cli.mapping.known_maps import SURVEY, save_known_map
from twonav_cli.mapping.occupancy import FREE, OccupancyMap
from twonav_cli.mapping.survey import STOPPED, TIMED_OUT, Survey, Surveyed
from twonav_cli.mapping.survey_config import QUICK, SURVEY_MAPPING, SurveyConfig
from twonav_cli.scene.catalog import Scene
from twonav_cli.terminal.console import progress
from twonav_cli.terminal.recordings import default_recording, recording
from twonav_cli.terminal.train import USUAL_BASE, TrainRequest

if TYPE_CHECKING:
    from rich.progress import Progress

SURVEYED = "surveyed"
QUICK_PARTICLES = 10
LINE_EVERY_KEYFRAMES = 100
"""How often progress is printed where no bar can be drawn."""

CELLS_NAMED = 20
"""Of the cells of the maze that differ from the geometry's, the first so many are named on the card."""

DIGITS = 5
"""Of the figures on the card."""


def train_map(
    request: TrainRequest, scene: Scene, folder: Path, should_stop: Callable[[], bool]
) -> tuple[str, dict[str, Any]]:
    """Survey a scene and write the map, the way (`timestamp x y theta`) and a card; nothing when interrupted.

    Returns:
        The outcome ("surveyed", "timed-out", "quick" or "stopped") and the metrics of the card.

    Raises:
        TwonavError: The scene cannot be simulated, its first start is not on its floor, or the folder cannot be
            written.
    """
    geometry, start = geometry_map(scene), next(iter(scene.starts.values()))
    connected_floor(geometry, start)  # what cannot be measured is refused before a minute is spent on it
    path = (request.record or default_recording("train", scene.name, "map")) if request.recording else None
    config = QUICK if request.quick else SurveyConfig()
    mapping = replace(SURVEY_MAPPING, particles=QUICK_PARTICLES) if request.quick else SURVEY_MAPPING
    settings = {"base": request.base or USUAL_BASE, **asdict(config), **asdict(mapping)}
    told = {name.replace("_", " "): str(value) for name, value in settings.items()}
    begun = RunStarted(Clock(), "train", "map", scene.name, request.seed, told)
    with recording(path, "map", begun) as recorder, progress() as bar:
        sink = to_all(recorder, _ProgressSink(bar))
        survey = Survey(scene, config, mapping, request.base or USUAL_BASE, request.seed, sink)
        found = survey.run(should_stop)
        recorder(RunEnded(Clock(step=len(found.trajectory), time_s=found.time_s), found.outcome))
    if path is not None:
        print(f"recording: {path}", file=sys.stderr)
    if found.outcome == STOPPED:
        return STOPPED, {}
    metrics = metrics_of(found, geometry, start)
    card = {
        "source": SURVEY, "command": request.command(), "seed": request.seed, "metrics": metrics, "settings": settings,
    }  # fmt: skip
    save_known_map(scene, found.map, folder, card, found.walls, found.trajectory)
    return "quick" if request.quick else TIMED_OUT if found.outcome == TIMED_OUT else SURVEYED, metrics


def metrics_of(found: Surveyed, geometry: OccupancyMap, start: Pose) -> dict[str, Any]:
    """Return the figures of a survey, beside the simulator's truth where there is one."""
    cells = maze_differences(found.map, geometry, start)
    figures = {
        "keyframes": len(found.trajectory),
        "simulated_s": found.time_s,
        "driven_m": found.driven_m,
        "collisions": found.collisions,
        **pose_errors(*paired(found.trajectory, found.truth)),
        **map_agreement(found.map, geometry, start),
        **{f"maze_cells_{name}": len(named) for name, named in cells.items()},
        **{f"maze_{name}": named[:CELLS_NAMED] for name, named in cells.items()},
    }
    return {name: round(value, DIGITS) if isinstance(value, float) else value for name, value in figures.items()}


class _ProgressSink:
    """Shows keyframes, floor and simulated time as they come; how much is still to do nobody knows."""

    def __init__(self, bar: Progress) -> None:
        self._bar = bar
        self._task = bar.add_task("survey", total=None, result="")
        self._floor_m2, self._phase = 0.0, ""

    def __call__(self, event: Event) -> None:
        if isinstance(event, MapDrawn):
            self._floor_m2 = float((event.pixels == FREE).sum()) * event.frame.resolution_m**2
        elif isinstance(event, Note):
            self._phase = f", {event.text.split(':')[0]}"
        elif isinstance(event, KeyframeMapped):
            count = event.clock.step
            said = f"{self._floor_m2:.0f} m2 of floor, {event.clock.time_s:.0f} s simulated{self._phase}"
            self._bar.update(self._task, completed=count, result=said)
            if not self._bar.console.is_terminal and count % LINE_EVERY_KEYFRAMES == 0:
                self._bar.console.print(f"keyframe {count}: {said}", soft_wrap=True)
