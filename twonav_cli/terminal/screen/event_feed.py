"""The way of events from the simulation's thread to the screen's."""

from __future__ import annotations

import threading
from collections import deque

from twonav_cli.events import Event, Tick

MOST_EVENTS = 2000
MOST_TICKS = 8
"""Ticks waiting at most; older ones are dropped, for a picture of the past is worth less than one of now."""


class EventFeed:
    """A bounded queue that is a sink: it drops ticks when the reader is behind, and makes the writer wait otherwise."""

    def __init__(self, most_events: int = MOST_EVENTS) -> None:
        self._events: deque[Event] = deque()
        self._most = most_events
        self._ticks = 0
        self._closed = False
        self._changed = threading.Condition()

    def __call__(self, event: Event) -> None:
        """Add an event; waits while the feed is full, unless nobody reads any more."""
        with self._changed:
            if isinstance(event, Tick):
                if self._ticks >= MOST_TICKS:
                    self._drop_oldest_tick()
                self._ticks += 1
            self._changed.wait_for(lambda: self._closed or len(self._events) < self._most)
            if not self._closed:
                self._events.append(event)

    def take(self) -> list[Event]:
        """Return everything that waits, in order, and empty the feed."""
        with self._changed:
            taken = list(self._events)
            self._events.clear()
            self._ticks = 0
            self._changed.notify_all()
        return taken

    def close(self) -> None:
        """Let go of a waiting writer; what it sends from now on is forgotten."""
        with self._changed:
            self._closed = True
            self._changed.notify_all()

    def _drop_oldest_tick(self) -> None:
        for place, event in enumerate(self._events):
            if isinstance(event, Tick):
                del self._events[place]
                self._ticks -= 1
                return
