"""Between metres and cells: the centre, a negative origin, a point on a border."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell, GridFrame

FRAME = GridFrame(-2.4, -0.1, 0.4, 24, 47)
"""The apartment's maze: its origin is negative in both axes."""

EVERY_CELL = [Cell(row, col) for row in range(FRAME.rows) for col in range(FRAME.cols)]


def test_the_top_left_cell_has_its_centre_half_a_cell_below_and_right_of_the_corner() -> None:
    assert FRAME.centre_of(Cell(0, 0)) == pytest.approx((-2.2, 9.3))


def test_the_last_cell_has_its_centre_half_a_cell_above_and_left_of_the_other_corner() -> None:
    assert FRAME.centre_of(Cell(23, 46)) == pytest.approx((16.2, 0.1))


def test_the_centre_of_every_cell_lies_in_that_cell() -> None:
    assert [FRAME.cell_at(*FRAME.centre_of(cell)) for cell in EVERY_CELL] == EVERY_CELL


def test_the_lower_left_corner_of_every_cell_belongs_to_it() -> None:
    corners = [(FRAME.x_min_m + c * 0.4, FRAME.y_min_m + (FRAME.rows - 1 - r) * 0.4) for r, c in EVERY_CELL]
    assert [FRAME.cell_at(*corner) for corner in corners] == EVERY_CELL


def test_a_point_on_a_border_belongs_to_the_cell_right_of_and_above_it() -> None:
    grid = GridFrame(-1.0, -1.0, 0.5, 4, 4)
    assert grid.cell_at(0.0, 0.25) == Cell(1, 2)
    assert grid.cell_at(0.25, 0.0) == Cell(1, 2)
    assert grid.cell_at(-0.25, -0.5) == Cell(2, 1)


def test_y_up_is_row_down() -> None:
    assert FRAME.cell_at(0.0, 0.5).row > FRAME.cell_at(0.0, 5.0).row


@pytest.mark.parametrize(
    ("x_m", "y_m", "cell"),
    [
        (-9.0, 99.0, Cell(0, 0)),
        (99.0, -9.0, Cell(23, 46)),
        (FRAME.x_max_m, FRAME.y_max_m, Cell(0, 46)),
    ],
)
def test_points_outside_go_to_the_nearest_border_cell(x_m: float, y_m: float, cell: Cell) -> None:
    assert not FRAME.contains(x_m, y_m)
    assert FRAME.cell_at(x_m, y_m) == cell


def test_the_lower_and_left_borders_are_on_the_grid() -> None:
    assert FRAME.contains(-2.4, -0.1)


def test_the_vectors_of_centres_are_the_centres_of_the_cells() -> None:
    xs, ys = FRAME.centres()
    assert xs.shape == (47,)
    assert ys.shape == (24,)
    assert (xs[5], ys[7]) == pytest.approx(FRAME.centre_of(Cell(7, 5)))


def test_the_apartments_map_becomes_its_maze() -> None:
    maze_frame = GridFrame(-2.4, -0.1, 0.05, 192, 376).coarser(0.4)
    assert maze_frame.shape == (24, 47)
    assert (maze_frame.x_min_m, maze_frame.y_min_m) == pytest.approx((-2.4, -0.1))


def test_a_coarser_grid_keeps_the_top_left_corner_and_drops_what_is_not_full() -> None:
    fine = GridFrame(-1.0, -1.0, 0.05, 19, 17)
    coarse = fine.coarser(0.4)
    assert coarse.shape == (2, 2)
    assert (coarse.x_min_m, coarse.y_max_m) == pytest.approx((fine.x_min_m, fine.y_max_m))
    assert coarse.y_min_m == pytest.approx(-1.0 + 3 * 0.05)


def test_every_pixel_lies_in_the_coarse_cell_that_its_indices_say() -> None:
    fine = GridFrame(-2.4, -0.1, 0.05, 32, 24)
    coarse = fine.coarser(0.4)
    for row, col in np.ndindex(fine.shape):
        assert coarse.cell_at(*fine.centre_of(Cell(row, col))) == Cell(row // 8, col // 8)


@pytest.mark.parametrize(("resolution_m", "rows", "cols"), [(0.0, 2, 2), (0.1, 0, 2), (0.1, 2, -1)])
def test_a_grid_without_cells_is_refused(resolution_m: float, rows: int, cols: int) -> None:
    with pytest.raises(TwonavError, match="needs cells"):
        GridFrame(0.0, 0.0, resolution_m, rows, cols)


def test_cells_larger_than_the_grid_are_refused() -> None:
    with pytest.raises(TwonavError, match="needs cells"):
        GridFrame(0.0, 0.0, 0.05, 4, 4).coarser(0.4)


def test_many_points_lie_in_the_cells_that_each_lies_in_alone() -> None:
    frame = GridFrame(-1.0, 2.0, 0.05, 30, 40)
    x_m, y_m = np.meshgrid(np.arange(-1.2, 1.3, 0.05), np.arange(1.8, 3.8, 0.05))
    rows, cols, inside = frame.cells_at(x_m, y_m)
    for row, col, x, y in zip(rows.flat, cols.flat, x_m.flat, y_m.flat, strict=True):
        assert (row, col) == frame.cell_at(x, y)
    assert inside.any()
    assert not inside.all()
