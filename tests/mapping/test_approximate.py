import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.approximate import approximate_maze, blocked_cells, largest_maze
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap

FRAME = GridFrame(-0.4, 0.0, 0.05, 16, 24)  # 2 x 3 cells of 0.4 m
UPPER_LEFT, UPPER_RIGHT, LOWER_RIGHT = Pose(-0.2, 0.6, 0.0), Pose(0.6, 0.6, 0.0), Pose(0.6, 0.2, 0.0)


def map_with(**pixels: tuple[int, int, int]) -> OccupancyMap:
    """Return the map that is free but for the given pixels (row, col, value)."""
    values = np.full(FRAME.shape, FREE, dtype=np.uint8)
    for row, col, value in pixels.values():
        values[row, col] = value
    return OccupancyMap(FRAME, values)


def test_goals_and_starts_become_the_cells_that_hold_them() -> None:
    maze, frame = approximate_maze(map_with(), {"a": UPPER_RIGHT}, {"b": UPPER_LEFT})
    assert (frame.rows, frame.cols, frame.resolution_m) == (2, 3, 0.4)
    assert maze.goals == {"a": Cell(0, 2)}
    assert maze.starts == {"b": Cell(0, 0)}
    assert frame.centre_of(Cell(0, 2)) == pytest.approx((0.6, 0.6))
    assert not maze.blocked.any()


@pytest.mark.parametrize("value", [OCCUPIED, UNKNOWN])
@pytest.mark.parametrize(("row", "col"), [(8, 8), (8, 15), (15, 8), (15, 15)])
def test_one_pixel_that_is_not_free_blocks_its_cell_and_no_other(row: int, col: int, value: int) -> None:
    maze, _ = approximate_maze(map_with(one=(row, col, value)), {"a": UPPER_RIGHT}, {"b": UPPER_LEFT})
    assert np.argwhere(maze.blocked).tolist() == [[1, 1]]


def test_what_cannot_be_reached_is_filled() -> None:
    map_ = map_with(above=(0, 8, OCCUPIED), below=(8, 8, OCCUPIED))
    maze, _ = approximate_maze(map_, {"a": UPPER_RIGHT}, {"b": LOWER_RIGHT})
    assert maze.blocked.tolist() == [[True, True, False], [True, True, False]]


def test_a_goal_apart_from_the_first_start_is_named() -> None:
    map_ = map_with(above=(0, 8, OCCUPIED), below=(8, 8, OCCUPIED))
    with pytest.raises(TwonavError, match="goal 'a' cannot be reached from start 'b'"):
        approximate_maze(map_, {"a": UPPER_RIGHT}, {"b": UPPER_LEFT})


def test_a_goal_in_a_wall_is_named_with_a_better_place() -> None:
    with pytest.raises(TwonavError, match=r"goal 'a' .* move it, for example to \(0\.\d\d, 0\.\d\d\)"):
        approximate_maze(map_with(one=(0, 16, OCCUPIED)), {"a": UPPER_RIGHT}, {"b": UPPER_LEFT})


def test_a_goal_off_the_map_is_named() -> None:
    with pytest.raises(TwonavError, match=r"goal 'a' .* off the map"):
        approximate_maze(map_with(), {"a": Pose(3.0, 0.2, 0.0)}, {})


def test_cells_that_would_not_be_full_are_dropped() -> None:
    frame = GridFrame(0.0, 0.0, 0.05, 19, 17)
    not_free = np.zeros(frame.shape, dtype=np.bool_)
    not_free[17, 0] = not_free[0, 16] = True
    assert blocked_cells(not_free, frame, 0.4).tolist() == [[False, False], [False, False]]


def test_cells_of_broken_pixels_are_refused() -> None:
    with pytest.raises(TwonavError, match="not whole pixels"):
        approximate_maze(map_with(), {"a": UPPER_RIGHT}, {}, resolution_m=0.42)


def test_a_map_without_goals_keeps_its_largest_connected_part() -> None:
    map_ = map_with(above=(0, 8, OCCUPIED), below=(8, 8, UNKNOWN), corner=(15, 0, OCCUPIED))
    maze, frame = largest_maze(map_)
    assert maze.blocked.tolist() == [[True, True, False], [True, True, False]]
    assert (maze.goals, maze.starts) == ({}, {})
    assert frame.shape == (2, 3)


def test_cells_of_a_map_of_other_pixels_are_as_near_to_40_cm_as_they_can_be() -> None:
    frame = GridFrame(0.0, 0.0, 0.03, 26, 39)
    maze, cells = largest_maze(OccupancyMap(frame, np.full(frame.shape, FREE, dtype=np.uint8)))
    assert maze.blocked.shape == (2, 3)
    assert cells.resolution_m == pytest.approx(0.39)


def test_a_map_without_a_free_cell_or_smaller_than_one_has_no_maze() -> None:
    values = np.full(FRAME.shape, FREE, dtype=np.uint8)
    values[3::8, 3::8] = OCCUPIED
    with pytest.raises(TwonavError, match=r"no 0\.40 m cell of the map is free"):
        largest_maze(OccupancyMap(FRAME, values))
    small = GridFrame(0.0, 0.0, 0.05, 4, 4)
    with pytest.raises(TwonavError, match="smaller than one maze cell"):
        largest_maze(OccupancyMap(small, np.full((4, 4), FREE, dtype=np.uint8)))
