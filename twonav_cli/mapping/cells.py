"""The maps of all particles in one store: tiles of cells that particles share until one of them writes (copy on write).

A cell counts how often a beam ended in it and how often one came through or ended, and keeps the mean of the points
that ended in it, so that scans are matched to better than a cell. Eight bytes a cell.

T tiles, P particles, TR and TC rows and columns of tiles. Rows grow upwards here, with y: the first row is the lowest.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled, inlined

TILE_BITS = 5
TILE = 1 << TILE_BITS
"""Edge of a tile, cells (ours: 1.6 m at 5 cm)."""

TILE_MASK = TILE - 1
NO_TILE = -1

HITS, VISITS, MEAN_X, MEAN_Y = 0, 1, 2, 3
"""Fields of a cell; a mean is in 1/MEAN_STEPS of a cell's edge, from its lower left corner."""

MEAN_STEPS = 16384
COUNT_LIMIT = 30_000
"""Counts are halved when visits come this far: they are 16 bits wide."""

HIT_LOG_ODDS = 0.9
MISS_LOG_ODDS = -0.3
"""Log-odds of one beam that ends in a cell, and of one that goes through (ours): a quarter of hits is even."""

FIRST_TILES = 256
FIRST_EDGE = 32
"""Tiles and edge of the tables at the start; both double when they are full."""

Cells = NDArray[np.int16]
Tables = NDArray[np.int32]


