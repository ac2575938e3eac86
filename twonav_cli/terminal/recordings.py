"""Where a run's recording goes, and opening it with everything that came before it."""

from __future__ import annotations

import datetime
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from twonav_cli.events import RunStarted, Sink, to_nobody
from twonav_cli.paths import runs_dir


def default_recording(command: str, scene: str, stage: str) -> Path:
    """Return a fresh path in the runs folder, named by what is recorded and when."""
    moment = datetime.datetime.now().strftime("%Y%m%d-%H%M%S")
    return runs_dir() / "recordings" / f"{command}-{Path(scene).stem}-{stage}-{moment}-{os.getpid()}.rrd"


@contextmanager
def recording(path: Path | None, stage: str, begun: RunStarted, every_trial: bool = False) -> Iterator[Sink]:
    """Open a recording and send it the start of the run; without a path nothing is recorded.

    Args:
        path: Where it goes, or None.
        stage: "maze", "2d", "3d" or "localizer".
        begun: The event that opens the run.
        every_trial: Keep every trial in full detail (playing), not only some (training).
    """
    if path is None:
        yield to_nobody
        return
    from twonav_cli.recording.recorder import Recorder

    with Recorder(path, stage, every_trial=every_trial) as recorder:
        recorder(begun)
        yield recorder
