"""Where an agent learns: the floor of a scene, or a random maze that has no scene."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze

if TYPE_CHECKING:
    from twonav_cli.mapping.floor import Floor


@dataclass(frozen=True)
class LearningPlace:
    """A maze, its name, and what makes its agents its own.

    Attributes:
        name: Of the scene; "random-N" where there is none.
        maze: Cells, goals and starts.
        scene_digest: An agent with another one is refused.
        map_digest: The same for the map.
        maze_frame: Where the maze lies in a scene.
        occupied: [map rows, map cols] the scene's map.
        map_frame: Where that lies.
    """

    name: str
    maze: Maze
    scene_digest: str
    map_digest: str
    maze_frame: GridFrame | None = None
    occupied: NDArray[np.bool_] | None = None
    map_frame: GridFrame | None = None


def place_of_floor(floor: Floor) -> LearningPlace:
    """Return a scene's floor as a place to learn in."""
    scene, plan = floor.scene, floor.map
    return LearningPlace(
        scene.name, floor.maze, scene.digest, plan.digest, floor.maze_frame, plan.occupied, plan.frame
    )  # fmt: skip


def place_of_random_maze(seed: int, number: int) -> LearningPlace:
    """Return the random maze of that number, drawn from a seed by the paper's rule (§4.3).

    Raises:
        TwonavError: The number is negative.
    """
    from twonav_cli.random_maze import random_maze

    maze = random_maze(seed, number)
    digest = "random-maze-" + digest_of(maze)
    return LearningPlace(f"random-{number}", maze, digest, digest)


def digest_of(maze: Maze) -> str:
    """Return 16 hexadecimal digits that stand for a maze's cells, goals and starts."""
    cells = repr((maze.blocked.astype(int).tolist(), list(maze.goals.items()), list(maze.starts.items())))
    return hashlib.sha256(cells.encode()).hexdigest()[:16]
