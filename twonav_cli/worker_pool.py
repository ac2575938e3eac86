"""Work shared among processes: handed out in order, given back as it ends, broken off when asked.

Every worker has a connection of its own. The standard library's pools let all workers write into one pipe; breaking one
off while it writes leaves a result without an end there, for which the pool then waits forever.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from typing import Any, TypeVar

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
    remedy: str = "try again with --processes 1",
) -> Iterator[tuple[int, Result]]:
    """Do jobs in several processes; yield the number of each and what came out, as they end.

    Args:
        work: A function of a module, or an object that can be called; it travels to each worker once, the jobs follow.
        jobs: What to do; they are begun in this order.
        processes: How many workers.
        should_stop: Asked several times a second.
        remedy: What helps when a worker was killed, for the message.

    Raises:
        StoppedError: `should_stop` said so; the workers are broken off.
        TwonavError: A job raised it, or a worker was killed.
    """
    waiting = iter(enumerate(jobs))
    doing: dict[Connection, int] = {}

    def hand_out(worker: Connection) -> None:
        for number, job in waiting:
            with _death_noticed(remedy):
                worker.send(job)
            doing[worker] = number
            return

    with _workers(work, min(processes, len(jobs))) as workers:
        for worker in workers:
            hand_out(worker)
        while doing:
            ready = wait(list(doing), timeout=POLL_S)
            for worker in [worker for worker in doing if worker in ready]:
                with _death_noticed(remedy):
                    result, error = worker.recv()
                number = doing.pop(worker)
                if error is not None:
                    raise error
                hand_out(worker)
                yield number, result
            if should_stop():
                raise StoppedError


@contextmanager
def _workers(work: Callable[[Any], Any], count: int) -> Iterator[list[Connection]]:
    """Start workers, and give the connections to them; afterwards they are gone, broken off if there was an error."""
    # Spawned, not forked: a fork copies the progress bar's lock, held or not, but not its thread.
    context = multiprocessing.get_context("spawn")
    processes: list[SpawnProcess] = []
    connections: list[Connection] = []
    try:
        with _interrupts_ignored():
            for _ in range(count):
                ours, theirs = context.Pipe()
                connections.append(ours)
                with theirs:  # closed here once the worker has it, so that its death is the end of the connection
                    process = context.Process(target=_serve, args=(work, theirs))
                    process.start()
                processes.append(process)
        yield connections
    except BaseException:
        # What a worker keeps it writes whole, so what is under way can be broken off.
        for process in processes:
            process.terminate()
        raise
    finally:
        for connection in connections:
            connection.close()
        for process in processes:
            process.join()


def _serve(work: Callable[[Any], Any], parent: Connection) -> None:
    """Do job after job, until the parent closes the connection or is gone."""
    # Ctrl-C reaches every program of the terminal: the parent decides what becomes of it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with suppress(EOFError, ConnectionError):
        while True:
            job = parent.recv()
            try:
                outcome: tuple[Any, Exception | None] = work(job), None
            except Exception as error:  # it is the parent's to handle, whatever it is
                error.add_note(f"In a worker:\n{traceback.format_exc()}")
                outcome = None, error
            parent.send(outcome)


@contextmanager
def _death_noticed(remedy: str) -> Iterator[None]:
    """Turn the end of a connection into a sentence.

    Raises:
        TwonavError: The worker is gone.
    """
    try:
        yield
    except (EOFError, OSError) as error:
        raise TwonavError(f"a worker ended unexpectedly (no memory, or the disk is full?): {remedy}") from error


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
