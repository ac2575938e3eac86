"""The occupancy map of one particle, from its tiles."""

from __future__ import annotations

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.cell_units import CellUnits
from twonav_cli.mapping.cells import (
    HIT_LOG_ODDS,
    HITS,
    MEAN_STEPS,
    MEAN_X,
    MEAN_Y,
    MISS_LOG_ODDS,
    NO_TILE,
    TILE,
    VISITS,
    TileStore,
)
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap


def drawn(store: TileStore, particle: int, units: CellUnits, frame: GridFrame | None) -> OccupancyMap:
    """Return the map of a particle: occupied where the log-odds are positive, unknown where no beam came.

    Args:
        store: Tiles of all particles.
        particle: Which one.
        units: Where its cells lie.
        frame: What part; None takes what was seen.

    Raises:
        TwonavError: The frame's cells do not lie on the store's.
    """
    odds, visited = _all_cells(store, particle)
    if frame is None:
        rows, cols = np.flatnonzero(visited.any(axis=1)), np.flatnonzero(visited.any(axis=0))
        low_row, high_row = (int(rows[0]), int(rows[-1]) + 1) if len(rows) else (0, 1)
        low_col, high_col = (int(cols[0]), int(cols[-1]) + 1) if len(cols) else (0, 1)
        frame = GridFrame(
            units.corner[0] + (store.first_col + low_col) * units.resolution_m,
            units.corner[1] + (store.first_row + low_row) * units.resolution_m,
            units.resolution_m, high_row - low_row, high_col - low_col,
        )  # fmt: skip
    else:
        low_row, low_col = _corner_cell(frame, units)
        low_row, low_col = low_row - store.first_row, low_col - store.first_col
    pixels = np.full(frame.shape, UNKNOWN, dtype=np.uint8)
    top, left = max(0, low_row), max(0, low_col)
    bottom, right = min(odds.shape[0], low_row + frame.rows), min(odds.shape[1], low_col + frame.cols)
    if top < bottom and left < right:
        seen = visited[top:bottom, left:right]
        values = np.where(odds[top:bottom, left:right] > 0, OCCUPIED, FREE)
        part = pixels[top - low_row : bottom - low_row, left - low_col : right - low_col]
        part[seen] = values[seen]
    return OccupancyMap(frame, np.ascontiguousarray(pixels[::-1]))


def wall_points(store: TileStore, particle: int, units: CellUnits) -> FloatArray:
    """Return the mean point [K, 2] of the hits in every occupied cell of a particle's map, metres."""
    found = []
    table = store.tables[particle]
    for row, col in np.argwhere(table != NO_TILE).tolist():
        tile = table[row, col]
        bits = (store.walls[tile][:, None] >> np.arange(TILE, dtype=np.uint32)) & 1  # [TILE, TILE]
        rows, cols = np.nonzero(bits)
        mean = store.cells[tile].reshape(TILE, TILE, 4)[rows, cols][:, [MEAN_X, MEAN_Y]] / MEAN_STEPS
        found.append(
            mean + np.stack([cols + col * TILE + store.first_col, rows + row * TILE + store.first_row], axis=1)
        )
    points = np.concatenate(found) if found else np.zeros((0, 2))
    return np.asarray(points * units.resolution_m + units.corner, dtype=np.float64)


def _corner_cell(frame: GridFrame, units: CellUnits) -> tuple[int, int]:
    """Return the cell (row, col) at the lower left corner of a frame.

    Raises:
        TwonavError: Its cells do not lie on those of the map.
    """
    col, row, _ = units.of_pose(Pose(frame.x_min_m, frame.y_min_m, 0.0)).tolist()
    off = max(abs(row - round(row)), abs(col - round(col)))
    if abs(frame.resolution_m - units.resolution_m) > 1e-9 or off > 1e-6:
        raise TwonavError(f"the map's cells of {units.resolution_m} m do not lie on the frame asked for: map it again")
    return round(row), round(col)


def _all_cells(store: TileStore, particle: int) -> tuple[FloatArray, np.ndarray[tuple[int, int], np.dtype[np.bool_]]]:
    """Return log-odds and whether a beam came [TR * TILE, TC * TILE], the lowest row first."""
    table = store.tables[particle]
    rows, cols = table.shape
    odds = np.zeros((rows, TILE, cols, TILE), dtype=np.float64)
    visited = np.zeros((rows, TILE, cols, TILE), dtype=np.bool_)
    for row, col in np.argwhere(table != NO_TILE).tolist():
        cells = store.cells[table[row, col]].reshape(TILE, TILE, 4).astype(np.int64)
        misses = cells[..., VISITS] - cells[..., HITS]
        odds[row, :, col] = HIT_LOG_ODDS * cells[..., HITS] + MISS_LOG_ODDS * misses
        visited[row, :, col] = cells[..., VISITS] > 0
    return odds.reshape(rows * TILE, cols * TILE), visited.reshape(rows * TILE, cols * TILE)
