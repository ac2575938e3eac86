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
        work: A function of a module, or an object that can be called; it travels to each worker once, jobs follow.
        jobs: What to do; they are begun in this order.
        processes: How many workers.
        should_stop: Asked several times a second.
        remedy: What helps when a worker was killed, for the message.

    Raises:
        StoppedError: `should_stop` said so; the workers are broken off.
        TwonavError: A worker was killed or cannot be started.
        Exception: What a job raised, as it is.
    """
    waiting = iter(enumerate(jobs))
    doing: dict[Connection, int] = {}

    def hand_out(worker: Connection) -> None:
        for number, job in waiting:
            worker.send(job)
            doing[worker] = number
            return

    with _workers(min(processes, len(jobs))) as workers:
        for worker in workers:
            with _death_noticed(remedy, should_stop):
                worker.send(work)
                hand_out(worker)
        while doing:
            ready = wait(list(doing), timeout=POLL_S)
            for worker in [worker for worker in doing if worker in ready]:
                with _death_noticed(remedy, should_stop):
                    result, error = worker.recv()
                    number = doing.pop(worker)
                    if error is None:
                        hand_out(worker)
                if error is not None:
                    raise error
                yield number, result
            if doing and should_stop():
                raise StoppedError


@contextmanager
def _workers(count: int) -> Iterator[list[Connection]]:
    """Start workers, and give the connections to them; afterwards they are gone, broken off if there was an error.

    Raises:
        TwonavError: The system starts no more processes.
    """
    processes: list[SpawnProcess] = []
    connections: list[Connection] = []
    try:
        with _interrupts_ignored():
            for _ in range(count):
                process, connection = _started_worker()
                processes.append(process)
                connections.append(connection)
        yield connections
    except BaseException:
        # What a worker keeps survives that, whatever it is at.
        for process in processes:
            process.terminate()
        raise
    finally:
        for connection in connections:
            connection.close()
        for process in processes:
            process.join()


def _started_worker() -> tuple[SpawnProcess, Connection]:
    """Return a new worker and the connection to it, which ends when the worker does.

    Raises:
        TwonavError: The system starts no more processes.
    """
    # Spawned, not forked: a fork copies the progress bar's lock, held or not, but not its thread.
    context = multiprocessing.get_context("spawn")
    try:
        ours, theirs = context.Pipe()
        with theirs:
            # What travels at the start is small: a worker's death in the middle of it would go unnoticed.
            worker = context.Process(target=_serve, args=(theirs,), daemon=True)
            worker.start()
    except OSError as error:
        raise TwonavError(f"no worker can be started: {error.strerror or error}") from error
    return worker, ours


def _serve(parent: Connection) -> None:
    """Learn what the work is and do job after job, until the parent closes the connection."""
    # Ctrl-C reaches every program of the terminal: the parent decides what becomes of it.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    with suppress(EOFError, ConnectionError):
        work = parent.recv()
        while True:
            job = parent.recv()
            try:
                outcome: tuple[Any, Exception | None] = work(job), None
            except Exception as error:  # it is the parent's to handle, whatever it is
                error.add_note(f"In a worker:\n{traceback.format_exc()}")
                outcome = None, error
            parent.send(outcome)


def _end_with_parent() -> None:
    """End this worker when its parent is gone, in the middle of a job too: nobody waits for it."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _death_noticed(remedy: str, should_stop: Callable[[], bool]) -> Iterator[None]:
    """Turn the end of a connection into a sentence; who ends all programs of a group together only wants them to stop.

    Raises:
        StoppedError: The worker is gone, and `should_stop` says so.
        TwonavError: The worker is gone.
    """
    try:
        yield
    except (EOFError, OSError) as error:
        if should_stop():
            raise StoppedError from error
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
