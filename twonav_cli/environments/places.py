"""What a user of an environment writes for a scene, a maze, a goal, a start or an action, and what it means."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from operator import index
from pathlib import Path

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.grid import Cell
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.maze import Action, Maze
from twonav_cli.random_maze import random_maze
from twonav_cli.scene.catalog import scene_names

Place = str | int | Sequence[int]
"""A name, a number in the maze's order from 0, or (row, col)."""

RANDOM = "random"


@dataclass(frozen=True)
class Goal:
    """A goal of an episode. Its cell alone does not tell it from another goal in the same cell.

    Attributes:
        name: Its name in the maze, or its cell as text.
        number: From 0 in the maze's order; None for a cell in which no goal of the maze lies.
        cell: Where it lies.
    """

    name: str
    number: int | None
    cell: Cell


def read_maze(maze: str | Path | Maze, number: int, seed: int) -> Maze:
    """Return the maze that is meant: a scene's, one of the random ones, or the given one.

    Args:
        maze: Name or path of a scene, "random", or a maze.
        number: Which of the random mazes of `seed`.
        seed: Of the random mazes.

    Raises:
        TwonavError: There is no such scene, `number` is negative, or one of the numbers is no whole number.
    """
    if isinstance(maze, Maze):
        return maze
    if not isinstance(maze, str | Path):
        raise TwonavError(f"{maze!r} is no maze: give a name ({', '.join([RANDOM, *scene_names()])}), a path or a Maze")
    if maze == RANDOM:
        return random_maze(_whole_number("seed", seed), _whole_number("number", number))
    maze = str(maze)
    path = Path(maze).expanduser()
    if maze not in scene_names() and not path.exists() and len(path.parts) < 2 and not path.suffix:
        raise unknown_name("maze", maze, [RANDOM, *scene_names()])
    return read_floor(maze).maze


def floor_of(scene: str | Path, map_from: str | None) -> Floor:
    """Return the floor of a scene.

    Args:
        scene: Name or path.
        map_from: "survey" or "geometry"; None takes the survey's map where there is one, else the geometry's.

    Raises:
        TwonavError: There is no such scene or map.
    """
    if not isinstance(scene, str | Path):
        raise TwonavError(f"{scene!r} is no scene: give a name ({', '.join(scene_names())}) or a path")
    return read_floor(str(scene), None if map_from is None else str(map_from))


def start_of(place: Place, maze: Maze) -> Cell:
    """Return the cell of a start.

    Raises:
        TwonavError: No such name or number, or a cell that is blocked or outside.
    """
    return _name_and_cell("start", place, maze)[1]


def goal_of(place: Place, maze: Maze) -> Goal:
    """Return the goal that is meant; by its cell, the first of the maze's goals there.

    Raises:
        TwonavError: No such name or number, or a cell that is blocked or outside.
    """
    name, cell = _name_and_cell("goal", place, maze)
    if name is None:
        name = next((known for known, there in maze.goals.items() if there == cell), None)
    if name is None:
        return Goal(f"({cell.row}, {cell.col})", None, cell)
    return Goal(name, maze.goal_names.index(name), cell)


def numbered_goal_of(place: Place, maze: Maze) -> Goal:
    """Return the goal that is meant, one of the maze's.

    Raises:
        TwonavError: No goal of the maze is meant.
    """
    goal = goal_of(place, maze)
    if goal.number is None:
        raise TwonavError(
            f"no goal lies in cell {goal.name}, and the observation has to name one: "
            f"choose among {', '.join(maze.goals)}, or make the environment for this goal"
        )
    return goal


def action_of(action: int) -> int:
    """Return the action's number.

    Raises:
        TwonavError: There is no such action.
    """
    try:
        number = index(action)
    except TypeError:
        number = -1
    if not 0 <= number < len(Action):
        raise TwonavError(f"there is no action {action!r}: 0 is up, 1 down, 2 left, 3 right")
    return number


def _name_and_cell(kind: str, place: Place, maze: Maze) -> tuple[str | None, Cell]:
    """Return the name of a goal or start, None where it is meant by its cell, and the cell."""
    named = maze.goals if kind == "goal" else maze.starts
    if isinstance(place, str):
        if place not in named:
            raise unknown_name(kind, place, named)
        return place, named[place]
    numbers = _whole_numbers(place)
    if len(numbers) == 1 and 0 <= numbers[0] < len(named):
        return list(named.items())[numbers[0]]
    if len(numbers) == 2:
        row, col = numbers
        if 0 <= row < maze.rows and 0 <= col < maze.cols and not maze.blocked[row, col]:
            return None, Cell(row, col)
        free = maze.free_cells[0]
        raise TwonavError(
            f"{kind} ({row}, {col}) is blocked or outside the maze of {maze.rows} x {maze.cols} cells: "
            f"choose a free cell, for example ({free.row}, {free.col})"
        )
    raise TwonavError(
        f"{place!r} is no {kind}: give a name ({', '.join(named) or 'there is none'}), "
        f"a number below {len(named)} or a cell (row, col)"
    )


def _whole_number(name: str, value: int) -> int:
    """Return a number that tells random mazes apart."""
    try:
        return index(value)
    except TypeError:
        raise TwonavError(f"the {name} of a random maze must be a whole number: {value!r} was given") from None


def _whole_numbers(place: int | Sequence[int]) -> list[int]:
    """Return the whole numbers that a place is made of; none where it is made of something else."""
    try:
        return [index(number) for number in place] if isinstance(place, Iterable) else [index(place)]
    except TypeError:
        return []
