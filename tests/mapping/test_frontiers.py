"""Where the known floor ends, and from where it is looked at."""

from __future__ import annotations

import numpy as np

from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.frontiers import clusters, frontier_cells, in_sight, nearest_view, without_specks
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap

KINDS = {"#": OCCUPIED, ".": FREE, " ": UNKNOWN}


def map_of(*rows: str) -> OccupancyMap:
    pixels = np.array([[KINDS[kind] for kind in row] for row in rows], dtype=np.uint8)
    return OccupancyMap(GridFrame(0.0, 0.0, 0.05, *pixels.shape), pixels)


def cells_of(grid: np.ndarray) -> list[tuple[int, int]]:
    return [(int(row), int(col)) for row, col in np.argwhere(grid)]


def test_a_frontier_is_free_floor_beside_what_nobody_has_seen() -> None:
    map_ = map_of(
        "######",
        "#...  ",
        "#.#.  ",
        "######",
    )
    assert cells_of(frontier_cells(map_, 1)) == [(1, 3), (2, 3)]


def test_a_speck_that_nobody_has_seen_makes_no_frontier() -> None:
    map_ = map_of("....  ", ". ..  ")
    assert cells_of(frontier_cells(map_, 2)) == [(0, 3), (1, 3)]
    assert (0, 1) in cells_of(frontier_cells(map_, 1))


def test_the_border_of_the_map_is_no_frontier() -> None:
    assert not frontier_cells(map_of("...", "..."), 1).any()


def test_cells_that_touch_with_a_corner_belong_together() -> None:
    grid = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 0, 1]], dtype=np.bool_)
    assert [group.tolist() for group in clusters(grid, 1)] == [[[0, 0], [1, 1]], [[0, 3]], [[2, 3]]]
    assert [group.tolist() for group in clusters(grid, 2)] == [[[0, 0], [1, 1]]]
    assert cells_of(without_specks(grid, 2)) == [(0, 0), (1, 1)]


def test_nobody_looks_through_a_wall() -> None:
    occupied = np.zeros((3, 5), dtype=np.bool_)
    occupied[:, 2] = True
    assert not in_sight(Cell(1, 0), Cell(1, 4), occupied)
    assert in_sight(Cell(0, 0), Cell(2, 1), occupied)
    assert in_sight(Cell(1, 0), Cell(1, 2), occupied)  # the wall itself is seen
    assert in_sight(Cell(1, 1), Cell(1, 1), occupied)


def test_the_nearest_cluster_that_can_be_looked_at_is_chosen() -> None:
    lengths = np.full((3, 12), np.inf)
    lengths[1, :9] = np.arange(9.0)
    occupied = np.zeros((3, 12), dtype=np.bool_)
    groups = [np.array([[1, 11]]), np.array([[0, 4], [1, 4], [2, 4]])]
    view = nearest_view(groups, lengths, occupied, range_cells=3.0)
    assert view is not None
    assert view.facing == Cell(1, 4)
    assert view.cell == Cell(1, 4)  # a metre of gap costs more than a metre of way
    far = nearest_view(groups[:1], lengths, occupied, range_cells=3.0)
    assert far is not None
    assert (far.cell, far.facing) == (Cell(1, 8), Cell(1, 11))
    assert nearest_view(groups[:1], lengths, occupied, range_cells=2.0) is None
    occupied[:, 9:11] = True
    assert nearest_view(groups[:1], lengths, occupied, range_cells=3.0) is None
    assert nearest_view([], lengths, occupied, range_cells=3.0) is None


def test_who_is_near_enough_comes_no_nearer() -> None:
    lengths = np.arange(12.0)[None]
    view = nearest_view([np.array([[0, 10]])], lengths, np.zeros((1, 12), dtype=np.bool_), 8.0, from_cells=4.0)
    assert view is not None
    assert view.cell == Cell(0, 6)
