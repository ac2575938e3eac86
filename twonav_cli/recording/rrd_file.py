"""One .rrd file that grows: rows are buffered, shipped as columns, and flushed.

Shipping columns costs 1 to 3 microseconds a row, logging row by row 25 to 100; after a flush a killed process
loses nothing.
"""

from __future__ import annotations

import uuid
from collections import defaultdict
from pathlib import Path
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock
from twonav_cli.recording.belief_columns import BELIEF_COLUMNS
from twonav_cli.recording.columns import COLUMNS
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.mapping_columns import MAPPING_COLUMNS

Row = tuple[Clock, Detail, Any]

TIMELINES = ("step", "trial", "sim_time")
"""On every row of a run: the action counter, the attempt at a goal, simulated seconds."""

FITTING_TIMELINES = ("batch", "epoch", "sim_time")
"""The same three numbers of the clock in a recording of a network's training."""

MAPPING_TIMELINES = ("keyframe", None, "time")
"""Of them in a recording of the mapper, which knows no trials: scans that went into the map, seconds of the log."""

Timelines = tuple[str, str | None, str]

_FILL = COLUMNS | BELIEF_COLUMNS | MAPPING_COLUMNS


def checked_path(path: Path) -> Path:
    """Return the path when a recording can be written there.

    Raises:
        TwonavError: Wrong suffix, a folder, or no permission.
    """
    if path.suffix != ".rrd":
        raise TwonavError(f"a recording's name must end in .rrd, not {path.name!r}")
    if path.is_dir():
        raise TwonavError(f"{path} is a folder: name a file in it, such as {path / 'run.rrd'}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb"):
            pass
    except OSError as error:
        raise TwonavError(f"cannot write the recording {path}: {error.strerror or error}") from error
    return path


class RrdFile:
    """Buffers rows by track (see `COLUMNS` in `columns`, `belief_columns` and `mapping_columns`) and ships them."""

    def __init__(self, path: Path, application_id: str, timelines: Timelines = TIMELINES) -> None:
        """Open the file.

        Raises:
            TwonavError: It cannot be written.
        """
        self.path = checked_path(path)
        self._timelines = timelines
        # A fresh id: two files with one id are one recording to the viewer.
        self._stream = rr.RecordingStream(application_id, recording_id=f"{application_id}-{uuid.uuid4().hex[:12]}")
        try:
            self._stream.save(path)
        except RuntimeError as error:
            raise TwonavError(f"cannot write the recording {path}: {str(error).splitlines()[0]}") from error
        self._stream.set_log_time_enabled(False)
        self._rows: dict[str, list[Row]] = defaultdict(list)

    @property
    def size_bytes(self) -> int:
        """Size of the file on disk."""
        return self.path.stat().st_size

    def describe(self, name: str, properties: dict[str, Any]) -> None:
        """Write the recording's name and the properties of the run."""
        self._stream.send_recording_name(name)
        self._stream.send_property("run", rr.AnyValues(**properties))

    def show(self, blueprint: rrb.Blueprint) -> None:
        """Write how the viewer lays the recording out; the last one written wins."""
        self._stream.send_blueprint(blueprint, make_active=True, make_default=True)

    def always(self, entity: str, *what: Any) -> None:
        """Write what never changes."""
        self._stream.log(entity, *what, static=True)

    def put(self, track: str, value: Any, clock: Clock, detail: Detail = Detail.FULL) -> None:
        """Buffer one row of a track."""
        self._rows[track].append((clock, detail, value))

    def buffered(self, track: str) -> int:
        """Number of rows waiting in a track."""
        return len(self._rows[track])

    def ship(self, level: Detail) -> None:
        """Write the buffered rows up to a level, forget the others, and flush."""
        for track, rows in self._rows.items():
            if kept := [row for row in rows if row[1] <= level]:
                self._write(track, kept)
        self._rows.clear()
        self._stream.flush()

    def ship_first(self, tracks: tuple[str, ...]) -> None:
        """Write the buffered rows of some tracks, of every level and without flushing, before what is sent next."""
        for track in tracks:
            if rows := self._rows.pop(track, []):
                self._write(track, rows)

    def _write(self, track: str, rows: list[Row]) -> None:
        times = self.time_columns([clock for clock, _, _ in rows])
        for entity, columns in _FILL[track]([value for _, _, value in rows]):
            self._stream.send_columns(entity, times, columns)

    def send(self, entity: str, clocks: list[Clock], columns: Any) -> None:
        """Write ready columns at once."""
        self._stream.send_columns(entity, self.time_columns(clocks), columns)

    def now(self, entity: str, what: Any, clock: Clock) -> None:
        """Write one row at once; dear, so only for what comes once per trial."""
        first, second, third = self._timelines
        self._stream.set_time(first, sequence=clock.step)
        if second is not None:
            self._stream.set_time(second, sequence=clock.trial)
        self._stream.set_time(third, duration=clock.time_s)
        self._stream.log(entity, what)

    def time_columns(self, clocks: list[Clock]) -> list[rr.TimeColumn]:
        """Return the timelines [n] of some rows."""
        first, second, third = self._timelines
        columns = [rr.TimeColumn(first, sequence=np.array([clock.step for clock in clocks], dtype=np.int64))]
        if second is not None:
            trials = np.array([clock.trial for clock in clocks], dtype=np.int64)
            columns.append(rr.TimeColumn(second, sequence=trials))
        times_s = np.array([clock.time_s for clock in clocks], dtype=np.float64)
        return [*columns, rr.TimeColumn(third, duration=times_s)]

    def close(self) -> None:
        """Flush and write the footer."""
        self._stream.flush()
        self._stream.disconnect()
