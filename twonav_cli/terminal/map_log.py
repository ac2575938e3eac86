"""`twonav map LOG`: a real robot's log becomes a map, a trajectory and a recording."""

from __future__ import annotations

import contextlib
import datetime
import json
import shlex
import sys
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import CARD_FILE, FORMAT, signed, versions
from twonav_cli.config import MappingConfig
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Event, KeyframeMapped, Note, RunEnded, RunStarted, to_all
from twonav_cli.files import digest_of_files, writable, write_whole
from twonav_cli.geometry import Pose
from twonav_cli.mapping.carmen import LaserLog, read_carmen
from twonav_cli.mapping.known_maps import MAP_FILE, card_in, holds_another
from twonav_cli.mapping.mapper import GridMapper
from twonav_cli.mapping.occupancy import OccupancyMap, save_map
from twonav_cli.mapping.scan import usable
from twonav_cli.mapping.trajectory import write_trajectory
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.console import err, out, progress
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.map_options import MapChoices, checked_forward
from twonav_cli.terminal.recordings import default_recording, recording

TRAJECTORY_FILE = "trajectory.txt"
KIND = "map"
SHOW_EVERY_S = 5.0
"""Between two lines about the progress where no bar can be drawn."""
WHOLE, STOPPED = "mapped", "stopped"


@dataclass(frozen=True)
class MapRequest:
    """Everything the command line says about mapping a log."""

    log: Path
    choices: MapChoices = field(default_factory=MapChoices)
    laser_forward_m: float | None = None
    seed: int = 0
    out: Path | None = None
    record: Path | None = None
    recording: bool = True
    as_json: bool = False

    @property
    def name(self) -> str:
        """The log's name without its folder and endings."""
        return self.log.name.removesuffix(".gz").rsplit(".", 1)[0] or self.log.name

    @property
    def folder(self) -> Path:
        """Where map, trajectory and card go."""
        return self.out or runs_dir() / "maps" / self.name

    def command(self) -> str:
        """Return the command that repeats this run."""
        parts = ["twonav", "map", str(self.log), *self.choices.arguments()]
        parts += [] if self.laser_forward_m is None else ["--laser-forward", str(self.laser_forward_m)]
        return shlex.join([*parts, "--seed", str(self.seed)])


class Tally:
    """A sink that counts what the mapper says of its keyframes."""

    def __init__(self) -> None:
        self.keyframes = self.resampled = self.unmatched = 0
        self.last = Clock()

    def __call__(self, event: Event) -> None:
        """Count a keyframe."""
        if isinstance(event, KeyframeMapped):
            self.last = event.clock
            self.keyframes += 1
            self.resampled += event.resampled
            self.unmatched += event.unmatched == len(event.weights)


def run_map(request: MapRequest) -> int:
    """Map a log; returns 0 when all of it was mapped, 130 when it was interrupted and what there is was saved.

    Raises:
        TwonavError: The log cannot be used, a setting is out of its range, or the folder cannot be written.
    """
    config = request.choices.config()
    begun_s = time.monotonic()
    forward_m = checked_forward(request.laser_forward_m)
    log = read_carmen(request.log, None if forward_m is None else Pose(forward_m, 0.0, 0.0))
    _check_range(request, config, log)
    folder = _checked_folder(request)
    path = (request.record or default_recording("map", request.name, "log")) if request.recording else None
    tally = Tally()
    begun = RunStarted(Clock(), "map", "map", request.name, request.seed, _settings(config, log))
    with StopOnInterrupt("stopping: saving the map so far") as stop, recording(path, "map", begun) as recorder:
        for warning in log.warnings:
            recorder(Note(Clock(), "WARN", warning))
        mapper = GridMapper(config, log.sensor, request.seed, sink=to_all(recorder, tally))
        scans = _mapped(mapper, log, stop)
        mapper.draw()
        outcome = WHOLE if scans == len(log.readings) else STOPPED
        recorder(RunEnded(tally.last, outcome))
        report = _report(log, tally, scans) | {"outcome": outcome}
        files = _save(request, mapper, _kept_apart(folder, outcome), report)
    report |= {"seconds": round(time.monotonic() - begun_s, 1)}
    report |= {"files": [str(file) for file in files], "recording": None if path is None else str(path)}
    _print(request, report)
    return 0 if outcome == WHOLE else 130


def _check_range(request: MapRequest, config: MappingConfig, log: LaserLog) -> None:
    """Refuse a log in which no beam hits anything, for the laser's own limit or for the one that was chosen."""
    own_m, chosen_m = log.sensor.max_m, config.max_range_m
    nothing = f"no beam of {request.log} hits anything"
    if not any(usable(reading.ranges_m, own_m).any() for reading in log.readings):
        where = f"nearer than {own_m:g} m, where the laser ends"
        raise TwonavError(f"{nothing} {where}: name another log, with ranges in metres")
    if not any(usable(reading.ranges_m, min(own_m, chosen_m)).any() for reading in log.readings):
        raise TwonavError(f"{nothing} within {chosen_m:g} m: name another log, or a larger --max-range")


def _checked_folder(request: MapRequest) -> Path:
    """Return the folder once it is sure that it can be written, and holds no other result than this log's map.

    Raises:
        TwonavError: It cannot, or it does.
    """
    folder, card = request.folder, card_in(request.folder)
    if holds_another(folder, "log", request.out is not None):
        raise TwonavError(f"{folder} holds something else than the map of a log: name another --out")
    if request.out is None and card and card.get("log_digest") != digest_of_files([request.log]):
        raise TwonavError(f"{folder} holds the map of another log of that name: name another --out")
    return writable(folder)


