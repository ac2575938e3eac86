"""What a user of an environment writes for a maze, a goal or a start, and the maze or cell that it means."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from operator import index
from pathlib import Path

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell
from twonav_cli.mapping.floor import read_floor
from twonav_cli.maze import Maze
from twonav_cli.random_maze import random_maze
from twonav_cli.scene.catalog import scene_names

Place = str | int | Sequence[int]
"""A name, a number in the maze's order from 0, or (row, col)."""

RANDOM = "random"


def read_maze(maze: str | Maze, number: int, seed: int) -> Maze:
    """Return the maze that is meant: a scene's, one of the random ones, or the given one.

    Args:
        maze: Name or path of a scene, "random", or a maze.
        number: Which of the random mazes of `seed`.
        seed: Of the random mazes.

    Raises:
        TwonavError: There is no such scene, or `number` is negative.
    """
    if isinstance(maze, Maze):
        return maze
    if maze == RANDOM:
        return random_maze(seed, number)
    path = Path(maze).expanduser()
    if maze not in scene_names() and not path.exists() and len(path.parts) < 2 and not path.suffix:
        raise unknown_name("maze", maze, [RANDOM, *scene_names()])
    return read_floor(maze).maze


def cell_of(kind: str, place: Place, maze: Maze) -> Cell:
    """Return the cell of a place.

    Args:
        kind: "goal" or "start".
        place: Name or number of a goal or start, or any free cell.
        maze: Where it lies.

    Raises:
        TwonavError: No such name or number, or a cell that is blocked or outside.
    """
    named = maze.goals if kind == "goal" else maze.starts
    if isinstance(place, str):
        if place not in named:
            raise unknown_name(kind, place, named)
        return named[place]
    numbers = _whole_numbers(place)
    if len(numbers) == 1 and 0 <= numbers[0] < len(named):
        return list(named.values())[numbers[0]]
    if len(numbers) == 2:
        row, col = numbers
        if 0 <= row < maze.rows and 0 <= col < maze.cols and not maze.blocked[row, col]:
            return Cell(row, col)
        free = maze.free_cells[0]
        raise TwonavError(
            f"{kind} ({row}, {col}) is blocked or outside the maze of {maze.rows} x {maze.cols} cells: "
            f"choose a free cell, for example ({free.row}, {free.col})"
        )
    raise TwonavError(
        f"{place!r} is no {kind}: give a name ({', '.join(named) or 'there is none'}), "
        f"a number below {len(named)} or a cell (row, col)"
    )


def goal_index_of(place: Place, maze: Maze) -> int:
    """Return the index of a goal of the maze.

    Raises:
        TwonavError: No goal of the maze is meant.
    """
    cell = cell_of("goal", place, maze)
    if isinstance(place, str):
        return maze.goal_names.index(place)
    if not isinstance(place, Iterable):
        return index(place)
    cells = list(maze.goals.values())
    if cell not in cells:
        raise TwonavError(
            f"no goal lies in cell ({cell.row}, {cell.col}), and the observation has to name one: "
            f"choose among {', '.join(maze.goals)}, or make the environment for this goal"
        )
    return cells.index(cell)


def _whole_numbers(place: int | Sequence[int]) -> list[int]:
    """Return the whole numbers that a place is made of; none where it is made of something else."""
    try:
        return [index(number) for number in place] if isinstance(place, Iterable) else [index(place)]
    except TypeError:
        return []
