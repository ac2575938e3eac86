import math

import numpy as np
import pytest
from whole_map import WholeMap

from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cells import HIT_LOG_ODDS, MISS_LOG_ODDS, NO_TILE, TILE, TileStore

AT_ORIGIN = np.zeros(3)


def one_beam(x: float, y: float) -> FloatArray:
    return np.array([[x, y]])


def seen_from(sensor: FloatArray, ends: FloatArray) -> FloatArray:
    """Return points [N, 2] of the map in the sensor's frame."""
    cos, sin = np.cos(sensor[2]), np.sin(sensor[2])
    away = ends - sensor[:2]
    return np.stack([cos * away[:, 0] + sin * away[:, 1], cos * away[:, 1] - sin * away[:, 0]], axis=1)


def cells_on_the_way(begin: FloatArray, end: FloatArray) -> set[tuple[int, int]]:
    """Return the (row, col) that a beam goes through: of the middle of every piece between two lines of the grid."""
    shares = [0.0, 1.0]
    for a, b in zip(begin.tolist(), end.tolist(), strict=True):
        if a != b:
            shares += [(line - a) / (b - a) for line in range(math.ceil(min(a, b)), math.floor(max(a, b)) + 1)]
    cuts = np.sort(shares)
    x, y = (begin[:, None] + (end - begin)[:, None] * (cuts[1:] + cuts[:-1]) / 2)[:, np.diff(cuts) > 1e-12]
    return set(zip(np.floor(y).astype(int).tolist(), np.floor(x).astype(int).tolist(), strict=True))


def test_a_beam_counts_in_every_cell_on_its_way_and_hits_the_last() -> None:
    store = TileStore(1)
    carve_scan(store, 0, np.array([0.5, 0.5, 0.0]), one_beam(3.2, 0.0))
    map_ = WholeMap(store)
    assert [map_.counts(0, col) for col in range(-1, 5)] == [(0, 0), (0, 1), (0, 1), (0, 1), (1, 1), (0, 0)]
    assert (map_.hits.sum(), map_.visits.sum()) == (1, 4)


def test_the_cells_of_a_beam_are_those_of_a_slow_search() -> None:
    rng = np.random.default_rng(1)
    store = TileStore(1)
    expected: dict[tuple[int, int], list[int]] = {}
    for _ in range(3):
        sensor = np.array([*rng.uniform(-90, 90, 2), rng.uniform(-3, 3)])
        ends = rng.uniform(-90, 90, (40, 2))
        carve_scan(store, 0, sensor, seen_from(sensor, ends))
        for end in ends:
            for cell in cells_on_the_way(sensor[:2], end):
                expected.setdefault(cell, [0, 0])[1] += 1
            expected[math.floor(end[1]), math.floor(end[0])][0] += 1
    map_ = WholeMap(store)
    assert all(map_.counts(*cell) == tuple(counts) for cell, counts in expected.items())
    assert map_.visits.sum() == sum(visits for _, visits in expected.values())
    assert map_.hits.sum() == 120


@pytest.mark.parametrize("heading", [0.0, 0.5, 1.0, 1.5])
def test_a_beam_along_a_line_of_the_grid_goes_straight(heading: float) -> None:
    store = TileStore(1)
    carve_scan(store, 0, np.array([0.5, 0.5, heading * np.pi]), one_beam(70.0, 0.0))
    map_ = WholeMap(store)
    row, col = ((0, 70), (70, 0), (0, -70), (-70, 0))[int(2 * heading)]
    assert map_.counts(row, col) == (1, 1)
    assert map_.visits.sum() == 71


def test_a_beam_of_no_length_hits_where_it_begins() -> None:
    store = TileStore(1)
    carve_scan(store, 0, np.array([-0.3, -40.6, 1.0]), one_beam(0.0, 0.0))
    map_ = WholeMap(store)
    assert map_.counts(-41, -1) == (1, 1)
    assert map_.visits.sum() == 1


def test_a_scan_without_a_beam_leaves_the_map_as_it_is() -> None:
    store = TileStore(1)
    carve_scan(store, 0, AT_ORIGIN, np.zeros((0, 2)))
    assert store.tiles_used == 0


def test_a_beam_beyond_the_tables_makes_them_larger() -> None:
    store = TileStore(1)
    carve_scan(store, 0, np.array([-900.5, 1300.5, 0.0]), one_beam(2000.0, 0.0))
    map_ = WholeMap(store)
    assert map_.counts(1300, 1099) == (1, 1)
    assert map_.visits.sum() == 2001