def _kept_apart(folder: Path, outcome: str) -> Path:
    """Return where to save: beside a map of the whole log what was stopped does not replace it."""
    whole = card_in(folder).get("metrics", {}).get("outcome") == WHOLE
    return folder.with_name(f"{folder.name}-{STOPPED}") if outcome == STOPPED and whole else folder


def _settings(config: MappingConfig, log: LaserLog) -> dict[str, str]:
    """Return what the recording says that the map was made with."""
    sensor = log.sensor
    return {
        **{name.replace("_", " "): str(value) for name, value in asdict(config).items()},
        "beams": str(len(sensor.angles_rad)),
        "nothing is hit from (m)": f"{sensor.max_m:g}",
        "laser sits at": f"{sensor.mount.x_m:.3f} m forward, {sensor.mount.y_m:.3f} m left",
    }


def _mapped(mapper: GridMapper, log: LaserLog, should_stop: Callable[[], bool]) -> int:
    """Put the scans into the map with a progress bar, or lines where no bar can be drawn; return how many."""
    total, shown_s = len(log.readings), time.monotonic()
    with progress() as bar:
        task = bar.add_task("scans", total=total, result="")
        for count, reading in enumerate(log.readings, start=1):
            if mapper.add(reading):
                bar.update(task, completed=count, result=f"{mapper.keyframes} keyframes")
            if not bar.console.is_terminal and time.monotonic() - shown_s > SHOW_EVERY_S:
                shown_s = time.monotonic()
                bar.console.print(f"{count} of {total} scans, {mapper.keyframes} of them keyframes", soft_wrap=True)
            if should_stop():
                return count
        bar.update(task, completed=total)
    return total


def _report(log: LaserLog, tally: Tally, scans: int) -> dict[str, Any]:
    """Return the figures of the run for its card and for scripts."""
    mapped, warnings = log.first(scans), list(log.warnings)
    if tally.keyframes == 1:
        why = "there is one scan only" if scans == 1 else "the robot never moved"
        warnings.append(f"{why}: the map is that of the first scan")
    if tally.unmatched:
        warnings.append(f"no particle's scan fitted at {tally.unmatched} keyframes: odometry was kept there")
    return {
        "scans": scans,
        "scans_of_log": len(log.readings),
        "beams": len(log.sensor.angles_rad),
        "duration_s": round(mapped.duration_s, 3),
        "driven_m": round(mapped.driven_m, 3),
        "left_out": log.left_out,
        "keyframes": tally.keyframes,
        "particles_drawn_again": tally.resampled,
        "keyframes_without_match": tally.unmatched,
        "warnings": warnings,
    }


def _save(request: MapRequest, mapper: GridMapper, folder: Path, report: dict[str, Any]) -> list[Path]:
    """Write map, trajectory and card, the card last, and add the map's size to the report."""
    occupancy = mapper.occupancy()
    report["map"] = _size(occupancy)
    # Without these, what is written next is no map of anything until the new ones are there.
    for name in (CARD_FILE, MAP_FILE):
        with contextlib.suppress(OSError):
            (folder / name).unlink()
    map_path = save_map(occupancy, folder / MAP_FILE)
    trajectory_path = write_trajectory(folder / TRAJECTORY_FILE, mapper.trajectory())
    card = {
        "kind": KIND,
        "log": request.log.name,
        "log_digest": digest_of_files([request.log]),
        "map_digest": occupancy.digest,
        "command": request.command(),
        "seed": request.seed,
        "settings": asdict(mapper.config),
        "metrics": report,
        "format": FORMAT,
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "versions": versions(),
    }
    card_path = write_whole(folder / CARD_FILE, json.dumps(signed(card), indent=2) + "\n")
    return [map_path, map_path.with_suffix(".pgm"), trajectory_path, card_path]


def _size(occupancy: OccupancyMap) -> dict[str, float]:
    frame = occupancy.frame
    width_m, height_m = frame.cols * frame.resolution_m, frame.rows * frame.resolution_m
    return {
        "cols": frame.cols,
        "rows": frame.rows,
        "resolution_m": frame.resolution_m,
        "width_m": round(width_m, 3),
        "height_m": round(height_m, 3),
    }


def _print(request: MapRequest, report: dict[str, Any]) -> None:
    """Print one object, or a line for everything that was done."""
    if request.as_json:
        print(json.dumps({"log": request.name, "seed": request.seed, **report}))
    else:
        for line in report_lines(report):
            out().print(line, soft_wrap=True, markup=False)
    for warning in report["warnings"]:
        err().print(f"warning: {warning}", soft_wrap=True, markup=False)
    if report["outcome"] == STOPPED:
        print(f"stopped after {report['scans']} of {report['scans_of_log']} scans", file=sys.stderr)


def report_lines(report: dict[str, Any]) -> list[str]:
    """Return what was done, line by line."""
    size, left_out = report["map"], report["left_out"]
    lines = [
        f"scans: {report['scans']} of {report['beams']} beams, {report['duration_s']:.0f} s, "
        f"{report['driven_m']:.0f} m by odometry",
        f"left out: {', '.join(f'{what} {count}' for what, count in left_out.items()) or 'nothing'}",
        f"keyframes: {report['keyframes']}, without a match {report['keyframes_without_match']}; "
        f"particles drawn again {report['particles_drawn_again']} times",
        f"map: {size['width_m']:.1f} x {size['height_m']:.1f} m, {size['cols']} x {size['rows']} pixels of "
        f"{size['resolution_m']:g} m",
        f"seconds: {report['seconds']}",
        *(f"wrote {file}" for file in report["files"]),
    ]
    seen = (
        [f"recording: {report['recording']}", f"look at it: rerun {report['recording']}"] if report["recording"] else []
    )
    return [*lines, *seen, f"show it here: twonav scenes show {report['files'][0]} --map"]
