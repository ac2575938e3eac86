"""What every stage can do: put the robot somewhere, and carry out one action."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.events import Clock, Filtered, Sink
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.maze import Maze


@dataclass(frozen=True)
class Observation:
    """What is known between two actions."""

    cell: Cell
    """Where the agent believes to be."""
    true_cell: Cell
    """Where it is."""
    pose_true: Pose | None = None
    pose_estimate: Pose | None = None
    image: NDArray[np.uint8] | None = None
    """[84, 84, 3] RGB the estimate was made from."""
    belief: Belief | None = None
    """What that picture alone says, where a localizer gives one."""
    filtered: Filtered | None = None
    """What the filter makes of it, where there is one."""


@dataclass(frozen=True)
class ActionResult:
    """How an action ended: `outcome` is one of `navigation.outcomes`, as the stage noticed it."""

    outcome: str
    observation: Observation
    plausible: bool = True
    """Whether odometry agrees with the looks before and after; if not, one of them was wrong, and the cells say nothing
    about what the action does."""


class Stage(Protocol):
    """A world with cells and four actions."""

    name: str
    maze: Maze

    @property
    def time_s(self) -> float:
        """Simulated time since the stage was made."""

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw what is random in the world from a stream from here on: then a trial repeats, whatever came before."""

    def place(self, cell: Cell) -> Observation:
        """Put the robot at the centre of a free cell, tell it that it knows nothing, and look."""

    def carry(self, cell: Cell) -> Observation:
        """Put the robot into a free cell without telling it, and look: it still believes what it believed."""

    def close(self) -> None:
        """Give back what the stage holds."""

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        """Carry out one action, sending a Tick per control period (if the stage has any), and look."""