def test_the_mean_of_the_ends_is_finer_than_a_cell() -> None:
    store, rng = TileStore(1), np.random.default_rng(2)
    ends = np.array([-3.0, 7.0]) + rng.uniform(0.05, 0.95, (50, 2))
    for end in ends:
        carve_scan(store, 0, np.array([2.0, -5.0, 0.7]), seen_from(np.array([2.0, -5.0, 0.7]), end[None]))
    assert WholeMap(store).counts(7, -3) == (50, 50)
    assert WholeMap(store).mean(7, -3) == pytest.approx(ends.mean(axis=0), abs=2e-3)


def test_a_cell_is_a_wall_until_more_beams_go_through_than_its_hits_outweigh() -> None:
    store, sensor = TileStore(1), np.array([0.5, 0.5, 0.0])
    carve_scan(store, 0, sensor, np.repeat(one_beam(3.0, 0.0), 2, axis=0))
    walls = []
    for _ in range(8):
        carve_scan(store, 0, sensor, one_beam(5.0, 0.0))
        walls.append((0, 3) in WholeMap(store).wall_cells())
    outweighed = 2 * HIT_LOG_ODDS / -MISS_LOG_ODDS  # misses that two hits are worth
    assert outweighed == pytest.approx(6)
    assert walls[:5] == [True] * 5
    assert walls[6:] == [False] * 2


def test_the_walls_bits_are_the_sign_of_the_log_odds_everywhere() -> None:
    store, rng = TileStore(1), np.random.default_rng(4)
    for _ in range(12):
        sensor = np.array([*rng.uniform(-5, 5, 2), rng.uniform(-3, 3)])
        angles = np.linspace(-3, 3, 300)
        ranges = rng.choice([20.0, 35.0, 40.0], 300)
        carve_scan(store, 0, sensor, np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=1))
    map_ = WholeMap(store)
    odds = HIT_LOG_ODDS * map_.hits + MISS_LOG_ODDS * (map_.visits - map_.hits)
    sure = np.abs(odds) > 1e-9
    assert np.array_equal(map_.walls[sure], odds[sure] > 0)
    assert 100 < map_.walls.sum() < (map_.hits > 0).sum()


def test_counts_never_overflow_and_keep_their_share() -> None:
    store, sensor = TileStore(1), np.array([0.5, 0.5, 0.0])
    beams = np.tile([[3.0, 0.0], [5.0, 0.0], [5.0, 0.0], [5.0, 0.0]], (1000, 1))
    for _ in range(40):
        carve_scan(store, 0, sensor, beams)
    map_ = WholeMap(store)
    assert (map_.hits >= 0).all()
    assert (map_.visits >= map_.hits).all()
    hits, visits = map_.counts(0, 3)
    assert hits / visits == pytest.approx(0.25, abs=0.005)
    assert map_.counts(0, 5)[0] == map_.counts(0, 5)[1] > 1000
    assert map_.mean(0, 5) == pytest.approx((5.5, 0.5), abs=1e-3)


def test_a_scan_goes_into_the_map_of_its_particle_alone() -> None:
    store, rng = TileStore(3), np.random.default_rng(6)
    scan = rng.uniform(-60, 60, (200, 2))
    carve_scan(store, 0, AT_ORIGIN, scan)
    store.draw_again(np.zeros(3, dtype=np.int64))
    before = WholeMap(store, 0)
    for k in range(20):
        carve_scan(store, 2, rng.uniform(-3, 3, 3), rng.uniform(-60, 60, (50, 2)))
        assert WholeMap(store, 2).hits.sum() == 200 + 50 * (k + 1)
    for particle in (0, 1):
        after = WholeMap(store, particle)
        assert np.array_equal(after.visits, before.visits)
        assert np.array_equal(after.hits, before.hits)
        assert np.array_equal(after.walls, before.walls)


def test_a_beam_through_the_corner_of_tiles_stays_in_the_map_of_its_particle() -> None:
    store, rng = TileStore(2), np.random.default_rng(7)
    angles = np.linspace(-np.pi, np.pi, 720, endpoint=False)
    carve_scan(store, 0, AT_ORIGIN, 100 * np.stack([np.cos(angles), np.sin(angles)], axis=1))
    for _ in range(100):
        store.draw_again(np.zeros(2, dtype=np.int64))
        before = WholeMap(store, 0).visits
        sensor = np.array([*rng.uniform(-30, 30, 2), rng.uniform(-3, 3)])
        corner = rng.choice([-TILE, 0, TILE], 2)
        carve_scan(store, 1, sensor, seen_from(sensor, sensor[:2] + 1.5 * (corner - sensor[:2])[None]))
        assert np.array_equal(WholeMap(store, 0).visits, before)


def test_no_tile_is_kept_that_no_beam_touched() -> None:
    store = TileStore(1)
    carve_scan(store, 0, np.array([0.5, 0.5, 0.0]), one_beam(TILE * 3.0, 0.0))
    assert (store.tables[0] != NO_TILE).sum() == store.tiles_used == 4