class TileStore:
    """Cells of all particles.

    Attributes:
        cells: [T, TILE * TILE, 4] int16.
        references: [T] particles that use a tile.
        tables: [P, TR, TC] tile of each place, NO_TILE where nothing was seen yet.
        first_row, first_col: Cell row and column at which the tables begin.
    """

    def __init__(self, particles: int) -> None:
        self.cells: Cells = np.zeros((FIRST_TILES, TILE * TILE, 4), dtype=np.int16)
        self.references = np.zeros(FIRST_TILES, dtype=np.int32)
        self.tables: Tables = np.full((particles, FIRST_EDGE, FIRST_EDGE), NO_TILE, dtype=np.int32)
        self.first_row = self.first_col = -FIRST_EDGE // 2 * TILE
        self._unused = list(range(FIRST_TILES - 1, -1, -1))

    @property
    def tiles_used(self) -> int:
        """Tiles that some particle uses."""
        return len(self.references) - len(self._unused)

    @property
    def size_bytes(self) -> int:
        """Bytes of cells and tables."""
        return self.cells.nbytes + self.references.nbytes + self.tables.nbytes

    def cover(self, low_row: int, low_col: int, high_row: int, high_col: int) -> None:
        """Make the tables large enough for the cells from one corner to the other, both included."""
        edge_rows, edge_cols = self.tables.shape[1] * TILE, self.tables.shape[2] * TILE
        below = max(0, -(-(self.first_row - low_row) // TILE))
        left = max(0, -(-(self.first_col - low_col) // TILE))
        above = max(0, (high_row - self.first_row - edge_rows) // TILE + 1)
        right = max(0, (high_col - self.first_col - edge_cols) // TILE + 1)
        if not (below or left or above or right):
            return
        margin = FIRST_EDGE // 2  # so that the next few metres find room
        sides = [(n and n + margin) for n in (below, above, left, right)]
        pads = ((0, 0), (sides[0], sides[1]), (sides[2], sides[3]))
        self.tables = np.pad(self.tables, pads, constant_values=NO_TILE)
        self.first_row -= sides[0] * TILE
        self.first_col -= sides[2] * TILE

    def own(self, particle: int, touched: NDArray[np.bool_]) -> None:
        """Make every touched tile [TR, TC] one that only this particle uses: new, or a copy of the shared one."""
        table, references = self.tables[particle], self.references
        at = np.argwhere(touched & ((table == NO_TILE) | (references[table] > 1)))
        if len(self._unused) < len(at):
            self._enlarge(len(at))
            references = self.references
        for row, col in at.tolist():
            old, new = int(table[row, col]), self._unused.pop()
            if old == NO_TILE:
                self.cells[new] = 0
            else:
                self.cells[new] = self.cells[old]
                references[old] -= 1
            references[new] = 1
            table[row, col] = new

    def draw_again(self, parents: NDArray[np.int64]) -> None:
        """Let particle i go on with the map of particle `parents[i]`; the maps are shared from here on."""
        tables = self.tables[parents]
        used = np.bincount(tables[tables != NO_TILE], minlength=len(self.references)).astype(np.int32)
        self._unused += np.flatnonzero((used == 0) & (self.references > 0)).tolist()
        self.references, self.tables = used, tables

    def _enlarge(self, wanted: int) -> None:
        old = len(self.references)
        more = max(old // 2, wanted)
        self.cells = np.concatenate([self.cells, np.zeros((more, TILE * TILE, 4), dtype=np.int16)])
        self.references = np.concatenate([self.references, np.zeros(more, dtype=np.int32)])
        self._unused += range(old + more - 1, old - 1, -1)


@inlined
def log_odds(hits: int, visits: int) -> float:
    """Return the log-odds that a cell is occupied from its counts, the sum over all beams."""
    return HIT_LOG_ODDS * hits + MISS_LOG_ODDS * (visits - hits)


@compiled
def touch(
    touched: NDArray[np.bool_], first_row: int, first_col: int, from_row: float, from_col: float,
    ends: NDArray[np.float64],
) -> None:  # fmt: skip
    """Mark the tiles [TR, TC] that the beams go through; positions are in cells.

    Args:
        touched: Written.
        first_row: Cell row at which the tables begin.
        first_col: Cell column at which the tables begin.
        from_row: Where the sensor is.
        from_col: Where the sensor is.
        ends: [N, 2] (row, col) where the beams end.
    """
    for beam in range(len(ends)):
        rows, cols = ends[beam, 0] - from_row, ends[beam, 1] - from_col
        steps = int(max(abs(rows), abs(cols)) / (TILE / 4)) + 1
        for step in range(steps + 1):
            share = step / steps
            row = int(np.floor(from_row + share * rows)) - first_row
            col = int(np.floor(from_col + share * cols)) - first_col
            # Samples lie a quarter of a tile apart: a corner that is cut is within that of one of them.
            for down in range(-1, 2):
                for aside in range(-1, 2):
                    touched[(row + down * (TILE // 4)) >> TILE_BITS, (col + aside * (TILE // 4)) >> TILE_BITS] = True


@compiled
def carve(
    cells: Cells, table: NDArray[np.int32], first_row: int, first_col: int, from_row: float, from_col: float,
    ends: NDArray[np.float64],
) -> None:  # fmt: skip
    """Count every beam in the cells it goes through, and where it ends (exact traversal, Amanatides and Woo 1987).

    Every tile on the way must be there and be the particle's own.

    Args:
        cells: [T, TILE * TILE, 4] written.
        table: [TR, TC] of one particle.
        first_row: Cell row at which the tables begin.
        first_col: Cell column at which the tables begin.
        from_row: Where the sensor is, in cells.
        from_col: Where the sensor is, in cells.
        ends: [N, 2] (row, col) where the beams end, in cells.
    """
    for beam in range(len(ends)):
        end_row, end_col = ends[beam, 0] - first_row, ends[beam, 1] - first_col
        at_row, at_col = from_row - first_row, from_col - first_col
        row, col = int(at_row), int(at_col)
        last_row, last_col = int(end_row), int(end_col)
        rows, cols = end_row - at_row, end_col - at_col
        up, right = (1 if rows > 0 else -1), (1 if cols > 0 else -1)
        per_row = abs(1.0 / rows) if rows != 0.0 else np.inf
        per_col = abs(1.0 / cols) if cols != 0.0 else np.inf
        next_row = ((row + 1 - at_row) if rows > 0 else (at_row - row)) * per_row if rows != 0.0 else np.inf
        next_col = ((col + 1 - at_col) if cols > 0 else (at_col - col)) * per_col if cols != 0.0 else np.inf
        for _ in range(abs(last_row - row) + abs(last_col - col)):
            count_visit(cells, table[row >> TILE_BITS, col >> TILE_BITS], row, col)
            if next_row < next_col:
                row += up
                next_row += per_row
            else:
                col += right
                next_col += per_col
        count_hit(cells, table[last_row >> TILE_BITS, last_col >> TILE_BITS], end_row, end_col)


@inlined
def count_visit(cells: Cells, tile: int, row: int, col: int) -> None:
    """Count a beam that went through a cell."""
    at = ((row & TILE_MASK) << TILE_BITS) | (col & TILE_MASK)
    if cells[tile, at, VISITS] >= COUNT_LIMIT:
        cells[tile, at, VISITS] >>= 1
        cells[tile, at, HITS] >>= 1
    cells[tile, at, VISITS] += 1


@inlined
def count_hit(cells: Cells, tile: int, at_row: float, at_col: float) -> None:
    """Count a beam that ended in a cell, and move the mean of the points that did."""
    row, col = int(at_row), int(at_col)
    count_visit(cells, tile, row, col)
    at = ((row & TILE_MASK) << TILE_BITS) | (col & TILE_MASK)
    cells[tile, at, HITS] += 1
    hits = cells[tile, at, HITS]
    x, y = (at_col - col) * MEAN_STEPS, (at_row - row) * MEAN_STEPS
    cells[tile, at, MEAN_X] += int(round((x - cells[tile, at, MEAN_X]) / hits))
    cells[tile, at, MEAN_Y] += int(round((y - cells[tile, at, MEAN_Y]) / hits))
