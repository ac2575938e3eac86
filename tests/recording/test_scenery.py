from __future__ import annotations

import numpy as np

from twonav_cli.grid import GridFrame
from twonav_cli.recording.palette import COST_LEVELS, TOUCHING_COLOUR, cost_colours, cost_level_colours
from twonav_cli.recording.scenery import wall_edges


def test_a_free_cell_has_four_edges_in_metres_with_row_0_on_top() -> None:
    blocked = np.ones((2, 3), dtype=np.bool_)
    blocked[0, 1] = False
    edges = wall_edges(blocked, GridFrame(-1.0, 2.0, 0.5, 2, 3))
    corners = {tuple(point) for segment in edges.tolist() for point in segment}
    assert len(edges) == 4
    assert corners == {(-0.5, 3.0), (0.0, 3.0), (-0.5, 2.5), (0.0, 2.5)}


def test_a_candidate_that_would_touch_is_red_and_the_cheapest_is_darkest() -> None:
    colours = cost_colours(np.array([1.0, np.inf, 3.0], dtype=np.float32))
    assert colours[1] == TOUCHING_COLOUR
    assert colours[0] == 0x440154FF


def test_free_floor_is_clear_in_a_cost_map() -> None:
    colours = cost_level_colours()
    assert len(colours) == COST_LEVELS
    assert [colour[3] for colour in colours] == [0] + [255] * (COST_LEVELS - 1)
