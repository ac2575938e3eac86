"""A map drawn in characters, with the blocked cells of its maze over it."""

from __future__ import annotations

import numpy as np
import pytest

from twonav_cli.grid import GridFrame
from twonav_cli.mapping.approximate import largest_maze
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.map_drawing import (
    FREE_COLOUR,
    UNKNOWN_COLOUR,
    blocked_pixels,
    draw_map,
    map_text,
    shrunk,
)


def small_map() -> OccupancyMap:
    """Return a map of 2 x 3 cells of the maze: the upper left one holds a wall, the lower right one is unknown."""
    pixels = np.full((16, 24), FREE, dtype=np.uint8)
    pixels[2, 1:4] = OCCUPIED
    pixels[8:, 16:] = UNKNOWN
    return OccupancyMap(GridFrame(0.0, 0.0, 0.05, 16, 24), pixels)


def drawn(cols: int, coloured: bool) -> np.ndarray:
    map_ = small_map()
    picture = draw_map(map_, *largest_maze(map_), cols, coloured)
    return picture.glyphs if not coloured else np.stack([picture.ink, picture.paper], axis=1)


def test_without_colour_every_kind_has_its_character() -> None:
    glyphs = ["".join(row) for row in drawn(24, coloured=False)]
    assert len(glyphs) == 8
    assert glyphs[0] == "x" * 8 + "." * 16
    assert glyphs[1] == "x###xxxx" + "." * 16  # two rows of pixels stand in a character
    assert glyphs[5] == "." * 16 + "-" * 8


def test_with_colour_kinds_differ_in_brightness() -> None:
    colours = drawn(24, coloured=True).reshape(16, 24, 3)
    assert tuple(colours[2, 2]) == palette.WALL
    assert tuple(colours[12, 4]) == FREE_COLOUR
    brightness = {kind: sum(colour) for kind, colour in (("free", FREE_COLOUR), ("unknown", UNKNOWN_COLOUR))}
    assert brightness["free"] + 100 < brightness["unknown"] < sum(palette.WALL) - 100
    assert tuple(colours[0, 0]) not in (FREE_COLOUR, UNKNOWN_COLOUR)  # free, in a blocked cell
    assert tuple(colours[12, 20]) != tuple(colours[0, 0])  # unknown, in a blocked cell


def test_a_narrow_terminal_gets_a_smaller_drawing_that_loses_no_wall() -> None:
    glyphs = drawn(10, coloured=False)
    assert glyphs.shape[1] <= 10
    assert "#" in glyphs[0]


def test_an_occupied_pixel_is_seen_before_an_unknown_one_and_that_before_a_free_one() -> None:
    pixels = np.array([[FREE, UNKNOWN, FREE, FREE], [UNKNOWN, OCCUPIED, FREE, UNKNOWN]], dtype=np.uint8)
    kinds, covered = shrunk(pixels, np.array([[1, 1, 0, 0], [0, 1, 0, 0]], dtype=np.bool_), 2, 2)
    assert kinds.tolist() == [[OCCUPIED, FREE]]
    assert covered.tolist() == [[True, False]]
    assert shrunk(pixels[:, :3], pixels[:, :3] == FREE, 2, 2)[0].shape == (1, 2)


def test_what_lies_beyond_the_last_full_cell_is_blocked() -> None:
    map_ = OccupancyMap(GridFrame(0.0, 0.0, 0.05, 10, 18), np.full((10, 18), FREE, dtype=np.uint8))
    covered = blocked_pixels(map_.frame, *largest_maze(map_))
    assert not covered[:8, :16].any()
    assert covered[8:].all()
    assert covered[:, 16:].all()


@pytest.mark.parametrize("coloured", [True, False])
def test_below_the_drawing_stands_what_it_means_and_how_large_it_is(coloured: bool) -> None:
    map_ = small_map()
    said = map_text(map_, *largest_maze(map_), 80, coloured).plain
    assert "unknown" in said
    assert "map: 24 x 16 pixels of 0.05 m, 1.2 x 0.8 m" in said
    assert "maze: 3 x 2 cells of 0.4 m, 4 free" in said


@pytest.mark.parametrize("coloured", [True, False])
@pytest.mark.parametrize("cols", [60, 200])
def test_the_legend_is_as_wide_as_the_terminal_at_most(coloured: bool, cols: int) -> None:
    map_ = small_map()
    lines = map_text(map_, *largest_maze(map_), cols, coloured).plain.splitlines()
    assert max(map(len, lines)) <= cols
    legend = lines[lines.index("") + 1 : -2]
    assert len(legend) == (1 if cols == 200 else 2)
    assert [word in " ".join(legend) for word in ("occupied", "free", "unknown", "blocked")] == [True] * 4
