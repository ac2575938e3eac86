"""Work shared among processes."""

from __future__ import annotations

import multiprocessing
import os
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


def noted_and_endless(folder: Path) -> None:
    """Say that somebody works, and never come to an end."""
    (folder / str(os.getpid())).touch()
    while True:
        time.sleep(1)


class DiesOnArrival:
    """Work that no worker survives to receive, and that does not fit into a connection at once."""

    def __init__(self) -> None:
        self.content = bytes(10_000_000)

    def __setstate__(self, state: object) -> None:
        os._exit(1)

    def __call__(self, number: int) -> int:
        return number


def within(limit_s: float, work: Callable[[], None]) -> None:
    """Do work that might never end; fail as it does, or when it does not end in time."""
    failures: list[BaseException] = []

    def tried() -> None:
        try:
            work()
        except BaseException as error:
            failures.append(error)

    thread = threading.Thread(target=tried, daemon=True)
    thread.start()
    thread.join(limit_s)
    assert not thread.is_alive()
    if failures:
        raise failures[0]


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


def test_a_worker_that_dies_before_it_begins_is_one_line() -> None:
    def begin() -> None:
        list(done_in_workers(DiesOnArrival(), range(3), 2, never, "buy memory"))

    with pytest.raises(TwonavError, match=r"a worker ended unexpectedly .*: buy memory"):
        within(60, begin)


def test_who_ends_the_whole_group_wants_it_to_stop() -> None:
    asked: list[int] = []

    def all_are_ended_at_once() -> bool:
        asked.append(1)
        for worker in multiprocessing.active_children():
            worker.terminate()
        return len(asked) > 1

    def begin() -> None:
        list(done_in_workers(time.sleep, [0.1, 100, 100], 2, all_are_ended_at_once))

    with pytest.raises(StoppedError):
        within(60, begin)


def test_workers_whose_parent_was_killed_end_in_the_middle_of_their_jobs(tmp_path: Path) -> None:
    script = (
        "from pathlib import Path; from test_worker_pool import *\n"
        "if __name__ == '__main__':\n"
        "    list(done_in_workers(noted_and_endless, [Path('workers')] * 2, 2, never))\n"
    )
    (tmp_path / "parent.py").write_text(script)
    (tmp_path / "workers").mkdir()
    paths = os.pathsep.join([str(Path(__file__).parent), *filter(None, sys.path)])
    environment = {**os.environ, "PYTHONPATH": paths}
    parent = subprocess.Popen([sys.executable, "parent.py"], cwd=tmp_path, env=environment, stdout=subprocess.PIPE)
    while len(list((tmp_path / "workers").iterdir())) < 2:
        assert parent.poll() is None
        time.sleep(0.05)
    parent.kill()
    parent.communicate(timeout=60)  # it returns when nobody holds the other end any more
