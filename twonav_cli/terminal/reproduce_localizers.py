"""`twonav reproduce table3 | table4 | fig7`: trains the networks that are missing, measures all, prints and writes."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

from twonav_cli.experiments.localizer_tables.error_map import ErrorMapReport, error_map_report, heat_of
from twonav_cli.experiments.localizer_tables.report import LocalizerReport, table_report
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.files import write_whole
from twonav_cli.mapping.floor import read_floor
from twonav_cli.paths import runs_dir
from twonav_cli.terminal.interrupt import StopOnInterrupt
from twonav_cli.terminal.localizer_rows import SceneRows
from twonav_cli.terminal.map_source import tell_source
from twonav_cli.worker_pool import StoppedError

FIGURE = "fig7"


def run_localizers(request: LocalizerRequest, folder: Path, as_json: bool) -> int:
    """Make, print and write a table or figure about localizers.

    Args:
        request: What was asked, checked.
        folder: Where the results go.
        as_json: Print one JSON object instead.

    Returns:
        0, or 130 when interrupted: what is trained is kept, and a training that was broken off goes on.

    Raises:
        TwonavError: A network was trained otherwise, or frames cannot be taken.
    """
    with StopOnInterrupt("stopping: saving first") as stop:
        try:
            scenes = scene_rows(request, stop)
            report = _report_of(request, scenes)
        except StoppedError:
            again = " ".join([request.command(), *_where(folder)])
            print(f"stopped: nothing is written of {request.table}; what is trained is kept", file=sys.stderr)
            print(f"go on with: {again}", file=sys.stderr)
            return 130
    if not as_json:
        from twonav_cli.terminal.reproduced_localizers import print_errors, print_maps

        print_errors(report) if isinstance(report, LocalizerReport) else print_maps(report)
    _write(report, scenes[0], folder, "-quick" if request.quick else "")
    for rows in scenes:
        tell_source(rows.floor, rows.scene, request.map_from)
    if as_json:
        print(json.dumps(asdict(report), allow_nan=False))
    return 0


def scene_rows(request: LocalizerRequest, should_stop: Callable[[], bool]) -> list[SceneRows]:
    """Return every scene of a table with its networks: all trained unless only finished ones are wanted.

    Raises:
        StoppedError: Frames or a training were interrupted.
        TwonavError: A network was trained otherwise, which is said before anything is trained; or no frames can be
            taken.
    """
    found = [
        SceneRows(request, read_floor(scene, request.map_from, own_first=True), networks, should_stop)
        for scene, networks in request.rows().items()
    ]
    if request.only_finished:
        for rows in found:
            rows.find_frames()
        return found
    for rows in found:
        rows.check_begun()
    for rows in found:
        rows.take_frames()
        rows.train_missing()
    return found


def _where(folder: Path) -> list[str]:
    """Return the option that names the folder of the results, where it is not the usual one."""
    return [] if folder == runs_dir() / "reproduce" else ["--out", shlex.quote(str(folder))]


def _report_of(request: LocalizerRequest, scenes: list[SceneRows]) -> LocalizerReport | ErrorMapReport:
    if request.table == FIGURE:
        (rows,) = scenes
        maps = rows.maps()
        return error_map_report(request, rows.scene, maps, rows.missing, {rows.scene: rows.facts()})
    found = [row for rows in scenes for row in rows.rows()]
    return table_report(request, found, {rows.scene: rows.facts() for rows in scenes})


def _write(report: LocalizerReport | ErrorMapReport, rows: SceneRows, folder: Path, ending: str) -> None:
    """Write NAME.json and NAME.png, and the recording of a figure that has maps, and print their paths."""
    from twonav_cli.plotting.pictures import picture_of, picture_of_maps

    name, map_ = f"{report.table}{ending}", rows.floor.map
    text = json.dumps(asdict(report), indent=1, allow_nan=False) + "\n"
    print(write_whole(folder / f"{name}.json", text), file=sys.stderr)
    if isinstance(report, LocalizerReport):
        print(write_whole(folder / f"{name}.png", picture_of(report)), file=sys.stderr)
    elif report.maps:
        picture = picture_of_maps(report, map_.occupied, map_.frame)
        print(write_whole(folder / f"{name}.png", picture), file=sys.stderr)
        print(_recorded(report, rows, folder / f"{name}.rrd"), file=sys.stderr)


def _recorded(report: ErrorMapReport, rows: SceneRows, path: Path) -> Path:
    """Write the recording of the error maps."""
    from twonav_cli.recording.error_maps import ErrorPanel, record_error_maps

    panels = []
    for one in report.maps:
        paper_m = None if one.paper is None else (one.paper["min_m"], one.paper["max_m"])
        panels.append(ErrorPanel(one.network, *heat_of(one.cells), paper_m))
    map_, seed, command = rows.floor.map, rows.request.seed, report.settings["command"]
    return record_error_maps(path, report.scene, seed, command, panels, map_.occupied, map_.frame)
