"""Random mazes, drawn by the paper's rule (§4.3).

N cells to a side; arrays are [row, col].
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.maze import Maze, distances_from, filled_where_unreachable
from twonav_cli.rng import stream

RUN_CHANCE = 0.3
"""Share of the columns, and then of the rows, that get a run of obstacles (§4.3)."""

FIRST_START = Cell(0, 0)
"""Always free, and the first start of every random maze (§4.3)."""

DRAWS_AT_MOST = 300
"""Mazes drawn before giving up (ours). With the paper's numbers about one in twenty is rejected."""


def random_maze(seed: int, number: int, size: int = 10, goals: int = 10, goal_distance: int = 7) -> Maze:
    """Return maze `number` of a seed: the same arguments give the same maze (§4.3).

    A maze with too few cells for its goals and starts is rejected and drawn again. Goals and starts are all distinct,
    and no start lies on a goal (ours: the paper says only that they are random).

    Args:
        seed: Of the run.
        number: Which of the seed's mazes, from 0.
        size: N, cells to a side.
        goals: Number of goals, named "1", "2", ..., and of starts, named alike; start "1" is cell (0, 0).
        goal_distance: Every goal is more than this many steps from (0, 0).

    Raises:
        TwonavError: An argument is out of its range, or no maze of this size has room for what is asked.
    """
    _check(number, size, goals, goal_distance)
    rng = stream(seed, "maze", number)
    for _ in range(DRAWS_AT_MOST):
        blocked = filled_where_unreachable(drawn_obstacles(size, rng), FIRST_START)
        far = np.argwhere(distances_from(blocked, FIRST_START) > goal_distance)
        if len(far) >= goals and (~blocked).sum() >= 2 * goals:
            goal_cells = _drawn_cells(far, goals, rng)
            taken = {FIRST_START, *goal_cells}
            others = np.array([cell for cell in np.argwhere(~blocked).tolist() if tuple(cell) not in taken])
            start_cells = [FIRST_START, *(_drawn_cells(others, goals - 1, rng) if goals > 1 else [])]
            return Maze(blocked, _numbered(goal_cells), _numbered(start_cells))
    raise TwonavError(
        f"none of {DRAWS_AT_MOST} random mazes of {size} x {size} cells has {goals} goals more than {goal_distance} "
        f"steps from (0, 0) and {goals} starts beside them: ask for a larger maze, fewer goals or a shorter distance"
    )


def drawn_obstacles(size: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return obstacles [N, N] before filling: runs in the columns, then in the rows; (0, 0) is free (§4.3)."""
    in_columns = drawn_runs(size, rng).T
    blocked = in_columns | drawn_runs(size, rng)
    blocked[FIRST_START] = False
    return blocked


def drawn_runs(size: int, rng: np.random.Generator) -> NDArray[np.bool_]:
    """Return obstacles [N, N] in rows: with a chance of 30 % one run, 1 to N // 2 cells long and anywhere (§4.3)."""
    blocked = np.zeros((size, size), dtype=np.bool_)
    for row in blocked:
        if rng.random() < RUN_CHANCE:
            length = int(rng.integers(1, size // 2 + 1))
            first = int(rng.integers(0, size - length + 1))
            row[first : first + length] = True
    return blocked


def _drawn_cells(cells: NDArray[np.int64], number: int, rng: np.random.Generator) -> list[Cell]:
    """Return that many distinct cells of the given ones [n, 2]."""
    chosen = rng.choice(len(cells), number, replace=False)
    return [Cell(int(row), int(col)) for row, col in cells[chosen]]


def _numbered(cells: list[Cell]) -> dict[str, Cell]:
    return {str(number): cell for number, cell in enumerate(cells, 1)}


def _check(number: int, size: int, goals: int, goal_distance: int) -> None:
    for name, value, smallest in (
        ("number of a random maze", number, 0),
        ("size of a random maze", size, 2),
        ("number of goals", goals, 1),
        ("goal distance", goal_distance, 0),
    ):
        if value < smallest:
            raise TwonavError(f"the {name} must be at least {smallest}: {value} was given")
