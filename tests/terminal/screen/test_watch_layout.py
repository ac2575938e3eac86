"""How the terminal is shared while one watches."""

from __future__ import annotations

import pytest

from twonav_cli.terminal.screen.watch_layout import BAR_COLS, NUMBER_ROWS, Box, size_of, watch_layout

APARTMENT, KITCHEN, RANDOM = (23, 36, 10), (13, 18, 5), (12, 12, 10)


def places(box: Box) -> set[tuple[int, int]]:
    return {(box.left + x, box.top + y) for x in range(box.cols) for y in range(box.rows)}


@pytest.mark.parametrize("maze", [APARTMENT, KITCHEN, RANDOM, (100, 100, 12), (3, 3, 1)])
@pytest.mark.parametrize(("cols", "rows"), [(80, 24), (120, 40), (200, 50), (100, 24), (60, 60), (40, 12), (20, 5)])
def test_the_panels_lie_side_by_side_inside_the_terminal_and_leave_two_lines(
    cols: int, rows: int, maze: tuple[int, int, int]
) -> None:
    spaces = watch_layout(cols, rows, *maze)
    boxes = [places(box) for box in (spaces.maze, spaces.errors, spaces.numbers)]
    assert sum(map(len, boxes)) == len(set.union(*boxes)), "no two of them overlap"
    assert all(0 <= x < cols and 0 <= y < max(rows - 2, 1) for box in boxes for x, y in box)
    assert boxes[0]


@pytest.mark.parametrize(
    ("cols", "rows", "maze", "zoom"),
    [
        (80, 24, APARTMENT, 0),
        (120, 40, APARTMENT, 1),
        (200, 50, APARTMENT, 2),
        (80, 24, KITCHEN, 1),
        (80, 24, RANDOM, 1),
        (120, 40, RANDOM, 3),
    ],
)
def test_the_maze_is_as_large_as_it_can_be_with_a_line_for_every_goal(
    cols: int, rows: int, maze: tuple[int, int, int], zoom: int
) -> None:
    spaces = watch_layout(cols, rows, *maze)
    wide, tall = size_of(zoom, *maze[:2])
    assert spaces.zoom == zoom
    assert spaces.maze.cols >= wide + 2
    assert spaces.maze.rows >= tall + 2
    assert spaces.errors.rows >= maze[2] + 2
    assert spaces.errors.cols >= BAR_COLS
    assert spaces.numbers.rows >= NUMBER_ROWS
