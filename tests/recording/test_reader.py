"""Recordings are summarized, whole or not; other files are refused in one line."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from twonav_cli import events
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock
from twonav_cli.recording import rehearsal
from twonav_cli.recording.reader import how_to_seek, summarize
from twonav_cli.recording.recorder import Recorder


def record(path: Path, trials: int) -> Path:
    with Recorder(path, "3d") as recorder:
        for event in rehearsal.driven_run(trials):
            recorder(event)
    return path


def test_a_summary_holds_the_run_and_its_trials(tmp_path: Path) -> None:
    summary = summarize(record(tmp_path / "run.rrd", 3))
    assert (summary.kind, summary.scene, summary.command, summary.seed) == ("3d", "apartment", "play", 0)
    assert summary.settings["localizer"] == "inception-9"
    assert summary.counts == {"reached": 2, "false-arrival": 1}
    assert summary.goal_counts["desk"] == (0, 1)
    assert (summary.ending, summary.whole) == ("all trials done", True)
    failure = summary.failures[0]
    assert (failure.number, failure.cause, failure.steps) == (3, "mislocalized", 6)
    assert how_to_seek(failure, "3d") == "timeline sim_time, +68.4 s to +75.6 s"


def test_the_metrics_of_a_training_are_the_last_ones(tmp_path: Path) -> None:
    path = tmp_path / "fit.rrd"
    with Recorder(path, "localizer") as recorder:
        recorder(events.RunStarted(Clock(), "train", "localizer", "apartment", 1))
        for batch in (10, 20):
            recorder(events.FittingStep(Clock(0, batch), 1.0 / batch, 1e-3, 100.0))
            recorder(events.FittingValidated(Clock(0, batch), {"median_error_m": 2.0 / batch, "share": 0.5}))
    assert summarize(path).metrics == {"median_error_m": 0.1, "share": 0.5}


KILLED = """
import os, sys
from pathlib import Path
from twonav_cli.recording import rehearsal
from twonav_cli.recording.recorder import Recorder
recorder = Recorder(Path(sys.argv[1]), "3d")
for event in rehearsal.driven_run(3):
    recorder(event)
os.kill(os.getpid(), 9)
"""


def test_a_killed_run_keeps_its_finished_trials(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"
    code = subprocess.run([sys.executable, "-c", KILLED, str(path)], cwd=Path(__file__).parents[2]).returncode
    assert code == -9
    summary = summarize(path)
    assert [row.number for row in summary.trials] == [1, 2, 3]
    assert not summary.whole


def test_a_trial_cut_off_by_an_error_says_so(tmp_path: Path) -> None:
    path = tmp_path / "run.rrd"

    def interrupted() -> None:
        with Recorder(path, "3d") as recorder:
            for event in rehearsal.driven_run(2):
                recorder(event)
                if event.clock.trial == 2 and event.clock.step > 30:
                    raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    summary = summarize(path)
    assert [row.number for row in summary.trials] == [1]
    assert (summary.ending, summary.whole) == ("", True)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match=r"none\.rrd: No such file"):
        summarize(tmp_path / "none.rrd")


def test_another_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "text.rrd"
    path.write_text("not a recording")
    with pytest.raises(TwonavError, match="not a Rerun recording"):
        summarize(path)


def test_a_file_cut_in_the_middle_is_refused_with_the_repair(tmp_path: Path) -> None:
    path = record(tmp_path / "run.rrd", 1)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(TwonavError, match="rerun rrd optimize"):
        summarize(path)


def test_a_recording_of_another_program_is_refused(tmp_path: Path) -> None:
    import rerun as rr

    path = tmp_path / "other.rrd"
    stream = rr.RecordingStream("other", recording_id="other-1")
    stream.save(path)
    stream.log("x", rr.Scalars(1.0))
    stream.disconnect()
    with pytest.raises(TwonavError, match="not recorded by twonav"):
        summarize(path)
