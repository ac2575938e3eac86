"""What the pictures of the maze show."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.environments.drawing import AGENT, BLOCKED, FREE, GOAL, picture_of, text_of
from twonav_cli.grid import Cell

MAZE = np.array([[0, 1, 0], [0, 0, 0]], dtype=np.bool_)


def test_the_agent_stands_before_the_goal_in_text() -> None:
    assert text_of(MAZE, Cell(0, 0), Cell(0, 2)) == "@#G\n...\n"
    assert text_of(MAZE, Cell(0, 2), Cell(0, 2)) == ".#@\n...\n"


@pytest.mark.parametrize(
    ("cell", "colour"), [((0, 0), AGENT), ((0, 1), BLOCKED), ((0, 2), GOAL), ((1, 0), FREE), ((1, 2), FREE)]
)
def test_the_centre_of_a_cell_has_the_colour_of_what_is_in_it(cell: tuple[int, int], colour: tuple[int, ...]) -> None:
    picture = picture_of(MAZE, Cell(0, 0), Cell(0, 2))
    assert picture.shape == (320, 480, 3)
    assert tuple(picture[cell[0] * 160 + 80, cell[1] * 160 + 80].tolist()) == colour


def test_goal_and_agent_are_both_seen_in_one_cell() -> None:
    picture = picture_of(MAZE, Cell(1, 1), Cell(1, 1))
    assert tuple(picture[160 + 80, 160 + 80].tolist()) == AGENT
    assert tuple(picture[160 + 80 - 55, 160 + 80 - 55].tolist()) == GOAL


def test_a_large_maze_keeps_visible_cells() -> None:
    assert picture_of(np.zeros((2, 300), dtype=np.bool_), Cell(0, 0), Cell(1, 299)).shape == (8, 1200, 3)
