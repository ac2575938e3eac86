"""What stays the same on a floor plan: walls, floor, goals and rooms, and where they fall among the characters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze

GOAL_KEYS = "123456789"
"""The key that picks a goal is its mark on the plan; the tenth is 0, further ones have no key."""


@dataclass(frozen=True, eq=False)
class Plan:
    """A floor plan in metres.

    Attributes:
        frame: Where the map lies.
        occupied: [map rows, map cols] bool.
        inside: [map rows, map cols] bool, floor that the robot can see from where it may be.
        goals: Name to position (x_m, y_m), in table order.
        rooms: Name to the position of its label.
        maze_frame: Where the maze lies, for the arrows.
    """

    frame: GridFrame
    occupied: NDArray[np.bool_]
    inside: NDArray[np.bool_]
    goals: dict[str, tuple[float, float]]
    rooms: dict[str, tuple[float, float]] = field(default_factory=dict)
    maze_frame: GridFrame | None = None

    @property
    def aspect(self) -> float:
        """Width over height."""
        return (self.frame.x_max_m - self.frame.x_min_m) / (self.frame.y_max_m - self.frame.y_min_m)


def plan_of_map(
    occupied: NDArray[np.bool_],
    frame: GridFrame,
    goals: Mapping[str, tuple[float, float]],
    rooms: Mapping[str, tuple[float, float]] | None = None,
    maze_frame: GridFrame | None = None,
) -> Plan:
    """Return the plan of an occupancy map [map rows, map cols]; goals and rooms in metres."""
    seeds = np.zeros(frame.shape, dtype=np.bool_)
    for x_m, y_m in goals.values():
        seeds[frame.cell_at(x_m, y_m)] = True
    inside = _reached(~occupied, seeds) if goals else ~occupied
    return Plan(frame, occupied, inside, dict(goals), dict(rooms or {}), maze_frame)


def plan_of_maze(maze: Maze, frame: GridFrame) -> Plan:
    """Return the plan of a maze that has no map: its blocked cells are the walls."""
    goals = {name: frame.centre_of(cell) for name, cell in maze.goals.items()}
    return Plan(frame, maze.blocked, ~maze.blocked, goals, {}, frame)


def goal_key(index: int) -> str:
    """Return the mark and key of the goal at a place of the table, empty from the eleventh on."""
    return (GOAL_KEYS + "0")[index] if index < 10 else ""


def _reached(free: NDArray[np.bool_], seeds: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Return the free pixels that are connected to a seed, by growing the seeds until nothing is added."""
    reached = seeds & free
    while True:
        grown = reached.copy()
        grown[1:] |= reached[:-1]
        grown[:-1] |= reached[1:]
        grown[:, 1:] |= reached[:, :-1]
        grown[:, :-1] |= reached[:, 1:]
        grown &= free
        if np.array_equal(grown, reached):
            return reached
        reached = grown


@dataclass(frozen=True)
class Sheet:
    """Where metres fall among the characters of a drawing: half a character is a pixel, two above each other."""

    frame: GridFrame
    rows: int
    cols: int

    def pixel_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Return the (row, col) of the pixel that holds a point, None outside."""
        across = (x_m - self.frame.x_min_m) / (self.frame.x_max_m - self.frame.x_min_m)
        down = (self.frame.y_max_m - y_m) / (self.frame.y_max_m - self.frame.y_min_m)
        if not (0 <= across < 1 and 0 <= down < 1):
            return None
        return int(down * 2 * self.rows), int(across * self.cols)

    def place_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Return the (row, col) of the character that holds a point, None outside."""
        pixel = self.pixel_at(x_m, y_m)
        return (pixel[0] // 2, pixel[1]) if pixel is not None else None

    def centres(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return x of every column [cols] and y of every row [rows] of characters, at the centres, metres."""
        frame = self.frame
        xs = frame.x_min_m + (np.arange(self.cols) + 0.5) * (frame.x_max_m - frame.x_min_m) / self.cols
        ys = frame.y_max_m - (np.arange(self.rows) + 0.5) * (frame.y_max_m - frame.y_min_m) / self.rows
        return xs, ys


def fitted(plan: Plan, rows: int, cols: int) -> Sheet:
    """Return the largest sheet of the plan's shape in a space of `rows` x `cols` characters."""
    wide = min(cols, round(2 * rows * plan.aspect))
    high = min(rows, round(wide / plan.aspect / 2))
    return Sheet(plan.frame, max(high, 1), max(wide, 1))


@lru_cache(maxsize=16)
def shares(plan: Plan, rows: int, cols: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the occupied share and the inside share of every box, both [rows, cols]."""
    return _box_means(plan.occupied, rows, cols), _box_means(plan.inside, rows, cols)


def _box_means(mask: NDArray[np.bool_], rows: int, cols: int) -> NDArray[np.float64]:
    """Return the mean of the pixels whose centres lie in each box; a box smaller than a pixel takes its pixel's."""
    sums = np.pad(mask.astype(np.float64), ((1, 0), (1, 0))).cumsum(0).cumsum(1)
    top, bottom = _edges(mask.shape[0], rows)
    left, right = _edges(mask.shape[1], cols)
    total = (
        sums[np.ix_(bottom, right)] - sums[np.ix_(top, right)] - sums[np.ix_(bottom, left)] + sums[np.ix_(top, left)]
    )
    return np.asarray(total / np.outer(bottom - top, right - left), dtype=np.float64)


def _edges(length: int, boxes: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the first pixel of every box and the one after its last, at least one pixel in each."""
    edges = np.floor(np.arange(boxes + 1) * length / boxes + 0.5 * (boxes < length)).astype(np.int64)
    first = np.minimum(edges[:-1], length - 1)
    return first, np.minimum(np.maximum(edges[1:], first + 1), length)
