"""What a person asks of a table: how many runs, on which mazes, from which seed."""

from __future__ import annotations

import shlex
from dataclasses import dataclass, replace
from typing import Any

from twonav_cli.config import LearningConfig
from twonav_cli.errors import TwonavError
from twonav_cli.learner.agent import checked
from twonav_cli.learner.learners import learner_settings
from twonav_cli.maze import Maze
from twonav_cli.random_maze import random_maze

PAPER_PRESET = "paper-maze"
REPEATS, SWEEP_REPEATS = 10, 3
"""Runs of every method on every maze (§4.3.1), and of every point of the sensitivity sweep (ours)."""

MAZES = 10
"""Random mazes (§4.3)."""

SCENE = "apartment"


@dataclass(frozen=True)
class TableRequest:
    """A table, and what it is made from.

    Attributes:
        table: A key of TABLES.
        repeats: Runs of every method on every maze.
        seed: Of the mazes and of everything random in the runs.
        discount: For every learner; None for each one's own.
        cooling: For every learner: a name of COOLINGS.
        map_from: "survey" or "geometry": which map the scene's maze is made from; None as `read_floor` chooses.
        mazes: Random mazes (Tables 5 and 6, and the sweep).
        scene: Whose maze (Tables 7 and 8, and Fig. 8).
    """

    table: str
    repeats: int = REPEATS
    seed: int = 0
    discount: float | None = None
    mazes: int = MAZES
    scene: str = SCENE
    cooling: str = "per-goal"
    map_from: str | None = None

    def check(self) -> None:
        """Make sure that the numbers can be worked with.

        Raises:
            TwonavError: One of them is out of its range.
        """
        for name, value in (("repeats", self.repeats), ("mazes", self.mazes)):
            if value < 1:
                raise TwonavError(f"--{name} must be at least 1: {value} was given")
        if self.seed < 0:
            raise TwonavError(f"--seed must be at least 0: {self.seed} was given")
        checked(self.settings("multi"))

    def settings(self, learner: str, **changes: Any) -> LearningConfig:
        """Return the settings of a learner in this table: the paper's preset, with what was asked for over it."""
        settings = learner_settings(learner, PAPER_PRESET, **{"cooling": self.cooling, **changes})
        if self.discount is None or "discount" in changes:
            return settings
        return replace(settings, discount=self.discount)

    def random_mazes(self) -> list[Maze]:
        """Return the random mazes of the seed."""
        return [random_maze(self.seed, number) for number in range(self.mazes)]

    def scene_maze(self) -> Maze:
        """Return the scene's maze.

        Raises:
            TwonavError: The scene, its goals or its map are wrong.
        """
        from twonav_cli.mapping.floor import read_floor

        return read_floor(self.scene, self.map_from).maze

    def command(self, on_scene: bool) -> str:
        """Return the command that makes the table again."""
        parts = ["twonav", "reproduce", self.table, "--repeats", str(self.repeats), "--seed", str(self.seed)]
        parts += ["--scene", self.scene] if on_scene else ["--mazes", str(self.mazes)]
        parts += ["--map-from", self.map_from] if on_scene and self.map_from is not None else []
        parts += [] if self.discount is None else ["--discount", str(self.discount)]
        parts += [] if self.cooling == "per-goal" else ["--cooling", self.cooling]
        return shlex.join(parts)
