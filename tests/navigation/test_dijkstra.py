import itertools
import math

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.navigation.dijkstra import FreeSpace, distances, free_for_radius, path


def test_a_path_goes_round_a_wall_and_cuts_no_corner():
    free = np.ones((5, 7), dtype=bool)
    free[1:, 3] = False
    cells = path(free, Cell(4, 0), Cell(4, 6))
    assert cells[0] == Cell(4, 0)
    assert cells[-1] == Cell(4, 6)
    assert all(free[cell] for cell in cells)
    steps = [(b.row - a.row, b.col - a.col) for a, b in itertools.pairwise(cells)]
    assert max(max(abs(r), abs(c)) for r, c in steps) == 1
    assert {Cell(0, 2), Cell(0, 3), Cell(0, 4)} <= set(cells)


def test_lengths_count_diagonal_steps_by_the_square_root_of_two():
    lengths = distances(np.ones((4, 6), dtype=bool), Cell(0, 0))
    assert lengths[3, 5] == pytest.approx(3 * math.sqrt(2) + 2)
    assert lengths[0, 5] == pytest.approx(5)


def test_what_cannot_be_reached_is_infinitely_far_and_has_no_path():
    space = FreeSpace(np.array([[True, False, True]]))
    assert np.isinf(space.distances(Cell(0, 0))[0, 2])
    with pytest.raises(TwonavError, match="no path"):
        space.path(Cell(0, 0), Cell(0, 2))


@pytest.mark.parametrize("cell", [Cell(0, 1), Cell(0, 3), Cell(-1, 0)])
def test_an_end_that_is_not_free_is_an_error(cell):
    with pytest.raises(TwonavError, match="not free"):
        FreeSpace(np.array([[True, False, True]])).path(Cell(0, 0), cell)


def test_room_for_a_radius_is_measured_to_the_near_border_of_a_pixel():
    occupied = np.zeros((1, 20), dtype=bool)
    occupied[0, 0] = True
    free = free_for_radius(occupied, 0.05, 0.2)
    assert int(np.argmax(free[0])) == 5


def test_a_weight_makes_the_way_go_round_dear_places():
    weight = np.ones((5, 7))
    weight[2, 1:6] = 10.0
    straight = FreeSpace(np.ones((5, 7), dtype=bool)).path(Cell(2, 0), Cell(2, 6))
    round_ = FreeSpace(np.ones((5, 7), dtype=bool), weight).path(Cell(2, 0), Cell(2, 6))
    assert all(cell.row == 2 for cell in straight)
    assert {cell.row for cell in round_[1:-1]} in ({1}, {3})
    lengths = FreeSpace(np.ones((1, 3), dtype=bool), np.array([[1.0, 3.0, 3.0]])).distances(Cell(0, 0))
    assert lengths.tolist() == [[0.0, 2.0, 5.0]]


def test_one_search_gives_the_ways_to_every_cell():
    free = np.ones((4, 6), dtype=bool)
    free[1:, 3] = False
    tree = FreeSpace(free).tree(Cell(3, 0))
    assert tree.path_to(Cell(3, 0)) == [Cell(3, 0)]
    for goal in (Cell(0, 5), Cell(3, 5), Cell(2, 1)):
        assert tree.path_to(goal) == path(free, Cell(3, 0), goal)
    with pytest.raises(TwonavError, match="no path"):
        tree.path_to(Cell(2, 3))
