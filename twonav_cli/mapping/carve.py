"""Putting a scan into a map: every beam is counted in the cells it goes through and in the one where it ends.

Positions are in cells, rows grow with y; N beams, TR and TC rows and columns of tiles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled, inlined
from twonav_cli.mapping.cells import (
    HIT_LOG_ODDS,
    HITS,
    MEAN_STEPS,
    MEAN_X,
    MEAN_Y,
    MISS_LOG_ODDS,
    NO_TILE,
    TILE,
    TILE_BITS,
    TILE_MASK,
    VISITS,
    Cells,
    Table,
    TileStore,
    Walls,
)

COUNT_LIMIT = 30_000
"""Counts are halved when visits come this far: they are 16 bits wide."""

Floats = NDArray[np.float64]


def carve_scan(store: TileStore, particle: int, sensor: Floats, points: Floats, hits: int | None = None) -> None:
    """Put a scan into the map of one particle.

    Args:
        store: Maps of all particles.
        particle: Which one.
        sensor: [3] pose of the range finder: x and y in cells, theta.
        points: [N, 2] ends of the beams in the sensor's frame, cells.
        hits: How many beams, the first ones, hit something at their end; default: all.

    Raises:
        TwonavError: The map would be larger than any building.
    """
    ends = np.empty_like(points)  # [N, 2] (row, col)
    low_row, low_col, high_row, high_col = _place_ends(sensor, points, ends)
    store.cover(low_row - TILE, low_col - TILE, high_row + TILE, high_col + TILE)
    table, first_row, first_col = store.tables[particle], store.first_row, store.first_col
    touched = np.zeros(table.shape, dtype=np.bool_)
    _touch(touched, sensor[1] - first_row, sensor[0] - first_col, ends, first_row, first_col)
    store.own(particle, touched)
    _carve(
        store.cells, store.walls, store.references, store.tables[particle], sensor[1] - first_row,
        sensor[0] - first_col, ends, first_row, first_col, len(points) if hits is None else hits,
    )  # fmt: skip


@compiled
def _place_ends(sensor: Floats, points: Floats, ends: Floats) -> tuple[int, int, int, int]:
    """Write the (row, col) [N, 2] of every end, and return the lowest and highest row and column of all."""
    cos, sin = np.cos(sensor[2]), np.sin(sensor[2])
    low_row = high_row = sensor[1]
    low_col = high_col = sensor[0]
    for i in range(len(points)):
        ends[i, 0] = sensor[1] + sin * points[i, 0] + cos * points[i, 1]
        ends[i, 1] = sensor[0] + cos * points[i, 0] - sin * points[i, 1]
        low_row, high_row = min(low_row, ends[i, 0]), max(high_row, ends[i, 0])
        low_col, high_col = min(low_col, ends[i, 1]), max(high_col, ends[i, 1])
    return int(low_row), int(low_col), int(high_row), int(high_col)


@compiled
def _touch(
    touched: NDArray[np.bool_], from_row: float, from_col: float, ends: Floats, first_row: int, first_col: int
) -> None:
    """Mark the tiles [TR, TC] that the beams go through (exact traversal, Amanatides and Woo 1987)."""
    for beam in range(len(ends)):
        at_row, at_col = from_row / TILE, from_col / TILE
        rows, cols = (ends[beam, 0] - first_row) / TILE - at_row, (ends[beam, 1] - first_col) / TILE - at_col
        row, col = int(at_row), int(at_col)
        last_row, last_col = int(at_row + rows), int(at_col + cols)
        up, right = (1 if rows > 0 else -1), (1 if cols > 0 else -1)
        per_row, next_row = _pace(rows, at_row, row)
        per_col, next_col = _pace(cols, at_col, col)
        touched[row, col] = True
        for _ in range(abs(last_row - row) + abs(last_col - col)):
            if next_row < next_col:
                row += up
                next_row += per_row
            else:
                col += right
                next_col += per_col
            touched[row, col] = True
        # Rounding may end a corner away from where the fine traversal goes.
        touched[last_row, last_col] = True


@inlined
def _pace(span: float, at: float, cell: int) -> tuple[float, float]:
    """Return the share of a beam from one border of cells to the next, and up to the first one."""
    if span == 0.0:
        return np.inf, np.inf
    per = abs(1.0 / span)
    return per, ((cell + 1 - at) if span > 0 else (at - cell)) * per


@compiled
def _carve(
    cells: Cells, walls: Walls, references: Table, table: Table, from_row: float, from_col: float, ends: Floats,
    first_row: int, first_col: int, hits: int,
) -> None:  # fmt: skip
    """Count every beam on its way (exact traversal, Amanatides and Woo 1987), and the hits where they end.

    Rounding can lead a beam around a corner of tiles on the side that was not touched: what is missing there, or
    belongs to others too, is passed over.
    """
    for beam in range(len(ends)):
        end_row, end_col = ends[beam, 0] - first_row, ends[beam, 1] - first_col
        rows, cols = end_row - from_row, end_col - from_col
        row, col = int(from_row), int(from_col)
        last_row, last_col = int(end_row), int(end_col)
        up, right = (1 if rows > 0 else -1), (1 if cols > 0 else -1)
        per_row, next_row = _pace(rows, from_row, row)
        per_col, next_col = _pace(cols, from_col, col)
        down, aside, tile = -1, -1, NO_TILE
        for _ in range(abs(last_row - row) + abs(last_col - col)):
            if row >> TILE_BITS != down or col >> TILE_BITS != aside:
                down, aside = row >> TILE_BITS, col >> TILE_BITS
                tile = table[down, aside]
                if tile >= 0 and references[tile] > 1:
                    tile = NO_TILE
            if tile >= 0:
                _count_visit(cells, walls, tile, row & TILE_MASK, col & TILE_MASK)
            if next_row < next_col:
                row += up
                next_row += per_row
            else:
                col += right
                next_col += per_col
        if beam < hits:
            _count_hit(cells, walls, table[last_row >> TILE_BITS, last_col >> TILE_BITS], end_row, end_col)


@inlined
def _count_visit(cells: Cells, walls: Walls, tile: int, row: int, col: int) -> None:
    """Count a beam that went through a cell."""
    at = (row << TILE_BITS) | col
    visits = cells[tile, at, VISITS] + 1
    hits = cells[tile, at, HITS]
    if visits >= COUNT_LIMIT:
        visits >>= 1
        hits >>= 1
        cells[tile, at, HITS] = hits
    cells[tile, at, VISITS] = visits
    if hits > 0:
        _mark_wall(walls, tile, row, col, hits, visits)


@inlined
def _count_hit(cells: Cells, walls: Walls, tile: int, at_row: float, at_col: float) -> None:
    """Count a beam that ended in a cell, and move the mean of the points that did."""
    row, col = int(at_row), int(at_col)
    at = ((row & TILE_MASK) << TILE_BITS) | (col & TILE_MASK)
    visits, hits = cells[tile, at, VISITS] + 1, cells[tile, at, HITS] + 1
    if visits >= COUNT_LIMIT:
        visits >>= 1
        hits = max(1, hits >> 1)
    x, y = (at_col - col) * MEAN_STEPS, (at_row - row) * MEAN_STEPS
    cells[tile, at, MEAN_X] += int(np.rint((x - cells[tile, at, MEAN_X]) / hits))
    cells[tile, at, MEAN_Y] += int(np.rint((y - cells[tile, at, MEAN_Y]) / hits))
    cells[tile, at, HITS], cells[tile, at, VISITS] = hits, visits
    _mark_wall(walls, tile, row & TILE_MASK, col & TILE_MASK, hits, visits)


@inlined
def _mark_wall(walls: Walls, tile: int, row: int, col: int, hits: int, visits: int) -> None:
    """Set a cell's bit when its log-odds are positive, the sum over all beams."""
    word = np.int64(walls[tile, row])
    if HIT_LOG_ODDS * hits + MISS_LOG_ODDS * (visits - hits) > 0.0:
        word |= 1 << col
    else:
        word &= ~(1 << col)
    walls[tile, row] = np.uint32(word)
