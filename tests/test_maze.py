"""Cells, walls and shortest ways."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.maze import OFFSETS, UNREACHABLE, Action, Maze, distances_from, filled_where_unreachable

#   0 1 2 3
# 0 s . # .
# 1 # . # .
# 2 . . g #
BLOCKED = np.array([[0, 0, 1, 0], [1, 0, 1, 0], [0, 0, 0, 1]], dtype=np.bool_)


@pytest.fixture
def maze() -> Maze:
    return Maze(BLOCKED, {"g": Cell(2, 2), "near": Cell(0, 1)}, {"s": Cell(0, 0)})


def test_up_is_a_smaller_row_and_right_a_larger_column(maze: Maze) -> None:
    assert maze.moved(Cell(2, 1), Action.UP) == Cell(1, 1)
    assert maze.moved(Cell(1, 1), Action.DOWN) == Cell(2, 1)
    assert maze.moved(Cell(2, 1), Action.LEFT) == Cell(2, 0)
    assert maze.moved(Cell(2, 1), Action.RIGHT) == Cell(2, 2)


def test_up_and_down_and_left_and_right_are_opposite() -> None:
    assert np.array_equal(np.negative(OFFSETS[Action.UP]), OFFSETS[Action.DOWN])
    assert np.array_equal(np.negative(OFFSETS[Action.LEFT]), OFFSETS[Action.RIGHT])


@pytest.mark.parametrize(
    ("cell", "action"),
    [
        (Cell(0, 0), Action.UP),
        (Cell(0, 0), Action.LEFT),
        (Cell(0, 0), Action.DOWN),
        (Cell(2, 2), Action.DOWN),
        (Cell(2, 2), Action.RIGHT),
        (Cell(0, 3), Action.RIGHT),
    ],
)
def test_walls_and_borders_leave_the_agent_where_it_is(maze: Maze, cell: Cell, action: Action) -> None:
    assert maze.moved(cell, action) == cell


def test_distances_count_moves_around_walls(maze: Maze) -> None:
    assert maze.distances_to(Cell(2, 2)).tolist() == [
        [4, 3, UNREACHABLE, UNREACHABLE],
        [UNREACHABLE, 2, UNREACHABLE, UNREACHABLE],
        [2, 1, 0, UNREACHABLE],
    ]


def test_nothing_can_be_reached_from_within_a_wall() -> None:
    assert (distances_from(BLOCKED, Cell(0, 2)) == UNREACHABLE).all()


def test_what_cannot_be_reached_is_filled_and_nothing_else() -> None:
    filled = filled_where_unreachable(BLOCKED, Cell(0, 0))
    assert np.argwhere(filled & ~BLOCKED).tolist() == [[0, 3], [1, 3]]
    assert filled[BLOCKED].all()


def test_free_cells_come_row_by_row(maze: Maze) -> None:
    assert maze.free_cells[:4] == [Cell(0, 0), Cell(0, 1), Cell(0, 3), Cell(1, 1)]
    assert len(maze.free_cells) == 8


def test_goals_keep_their_order(maze: Maze) -> None:
    assert maze.goal_names == ["g", "near"]


@pytest.mark.parametrize("cell", [Cell(0, 2), Cell(-1, 0), Cell(3, 0), Cell(0, 4)])
def test_a_goal_in_a_wall_or_outside_is_named(cell: Cell) -> None:
    with pytest.raises(TwonavError, match="goal 'fridge' lies in a blocked cell"):
        Maze(BLOCKED, {"fridge": cell}, {})


def test_a_start_in_a_wall_is_named() -> None:
    with pytest.raises(TwonavError, match="start 's9' lies in a blocked cell"):
        Maze(BLOCKED, {}, {"s9": Cell(1, 0)})


def test_a_goal_more_is_the_last_one_and_leaves_the_maze_before_as_it_was(maze: Maze) -> None:
    more = maze.with_goal("new", Cell(2, 0))
    assert more.goal_names == ["g", "near", "new"]
    assert more.goals["new"] == Cell(2, 0)
    assert maze.goal_names == ["g", "near"]


@pytest.mark.parametrize(("name", "cell", "why"), [("g", Cell(2, 0), "already"), ("new", Cell(0, 2), "blocked")])
def test_a_goal_more_needs_a_name_of_its_own_and_a_free_cell(maze: Maze, name: str, cell: Cell, why: str) -> None:
    with pytest.raises(TwonavError, match=why):
        maze.with_goal(name, cell)


def test_plain_pairs_become_cells_and_keep_their_order() -> None:
    pairs: Any = {"g": (2, 2), "b": [0, 1], "a": np.array([2, 0])}
    plain = Maze(BLOCKED, pairs, {"s": (0, 0)})  # type: ignore[dict-item]  # what a user writes
    assert list(plain.goals.items()) == [("g", Cell(2, 2)), ("b", Cell(0, 1)), ("a", Cell(2, 0))]
    assert all(isinstance(cell, Cell) for cell in (*plain.goals.values(), *plain.starts.values()))
    assert plain.distances_to(plain.goals["g"])[plain.starts["s"]] == 4
    assert plain.with_goal("more", Cell(2, 1)).goal_names == ["g", "b", "a", "more"]


@pytest.mark.parametrize("place", [3, None, (1,), (0, 1, 2), (0.0, 1.0), "01"], ids=repr)
def test_what_is_no_cell_is_named(place: Any) -> None:
    with pytest.raises(TwonavError, match=r"goal 'g' is no cell .*: give \(row, col\)"):
        Maze(BLOCKED, {"g": place}, {})
