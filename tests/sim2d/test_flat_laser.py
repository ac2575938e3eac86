import math

import numpy as np
import pytest

from twonav_cli.navigation.distance import distances_m
from twonav_cli.navigation.footprint import WindowGrid
from twonav_cli.sim2d.flat_laser import BEAMS, cast_beam, fill_scan

GRID = WindowGrid(-1.0, 0.5, 0.05)


def scan_at(occupied: np.ndarray, pose: tuple[float, float, float], max_m: float) -> np.ndarray:
    found = np.empty(BEAMS)
    fill_scan(occupied, distances_m(occupied, GRID.resolution_m), GRID, pose, max_m, found)
    return found


def occupied_at(occupied: np.ndarray, x_m: float, y_m: float) -> bool:
    rows, cols = occupied.shape
    row, col = rows - 1 - math.floor((y_m - 0.5) / 0.05), math.floor((x_m + 1.0) / 0.05)
    return bool(0 <= row < rows and 0 <= col < cols and occupied[row, col])


def test_a_beam_ends_at_the_near_border_of_a_pixel() -> None:
    occupied = np.zeros((60, 60), dtype=bool)
    occupied[:, 40] = True  # from x = 1.0 on
    assert cast_beam(occupied, GRID, 0.3, 1.5, 0.0, 5.0) == pytest.approx(0.7)
    assert cast_beam(occupied, GRID, 1.35, 1.5, math.pi, 5.0) == pytest.approx(0.3)
    assert cast_beam(occupied, GRID, 0.3, 1.5, math.pi / 3, 5.0) == pytest.approx(1.4)


def test_a_beam_that_meets_nothing_or_leaves_the_map_has_the_largest_range() -> None:
    occupied = np.zeros((40, 60), dtype=bool)
    assert cast_beam(occupied, GRID, 0.3, 1.5, 0.3, 5.0) == 5.0
    occupied[:, 40] = True
    assert cast_beam(occupied, GRID, 0.3, 1.5, 0.0, 0.6) == 0.6


def test_every_beam_ends_where_small_steps_along_it_first_meet_a_pixel() -> None:
    rng = np.random.default_rng(4)
    for _ in range(20):
        occupied = rng.random((60, 60)) < 0.02
        pose = (*rng.uniform((-0.2, 1.0), (1.2, 2.8)), float(rng.uniform(-3, 3)))
        x, y = pose[0] + 0.02 * math.cos(pose[2]), pose[1] + 0.02 * math.sin(pose[2])
        found = scan_at(occupied, pose, 2.0)
        for beam in range(0, BEAMS, 13):
            angle = pose[2] - math.pi / 2 + math.pi * beam / (BEAMS - 1)
            along = np.arange(0.0, 2.0, 0.001)
            hits = [s for s in along if occupied_at(occupied, x + s * math.cos(angle), y + s * math.sin(angle))]
            assert found[beam] == pytest.approx(hits[0] if hits else 2.0, abs=0.0015)


def test_far_from_everything_the_scan_is_the_same_as_with_every_beam_cast() -> None:
    occupied = np.zeros((100, 100), dtype=bool)
    occupied[50, 60] = True
    for away_m in (0.5, 0.69, 0.71, 0.75, 0.9):
        pose = (2.025 - away_m, 0.5 + 49.5 * 0.05, 0.0)
        cast = cast_beam(occupied, GRID, pose[0] + 0.02, pose[1], 0.0, 0.7)
        assert scan_at(occupied, pose, 0.7)[90] == pytest.approx(cast, abs=1e-3)
