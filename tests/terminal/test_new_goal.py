"""A goal that is added while the apartment is played."""

from __future__ import annotations

import queue
import re
import threading

import pytest

from twonav_cli.events import Event, GoalAdded, Note, StepTaken, TrialEnded
from twonav_cli.terminal.commands import AddGoal, Command, GoTo, Quit
from twonav_cli.terminal.play import PlayRequest, _drive
from twonav_cli.terminal.wishes import QueuedWishes


def played(*asked: Command) -> list[Event]:
    """Return what happens in the maze of the apartment until a trial has ended or a goal was refused."""
    commands: queue.Queue[Command] = queue.Queue()
    events: list[Event] = []

    def sink(event: Event) -> None:
        events.append(event)
        if isinstance(event, TrialEnded) or (isinstance(event, Note) and event.level == "WARN"):
            commands.put(Quit())

    for command in asked:
        commands.put(command)
    request = PlayRequest(stage="maze", start="s1")
    assert _drive(request, sink, QueuedWishes(commands, threading.Event(), 0.0), None, stay=True) == 0
    return events


def test_a_new_goal_of_the_apartment_is_driven_to_on_a_shortest_way() -> None:
    events = played(AddGoal("plant", 3.2, 1.5), GoTo("plant"))
    added = next(at for at, event in enumerate(events) if isinstance(event, GoalAdded))
    assert not any(isinstance(event, StepTaken) for event in events[:added])
    (note,) = [event.text for event in events if isinstance(event, Note)]
    known = "no step taken; 0 of 459 cells without a known way"
    assert re.search(rf"{known}; from \d{{3}},\d{{3}} remembered actions", note)
    (ended,) = [event for event in events if isinstance(event, TrialEnded)]
    assert (ended.goal, ended.outcome, ended.steps) == ("plant", "reached", ended.shortest)


@pytest.mark.parametrize(
    ("asked", "why"),
    [
        (AddGoal("desk", 3.2, 1.5), "already"),
        (AddGoal("plant", 0.0, 8.0), "nearest free cell is at (0.60, 8.10)"),
        (AddGoal("plant", 99.0, 8.0), "outside the map"),
    ],
)
def test_a_new_goal_that_cannot_be_is_one_line_in_the_log(asked: AddGoal, why: str) -> None:
    events = played(asked)
    (note,) = [event.text for event in events if isinstance(event, Note)]
    assert why in note
    assert "\n" not in note
    assert not any(isinstance(event, GoalAdded) for event in events)
