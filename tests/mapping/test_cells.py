import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.mapping.cells import HITS, MOST_CELLS, NO_TILE, TILE, TileStore

PARTICLES = 4


def touching(store: TileStore, rows: slice, cols: slice) -> np.ndarray:
    touched = np.zeros(store.tables.shape[1:], dtype=np.bool_)
    touched[rows, cols] = True
    return touched


def uses(store: TileStore) -> np.ndarray:
    """Return how often each tile [T] stands in the tables."""
    return np.bincount(store.tables[store.tables != NO_TILE], minlength=len(store.references))


def write(store: TileStore, particle: int, row: int, col: int, value: int) -> None:
    """Write a number and a wall into the tile at a place of a particle's table."""
    store.own(particle, touching(store, slice(row, row + 1), slice(col, col + 1)))
    tile = store.tables[particle, row, col]
    store.cells[tile, :, HITS] = value
    store.walls[tile] = value


def read(store: TileStore, particle: int, row: int, col: int) -> int:
    """Return the number that is written all over a tile, 0 where there is none."""
    tile = store.tables[particle, row, col]
    if tile == NO_TILE:
        return 0
    values = set(store.cells[tile, :, HITS].tolist()) | set(store.walls[tile].tolist())
    assert len(values) == 1
    return int(values.pop())


def test_what_one_particle_writes_no_other_particle_reads() -> None:
    store = TileStore(PARTICLES)
    write(store, 0, 3, 5, 11)
    store.draw_again(np.zeros(PARTICLES, dtype=np.int64))
    assert store.tiles_used == 1
    write(store, 2, 3, 5, 22)
    assert [read(store, particle, 3, 5) for particle in range(PARTICLES)] == [11, 11, 22, 11]
    assert store.tiles_used == 2


def test_a_copy_begins_with_what_was_shared_and_a_new_tile_is_empty() -> None:
    store = TileStore(2)
    write(store, 0, 3, 5, 11)
    store.draw_again(np.array([0, 0]))
    store.own(1, touching(store, slice(3, 4), slice(5, 7)))
    assert [read(store, 1, 3, col) for col in (5, 6)] == [11, 0]
    assert store.tables[1, 3, 6] != NO_TILE


def test_a_tile_that_nobody_shares_is_not_copied() -> None:
    store = TileStore(PARTICLES)
    write(store, 1, 3, 5, 11)
    tile = store.tables[1, 3, 5]
    write(store, 1, 3, 5, 12)
    assert store.tables[1, 3, 5] == tile
    assert store.tiles_used == 1


def test_maps_stay_apart_and_counts_stay_right_over_many_draws() -> None:
    rng = np.random.default_rng(3)
    store = TileStore(PARTICLES)
    written = np.zeros((PARTICLES, 6, 6), dtype=np.int64)  # what each particle's map must hold
    for value in range(1, 200):
        particle, row, col = int(rng.integers(PARTICLES)), int(rng.integers(6)), int(rng.integers(6))
        write(store, particle, row, col, value)
        written[particle, row, col] = value
        if value % 7 == 0:
            parents = np.sort(rng.integers(PARTICLES, size=PARTICLES))
            store.draw_again(parents)
            written = written[parents]
        assert np.array_equal(uses(store), store.references)
        assert store.tiles_used == (store.references > 0).sum()
    found = [[[read(store, p, row, col) for col in range(6)] for row in range(6)] for p in range(PARTICLES)]
    assert np.array_equal(found, written)
    assert len(np.unique(written)) > 20


def test_a_tile_that_nobody_uses_is_used_again() -> None:
    store = TileStore(2)
    write(store, 1, 3, 5, 22)
    tile = store.tables[1, 3, 5]
    store.draw_again(np.array([0, 0]))
    assert store.tiles_used == 0
    taken = set()
    while store.tiles_used < len(store.references):
        row, col = divmod(store.tiles_used, store.tables.shape[2])
        write(store, 0, row, col, 1)
        taken.add(int(store.tables[0, row, col]))
    assert tile in taken
    assert len(store.references) == len(TileStore(2).references)


