"""The way over the known floor."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from twonav_cli.mapping.route import nearest_cell, passable, place_cost, spaced, ways_from

FRAME = GridFrame(0.0, 0.0, 0.05, 40, 60)  # 2 x 3 m
NOTHING = np.zeros(FRAME.shape, dtype=np.bool_)


def hall(door_rows: slice | None = None) -> OccupancyMap:
    """Return a hall with a wall across its middle, at x = 1.5 m, and perhaps a door in it."""
    pixels = np.full(FRAME.shape, FREE, dtype=np.uint8)
    pixels[[0, -1]] = OCCUPIED
    pixels[:, [0, -1]] = OCCUPIED
    pixels[:, 30] = OCCUPIED
    if door_rows is not None:
        pixels[door_rows, 30] = FREE
    return OccupancyMap(FRAME, pixels)


def test_the_robot_fits_a_little_more_than_its_half_width_from_a_wall() -> None:
    fits, room_m = passable(hall(), NOTHING)
    assert room_m[20, 26] == pytest.approx(0.2)
    assert not fits[20, 26]
    assert fits[20, 24]
    assert room_m[20, 24] == pytest.approx(0.3)


def test_the_robot_keeps_away_from_what_nobody_has_seen_and_from_what_was_tried_in_vain() -> None:
    pixels = hall().pixels.copy()
    pixels[20, 15] = UNKNOWN
    refused = NOTHING.copy()
    refused[20, 22] = True
    fits, _ = passable(OccupancyMap(FRAME, pixels), refused)
    assert not fits[20, 15]
    assert not fits[20, 17]
    assert fits[20, 18]
    assert not fits[20, 22]


def test_a_door_wide_enough_is_gone_through_in_its_middle_and_a_narrow_one_not() -> None:
    wide = ways_from(hall(slice(12, 28)), Pose(0.5, 0.5, 0.0), NOTHING)
    narrow = ways_from(hall(slice(18, 22)), Pose(0.5, 0.5, 0.0), NOTHING)
    assert wide is not None
    assert narrow is not None
    there = FRAME.cell_at(2.5, 0.5)
    assert math.isinf(narrow.tree.lengths[there])
    points = wide.points_to(there, 0.4)
    assert points[-1] == pytest.approx(FRAME.centre_of(there))
    at_door = min(points, key=lambda point: abs(point[0] - 1.525))
    assert at_door[1] == pytest.approx(1.0, abs=0.25)  # the door reaches from 0.6 to 1.4 m


def test_a_robot_that_seems_to_stand_in_a_wall_begins_beside_it() -> None:
    ways = ways_from(hall(), Pose(1.45, 1.0, 0.0), NOTHING)
    assert ways is not None
    x_m, _ = FRAME.centre_of(ways.tree.start)
    assert 1.1 < x_m < 1.35
    assert ways_from(OccupancyMap(FRAME, np.full(FRAME.shape, UNKNOWN, np.uint8)), Pose(1, 1, 0), NOTHING) is None


def test_what_is_too_far_away_is_not_near() -> None:
    cells = NOTHING.copy()
    cells[20, 40] = True
    assert nearest_cell(cells, FRAME, Pose(1.8, 1.0, 0.0)) == Cell(20, 40)
    assert nearest_cell(cells, FRAME, Pose(1.0, 1.0, 0.0)) is None


def test_a_place_costs_more_the_nearer_a_wall_is() -> None:
    costs = place_cost(np.array([0.19, 0.3, 0.6, 2.0]))
    assert costs[0] == pytest.approx(5.0)
    assert costs[0] > costs[1] > costs[2]
    assert costs[2:].tolist() == [1.0, 1.0]


def test_points_lie_equally_far_apart_along_the_path_and_the_last_is_its_end() -> None:
    points = spaced([(0.0, 0.0), (1.0, 0.0), (1.0, 0.5)], 0.4)
    assert points[-1] == (1.0, 0.5)
    assert len(points) == 4  # 1.5 m in pieces of 0.375 m
    assert points[0] == pytest.approx((0.375, 0.0))
    gaps = [math.dist(a, b) for a, b in itertools.pairwise([(0.0, 0.0), *points])]
    assert max(gaps) <= 0.4
    assert spaced([(2.0, 3.0)], 0.4) == [(2.0, 3.0)]
