"""Work shared among processes."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.worker_pool import StoppedError, done_in_workers


def never() -> bool:
    return False


def halved(number: int) -> float:
    return number / 2


def many_bytes(number: int) -> bytes:
    """Return more than fits into a connection at once."""
    return bytes(100_000_000)


def refused(number: int) -> int:
    raise TwonavError(f"{number} is not wanted") if number else OSError("the disk is full")


def noted_and_slow(file: Path) -> None:
    """Say who works, and work for some seconds."""
    (file / str(os.getpid())).touch()
    time.sleep(3)


def within(limit_s: float, work: Callable[[], None]) -> None:
    """Do work that might never end; fail when it does not end in time."""
    thread = threading.Thread(target=work, daemon=True)
    thread.start()
    thread.join(limit_s)
    assert not thread.is_alive()


def alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_jobs_are_numbered_as_they_were_given() -> None:
    assert dict(done_in_workers(halved, [5, 6, 7], 2, never)) == {0: 2.5, 1: 3.0, 2: 3.5}


def test_without_jobs_nothing_is_started() -> None:
    assert list(done_in_workers(halved, [], 2, never)) == []


def test_a_worker_that_is_broken_off_in_the_middle_of_a_result_holds_nobody_up() -> None:
    done: list[int] = []

    def take_until_there_are_four() -> None:
        for number, _ in done_in_workers(many_bytes, range(8), 2, lambda: len(done) >= 4):
            done.append(number)

    def be_stopped() -> None:
        with pytest.raises(StoppedError):
            take_until_there_are_four()

    within(60, be_stopped)
    assert 4 <= len(done) < 8
    assert not multiprocessing.active_children()


def test_who_looks_no_further_leaves_no_worker() -> None:
    results = done_in_workers(halved, range(100), 2, never)
    next(results)
    results.close()  # type: ignore[attr-defined]
    assert not multiprocessing.active_children()


def test_an_error_comes_through_as_it_is_and_says_where_it_was() -> None:
    with pytest.raises(OSError, match="the disk is full") as caught:
        list(done_in_workers(refused, [0], 1, never))
    assert "in refused" in caught.value.__notes__[0]
    with pytest.raises(TwonavError, match="1 is not wanted"):
        list(done_in_workers(refused, [1], 1, never))


def test_workers_whose_parent_was_killed_end_by_themselves(tmp_path: Path) -> None:
    script = (
        "from pathlib import Path; from test_worker_pool import *\n"
        "if __name__ == '__main__':\n"
        "    list(done_in_workers(noted_and_slow, [Path('workers')] * 4, 2, never))\n"
    )
    (tmp_path / "parent.py").write_text(script)
    (tmp_path / "workers").mkdir()
    paths = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    parent = subprocess.Popen([sys.executable, "parent.py"], cwd=tmp_path, env={**os.environ, "PYTHONPATH": paths})
    while len(workers := [int(file.name) for file in (tmp_path / "workers").iterdir()]) < 2:
        assert parent.poll() is None
        time.sleep(0.05)
    parent.send_signal(signal.SIGKILL)
    parent.wait()
    give_up_s = time.monotonic() + 60
    while any(map(alive, workers)):
        assert time.monotonic() < give_up_s
        time.sleep(0.05)
