"""What a player can ask for: the screen puts these on a queue, the simulation takes them between two actions."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class GoTo:
    """Drive to a goal by name."""

    goal: str


@dataclass(frozen=True)
class AddGoal:
    """Add a goal at a place in the map frame, or, without one, where the robot believes to be."""

    name: str
    x_m: float | None = None
    y_m: float | None = None


@dataclass(frozen=True)
class Kidnap:
    """Carry the robot elsewhere without telling it."""


@dataclass(frozen=True)
class Pause:
    """Stop the simulation, or let it go on."""

    on: bool


@dataclass(frozen=True)
class SingleStep:
    """Carry out one action and stay paused."""


@dataclass(frozen=True)
class Speed:
    """Run at `factor` times real time."""

    factor: float


@dataclass(frozen=True)
class Move:
    """Carry out one action (an index of `maze.Action`) that the player chose."""

    action: int


@dataclass(frozen=True)
class Quit:
    """End the run."""


Command = GoTo | AddGoal | Kidnap | Pause | SingleStep | Speed | Move | Quit
