"""The maps of all particles in one store: tiles of cells that particles share until one of them writes (copy on write).

A cell counts how often a beam ended in it and how often one came through or ended, and keeps the mean of the points
that ended in it, so that scans are matched to better than a cell. Eight bytes a cell,
and one bit: whether it is a wall.

T tiles, P particles, TR and TC rows and columns of tiles. Rows grow upwards here, with y: the first row is the lowest.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.errors import TwonavError

TILE_BITS = 5
TILE = 1 << TILE_BITS
"""Edge of a tile, cells (ours: 1.6 m at 5 cm). A row of a tile is one word of the walls' bits."""

TILE_MASK = TILE - 1
NO_TILE = -1

HITS, VISITS, MEAN_X, MEAN_Y = 0, 1, 2, 3
"""Fields of a cell; a mean is in 1/MEAN_STEPS of a cell's edge, from its lower left corner."""

MEAN_STEPS = 16384

HIT_LOG_ODDS = 0.9
MISS_LOG_ODDS = -0.3
"""Log-odds of one beam that ends in a cell, and of one that goes through (ours): a quarter of hits is even."""

FIRST_TILES = 256
FIRST_EDGE = 32
"""Tiles and edge of the tables at the start; they grow when they are full."""

MARGIN = FIRST_EDGE // 2
"""Tiles that a table grows by beyond what is needed, so that the next few metres find room."""

MOST_CELLS = 20_000
"""Edge of the largest map (ours: a kilometre at 5 cm)."""

Cells = NDArray[np.int16]
Table = NDArray[np.int32]
Walls = NDArray[np.uint32]


class CellMap(NamedTuple):
    """The map of one particle as the compiled loops take it."""

    cells: Cells
    """[T, TILE * TILE, 4]"""
    walls: Walls
    """[T, TILE]"""
    table: Table
    """[TR, TC]"""
    first_row: int
    """Cell row at which the table begins."""
    first_col: int
    """Cell column at which the table begins."""


class TileStore:
    """Cells of all particles.

    Attributes:
        cells: [T, TILE * TILE, 4] int16.
        walls: [T, TILE] one bit for each cell of a row that is occupied.
        references: [T] particles that use a tile.
        tables: [P, TR, TC] tile of each place, NO_TILE where nothing was seen yet.
        first_row, first_col: Cell row and column at which the tables begin.
    """

    def __init__(self, particles: int) -> None:
        self.cells: Cells = np.zeros((FIRST_TILES, TILE * TILE, 4), dtype=np.int16)
        self.walls: Walls = np.zeros((FIRST_TILES, TILE), dtype=np.uint32)
        self.references: Table = np.zeros(FIRST_TILES, dtype=np.int32)
        self.tables: Table = np.full((particles, FIRST_EDGE, FIRST_EDGE), NO_TILE, dtype=np.int32)
        self.first_row = self.first_col = -FIRST_EDGE // 2 * TILE
        self._unused: NDArray[np.int64] = np.arange(FIRST_TILES)

    @property
    def tiles_used(self) -> int:
        """Tiles that some particle uses."""
        return len(self.references) - len(self._unused)

    @property
    def size_bytes(self) -> int:
        """Bytes of everything that is kept."""
        return sum(part.nbytes for part in (self.cells, self.walls, self.references, self.tables, self._unused))

    def map_of(self, particle: int) -> CellMap:
        """Return the map of one particle; a view, good until a tile or table is added."""
        return CellMap(self.cells, self.walls, self.tables[particle], self.first_row, self.first_col)

    def cover(self, low_row: int, low_col: int, high_row: int, high_col: int) -> None:
        """Make the tables large enough for the cells from one corner to the other, both included.

        Raises:
            TwonavError: They would be larger than any building.
        """
        rows, cols = self.tables.shape[1] * TILE, self.tables.shape[2] * TILE
        below, left = -(-(self.first_row - low_row) // TILE), -(-(self.first_col - low_col) // TILE)
        above = (high_row - self.first_row - rows) // TILE + 1
        right = (high_col - self.first_col - cols) // TILE + 1
        if max(below, left, above, right) <= 0:
            return
        across = max(rows + (max(below, 0) + max(above, 0)) * TILE, cols + (max(left, 0) + max(right, 0)) * TILE)
        if across > MOST_CELLS:
            raise TwonavError(
                f"the map would be {across:,} cells wide: look for a jump in the odometry, or take larger cells"
            )
        below, above, left, right = (n + MARGIN if n > 0 else 0 for n in (below, above, left, right))
        self.tables = np.pad(self.tables, ((0, 0), (below, above), (left, right)), constant_values=NO_TILE)
        self.first_row -= below * TILE
        self.first_col -= left * TILE

    def own(self, particle: int, touched: NDArray[np.bool_]) -> None:
        """Make every touched tile [TR, TC] one that only this particle uses: new, or a copy of the shared one."""
        table = self.tables[particle]
        wanted = int((touched & ((table == NO_TILE) | (self.references[table] > 1))).sum())
        if wanted == 0:
            return
        if len(self._unused) < wanted:
            self._enlarge(wanted)
        fresh, self._unused = self._unused[:wanted], self._unused[wanted:]
        _give_own(self.cells, self.walls, self.references, table, touched, fresh)

    def draw_again(self, parents: NDArray[np.int64]) -> None:
        """Let particle i go on with the map of particle `parents[i]`; the maps are shared from here on."""
        self.tables = self.tables[parents]
        used = np.bincount(self.tables[self.tables != NO_TILE], minlength=len(self.references)).astype(np.int32)
        given_back = np.flatnonzero((used == 0) & (self.references > 0))
        self._unused = np.concatenate([self._unused, given_back])
        self.references = used

    def _enlarge(self, wanted: int) -> None:
        old = len(self.references)
        more = max(old // 4, wanted)
        self.cells = np.concatenate([self.cells, np.zeros((more, TILE * TILE, 4), dtype=np.int16)])
        self.walls = np.concatenate([self.walls, np.zeros((more, TILE), dtype=np.uint32)])
        self.references = np.concatenate([self.references, np.zeros(more, dtype=np.int32)])
        self._unused = np.concatenate([self._unused, np.arange(old, old + more)])


@compiled
def _give_own(
    cells: Cells, walls: Walls, references: Table, table: Table, touched: NDArray[np.bool_], fresh: NDArray[np.int64]
) -> None:
    """Put fresh tiles where a touched one is missing or shared, with what the shared one holds."""
    taken = 0
    for row in range(table.shape[0]):
        for col in range(table.shape[1]):
            old = table[row, col]
            if not touched[row, col] or (old != NO_TILE and references[old] <= 1):
                continue
            new = fresh[taken]
            taken += 1
            for at in range(TILE * TILE):
                for field in range(4):
                    cells[new, at, field] = 0 if old == NO_TILE else cells[old, at, field]
            for at in range(TILE):
                walls[new, at] = 0 if old == NO_TILE else walls[old, at]
            if old != NO_TILE:
                references[old] -= 1
            references[new] = 1
            table[row, col] = new
