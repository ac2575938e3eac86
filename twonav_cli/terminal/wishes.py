"""The player's commands, as a journey asks for them."""

from __future__ import annotations

import queue
import threading
from collections import deque

from twonav_cli.experiments.new_goal import GoalWish
from twonav_cli.terminal.commands import AddGoal, Command, GoTo, Kidnap, Move, Pause, Quit, SingleStep, Speed

_POLL_S = 0.05


class QueuedWishes:
    """Reads the screen's queue; implements `experiments.journey.Wishes`."""

    def __init__(self, commands: queue.Queue[Command], stop: threading.Event, speed: float) -> None:
        self._commands = commands
        self._stop = stop
        self._speed = speed
        self._goals: deque[str] = deque()
        self._new_goals: deque[GoalWish] = deque()
        self._moves: deque[int] = deque()
        self._kidnap = False
        self._paused = False
        self._single_steps = 0

    def next_goal(self, wait: bool) -> str | None:
        """Return the next goal that was asked for; with `wait`, block until the player wants anything or leaves."""
        self._read()
        while wait and not (self._goals or self._new_goals or self._kidnap or self._moves or self.left()):
            self._read(timeout_s=_POLL_S)
        # The goal that is asked for may be the one that is still to be added.
        return self._goals.popleft() if self._goals and not self._new_goals else None

    def take_new_goal(self) -> GoalWish | None:
        """Return the next goal that is to be added, once."""
        self._read()
        return self._new_goals.popleft() if self._new_goals else None

    def take_kidnap(self) -> bool:
        """Return whether a kidnap was asked for, once."""
        self._read()
        asked, self._kidnap = self._kidnap, False
        return asked

    def take_move(self) -> int | None:
        """Return the action that the player takes for the agent, once."""
        return self._moves.popleft() if self._moves else None

    def wait_for_permission(self) -> None:
        """Block while paused, unless a single step, a move or a kidnap was asked for, or a goal is to be added."""
        self._read()
        while self._paused and not (
            self._single_steps or self._moves or self._kidnap or self._goals or self._new_goals or self.left()
        ):
            self._read(timeout_s=_POLL_S)
        if not self._new_goals:  # a goal is added between two steps and takes none
            self._single_steps = max(self._single_steps - 1, 0)

    def pace(self) -> float:
        """Return simulated seconds per second of watching."""
        self._read()
        return self._speed

    def left(self) -> bool:
        """Return whether the player has left."""
        return self._stop.is_set()

    def _read(self, timeout_s: float = 0.0) -> None:
        """Take every waiting command off the queue, waiting at most `timeout_s` for the first."""
        while True:
            try:
                command = self._commands.get(timeout=timeout_s) if timeout_s else self._commands.get_nowait()
            except queue.Empty:
                return
            timeout_s = 0.0
            self._take(command)

    def _take(self, command: Command) -> None:
        match command:
            case GoTo(goal):
                self._goals.append(goal)
            case AddGoal(name, x_m, y_m):
                self._new_goals.append(GoalWish(name, None if x_m is None or y_m is None else (x_m, y_m)))
            case Kidnap():
                self._kidnap = True
            case Pause(on):
                self._paused = on
            case SingleStep():
                self._paused = True
                self._single_steps += 1
            case Speed(factor):
                self._speed = factor
            case Move(action):
                self._moves.append(action)
            case Quit():
                self._stop.set()