def test_a_tile_that_is_used_again_begins_empty() -> None:
    store = TileStore(2)
    for col in range(32):
        store.own(1, touching(store, slice(0, 8), slice(col, col + 1)))
    store.cells[:], store.walls[:] = 7, 7
    store.draw_again(np.array([0, 0]))
    store.own(0, touching(store, slice(3, 4), slice(5, 9)))
    tiles = store.tables[0, 3, 5:9]
    assert store.tiles_used == 4
    assert not store.cells[tiles].any()
    assert not store.walls[tiles].any()


def test_memory_does_not_grow_while_as_much_is_drawn_again_as_is_written() -> None:
    store, rng = TileStore(PARTICLES), np.random.default_rng(5)
    sizes = []
    for _ in range(40):
        for particle in range(PARTICLES):
            store.own(particle, touching(store, slice(0, 20), slice(0, 20)))
        assert store.tiles_used == PARTICLES * 400
        sizes.append(len(store.cells))
        store.draw_again(np.sort(rng.integers(PARTICLES, size=PARTICLES)))
    assert sizes[-1] == sizes[2]
    assert sizes[-1] < 2 * PARTICLES * 400
    assert np.array_equal(uses(store), store.references)


def test_more_tiles_keep_what_the_old_ones_hold() -> None:
    store = TileStore(2)
    write(store, 0, 31, 31, 7)
    before = len(store.references)
    store.own(0, touching(store, slice(0, 31), slice(0, 31)))
    assert len(store.references) == len(store.cells) == len(store.walls) > before
    assert read(store, 0, 31, 31) == 7
    assert len(set(store.tables[0, :31, :31].ravel().tolist())) == 31 * 31


def test_tables_grow_to_every_side_and_keep_what_is_in_them() -> None:
    store = TileStore(2)
    write(store, 1, 3, 5, 7)
    row, col = store.first_row + 3 * TILE, store.first_col + 5 * TILE  # lowest cell of that tile
    for corner in ((-700, 0), (0, -900), (1200, 0), (0, 1500)):
        store.cover(min(corner[0], 0), min(corner[1], 0), max(corner[0], 0), max(corner[1], 0))
        rows, cols = store.tables.shape[1] * TILE, store.tables.shape[2] * TILE
        assert store.first_row <= corner[0] < store.first_row + rows
        assert store.first_col <= corner[1] < store.first_col + cols
        assert store.first_row % TILE == store.first_col % TILE == 0
        assert read(store, 1, (row - store.first_row) // TILE, (col - store.first_col) // TILE) == 7
        assert (store.tables != NO_TILE).sum() == 1


def test_tables_that_reach_far_enough_stay_as_they_are() -> None:
    store = TileStore(2)
    tables = store.tables
    far = store.first_row + store.tables.shape[1] * TILE - 1
    store.cover(store.first_row, store.first_col, far, far)
    assert store.tables is tables
    store.cover(store.first_row, store.first_col, far + 1, far)
    assert store.tables.shape[1] > tables.shape[1]
    assert store.tables.shape[2] == tables.shape[2]


@pytest.mark.parametrize(("row", "col"), [(0, MOST_CELLS + 1), (-MOST_CELLS - 1, 0), (10**9, -(10**9))])
def test_a_place_that_no_building_reaches_is_refused_and_nothing_grows(row: int, col: int) -> None:
    store = TileStore(2)
    tables, first = store.tables, (store.first_row, store.first_col)
    with pytest.raises(TwonavError, match="jump in the odometry") as caught:
        store.cover(min(row, 0), min(col, 0), max(row, 0), max(col, 0))
    assert "\n" not in str(caught.value)
    assert store.tables is tables
    assert (store.first_row, store.first_col) == first


def test_the_map_of_a_particle_is_what_it_wrote() -> None:
    store = TileStore(2)
    write(store, 1, 3, 5, 7)
    grid = store.map_of(1)
    assert grid.table[3, 5] != NO_TILE
    assert (grid.cells[grid.table[3, 5], :, HITS] == 7).all()
    assert (store.map_of(0).table == NO_TILE).all()
    assert (grid.first_row, grid.first_col) == (store.first_row, store.first_col)
    assert store.size_bytes >= store.cells.nbytes + store.tables.nbytes
