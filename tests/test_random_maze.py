"""Random mazes follow the paper's rule."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.maze import UNREACHABLE, Maze
from twonav_cli.random_maze import drawn_obstacles, drawn_runs, random_maze

MAZES = [random_maze(seed, number) for seed, number in itertools.product((0, 7), range(10))]


def run_of(row: NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first cell and the length of the obstacles in a row."""
    cells = np.flatnonzero(row)
    assert cells[-1] - cells[0] + 1 == len(cells), "one run has no gap"
    return int(cells[0]), len(cells)


@pytest.fixture(scope="module")
def runs() -> list[tuple[int, int]]:
    """Every run of 2000 draws of ten rows."""
    rng = np.random.default_rng(3)
    rows = np.concatenate([drawn_runs(10, rng) for _ in range(2000)])
    return [run_of(row) for row in rows if row.any()]


def test_three_in_ten_rows_hold_one_run(runs: list[tuple[int, int]]) -> None:
    assert abs(len(runs) / 20_000 - 0.3) < 0.015


def test_a_run_is_at_most_half_the_maze_long_and_every_length_is_as_likely(runs: list[tuple[int, int]]) -> None:
    shares = np.bincount([length for _, length in runs]) / len(runs)
    assert len(shares) == 6
    assert shares[0] == 0
    assert np.abs(shares[1:] - 0.2).max() < 0.03


def test_a_run_lies_anywhere_in_its_row(runs: list[tuple[int, int]]) -> None:
    for length in range(1, 6):
        firsts = np.bincount([first for first, other in runs if other == length]) / sum(n == length for _, n in runs)
        assert len(firsts) == 11 - length
        assert np.abs(firsts - 1 / (11 - length)).max() < 0.05


def test_columns_hold_as_much_as_rows() -> None:
    drawn = np.array([drawn_obstacles(10, np.random.default_rng(seed)) for seed in range(3000)])
    across, down = drawn[:, :, 1:] & drawn[:, :, :-1], drawn[:, 1:] & drawn[:, :-1]
    assert 0.9 < across.sum() / down.sum() < 1.1
    # A cell is in a run of its row with a chance of 0.3 x 3 / 10 on average, and so for its column.
    assert abs(drawn[:, 1:, 1:].mean() - (1 - (1 - 0.09) ** 2)) < 0.02


def test_the_first_cell_is_always_free() -> None:
    drawn = [drawn_obstacles(2, np.random.default_rng(seed)) for seed in range(100)]
    assert not any(blocked[0, 0] for blocked in drawn)
    assert any(blocked.sum() == 3 for blocked in drawn)


@pytest.mark.parametrize("maze", MAZES)
def test_every_free_cell_is_connected_to_the_first_one(maze: Maze) -> None:
    assert (maze.distances_to(Cell(0, 0))[~maze.blocked] != UNREACHABLE).all()


@pytest.mark.parametrize("maze", MAZES)
def test_ten_goals_lie_more_than_seven_steps_from_the_first_cell(maze: Maze) -> None:
    distance = maze.distances_to(Cell(0, 0))
    assert list(maze.goals) == [str(number) for number in range(1, 11)]
    assert len(set(maze.goals.values())) == 10
    assert min(distance[cell] for cell in maze.goals.values()) > 7


@pytest.mark.parametrize("maze", MAZES)
def test_ten_starts_begin_with_the_first_cell_and_none_lies_on_a_goal(maze: Maze) -> None:
    assert list(maze.starts) == [str(number) for number in range(1, 11)]
    assert maze.starts["1"] == Cell(0, 0)
    assert len({*maze.starts.values(), *maze.goals.values()}) == 20


def test_goals_just_beyond_the_distance_occur() -> None:
    nearest = [min(maze.distances_to(Cell(0, 0))[cell] for cell in maze.goals.values()) for maze in MAZES]
    assert min(nearest) == 8


def test_the_same_seed_and_number_give_the_same_maze() -> None:
    first, again = random_maze(4, 2), random_maze(4, 2)
    assert np.array_equal(first.blocked, again.blocked)
    assert (first.goals, first.starts) == (again.goals, again.starts)


def test_mazes_differ_by_number_and_by_seed() -> None:
    drawn = {maze.blocked.tobytes() for maze in MAZES}
    assert len(drawn) == len(MAZES)


def test_size_goals_and_distance_can_be_chosen() -> None:
    maze = random_maze(0, 0, size=6, goals=3, goal_distance=4)
    assert (maze.rows, maze.cols, len(maze.goals), len(maze.starts)) == (6, 6, 3, 3)
    assert min(maze.distances_to(Cell(0, 0))[cell] for cell in maze.goals.values()) > 4


def test_one_goal_needs_one_start() -> None:
    assert random_maze(0, 0, goals=1).starts == {"1": Cell(0, 0)}


@pytest.mark.parametrize("impossible", [{"size": 3}, {"goals": 51}, {"goal_distance": 90}])
def test_a_maze_that_cannot_be_is_refused(impossible: dict[str, int]) -> None:
    with pytest.raises(TwonavError, match="ask for a larger maze, fewer goals or a shorter distance"):
        random_maze(0, 0, **impossible)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"number": -1}, "number of a random maze must be at least 0: -1"),
        ({"size": 1}, "size of a random maze must be at least 2: 1"),
        ({"goals": 0}, "number of goals must be at least 1: 0"),
        ({"goal_distance": -1}, "goal distance must be at least 0: -1"),
    ],
)
def test_an_argument_out_of_its_range_is_named(wrong: dict[str, int], sentence: str) -> None:
    with pytest.raises(TwonavError, match=sentence):
        random_maze(0, **{"number": 0, **wrong})
