"""The simulation in a thread of its own, so that the screen keeps answering."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable

from twonav_cli.errors import TwonavError
from twonav_cli.events import Sink
from twonav_cli.terminal.commands import Command
from twonav_cli.terminal.screen.event_feed import EventFeed

Start = Callable[[Sink, "queue.Queue[Command]", threading.Event], int]
"""Runs the simulation: gets a sink, the player's commands and the signal to stop; returns the exit code."""

PATIENCE_S = 20.0


class SimulationThread:
    """Runs `start` and keeps what came of it."""

    def __init__(self, start: Start) -> None:
        self.feed = EventFeed()
        self.commands: queue.Queue[Command] = queue.Queue()
        self.stop = threading.Event()
        self.error: BaseException | None = None
        self._start = start
        self._code = 0
        self._thread = threading.Thread(target=self._run, name="simulation", daemon=True)

    def start(self) -> None:
        """Let it run."""
        self._thread.start()

    @property
    def finished(self) -> bool:
        """Whether it has returned or failed."""
        return not self._thread.is_alive()

    def result(self) -> int:
        """Ask it to stop, wait for it and return its exit code.

        Raises:
            TwonavError: It does not stop.
            BaseException: What the simulation raised.
        """
        self.stop.set()
        self.feed.close()
        self._thread.join(PATIENCE_S)
        if self._thread.is_alive():
            raise TwonavError(f"the simulation did not stop within {PATIENCE_S:g} s: its recording may be cut short")
        if self.error is not None:
            raise self.error
        return self._code

    def _run(self) -> None:
        try:
            self._code = self._start(self.feed, self.commands, self.stop)
        except BaseException as error:  # handed to the caller of `result`, in the thread that can show it
            self.error = error
