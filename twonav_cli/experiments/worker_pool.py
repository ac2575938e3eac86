"""Work shared among processes: handed out in order, given back as it ends, broken off when asked."""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

from twonav_cli.errors import TwonavError

Job = TypeVar("Job")
Result = TypeVar("Result")

POLL_S = 0.1
"""How long a request to stop may go unseen."""


class StoppedError(Exception):
    """The work was asked to stop before the last of it was done."""


def processors() -> int:
    """Return how many processors this program may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def done_in_workers(
    work: Callable[[Job], Result],
    jobs: Sequence[Job],
    processes: int,
    should_stop: Callable[[], bool],
    option: str = "--processes",
) -> Iterator[tuple[int, Result]]:
    """Do jobs in several processes; yield the number of each and what came out, as they end.

    Args:
        work: A function of a module; it and the jobs travel to the workers.
        jobs: What to do; they are begun in this order.
        processes: How many workers.
        should_stop: Asked several times a second.
        option: The option that sets the number of workers, for the message.

    Raises:
        StoppedError: `should_stop` said so; the workers are broken off.
        TwonavError: A job raised it, or a worker was killed.
    """
    # Spawned, not forked: a fork copies the progress bar's lock, held or not, but not its thread.
    context = multiprocessing.get_context("spawn")
    # Ctrl-C reaches every program of the terminal: here it asks to stop, and the workers are told by the parent.
    ignore = (signal.SIGINT, signal.SIG_IGN)
    pool = ProcessPoolExecutor(min(processes, len(jobs)), context, signal.signal, ignore)
    others = multiprocessing.active_children()
    try:
        with _interrupts_ignored():
            futures = {pool.submit(work, job): number for number, job in enumerate(jobs)}
        waiting = set(futures)
        while waiting:
            ended, waiting = wait(waiting, timeout=POLL_S, return_when=FIRST_COMPLETED)
            for done in ended:
                yield futures[done], done.result()
            if should_stop():
                raise StoppedError
    except BrokenProcessPool as error:
        raise TwonavError(f"a worker ended unexpectedly (out of memory?): try again with {option} 1") from error
    except BaseException:
        # What a worker keeps it writes whole, so what is under way can be broken off.
        for worker in multiprocessing.active_children():
            if worker not in others:
                worker.terminate()
        raise
    finally:
        pool.shutdown(cancel_futures=True)


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Ignore Ctrl-C while workers are started: they inherit that, and it holds before their first line runs."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
