"""Events on their way to the screen."""

from __future__ import annotations

import threading

import numpy as np

from twonav_cli.events import Clock, Note, Tick
from twonav_cli.geometry import Pose
from twonav_cli.terminal.screen.event_feed import MOST_TICKS, EventFeed


def tick(step: int) -> Tick:
    return Tick(Clock(step=step), Pose(0, 0, 0), Pose(0, 0, 0), np.zeros(180))


def test_only_the_newest_ticks_wait_and_nothing_else_is_dropped() -> None:
    feed = EventFeed()
    for step in range(50):
        feed(tick(step))
        feed(Note(Clock(step=step), "INFO", ""))
    events = feed.take()
    assert [e.clock.step for e in events if isinstance(e, Tick)] == list(range(50 - MOST_TICKS, 50))
    assert [e.clock.step for e in events if isinstance(e, Note)] == list(range(50))
    assert feed.take() == []


def test_a_full_feed_makes_the_writer_wait_until_it_is_read() -> None:
    feed = EventFeed(most_events=2)
    writer = threading.Thread(target=lambda: [feed(Note(Clock(step=s), "INFO", "")) for s in range(3)], daemon=True)
    writer.start()
    writer.join(0.1)
    assert writer.is_alive()
    assert len(feed.take()) == 2
    writer.join(2)
    assert [event.clock.step for event in feed.take()] == [2]


def test_a_closed_feed_lets_a_waiting_writer_go() -> None:
    feed = EventFeed(most_events=1)
    writer = threading.Thread(target=lambda: [feed(Note(Clock(), "INFO", "")) for _ in range(3)], daemon=True)
    writer.start()
    feed.close()
    writer.join(2)
    assert not writer.is_alive()
