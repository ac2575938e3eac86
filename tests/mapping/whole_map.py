"""The map of one particle as one array, for tests that look at single cells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.mapping.cells import HITS, MEAN_STEPS, MEAN_X, MEAN_Y, NO_TILE, TILE, VISITS, TileStore


class WholeMap:
    """What a particle's map holds; asked by cell row and column as the store counts them, negative ones too."""

    def __init__(self, store: TileStore, particle: int = 0) -> None:
        rows, cols = store.tables[particle].shape
        fields = np.zeros((rows * TILE, cols * TILE, 4), dtype=np.int64)
        walls = np.zeros((rows * TILE, cols * TILE), dtype=np.bool_)
        for row, col in np.argwhere(store.tables[particle] != NO_TILE).tolist():
            tile = store.tables[particle, row, col]
            place = slice(row * TILE, (row + 1) * TILE), slice(col * TILE, (col + 1) * TILE)
            fields[place] = store.cells[tile].reshape(TILE, TILE, 4)
            walls[place] = [[int(word) >> bit & 1 for bit in range(TILE)] for word in store.walls[tile]]
        self.walls: NDArray[np.bool_] = walls
        self.hits: NDArray[np.int64] = fields[..., HITS]
        self.visits: NDArray[np.int64] = fields[..., VISITS]
        self._means = fields[..., [MEAN_X, MEAN_Y]] / MEAN_STEPS
        self._first = store.first_row, store.first_col

    def counts(self, row: int, col: int) -> tuple[int, int]:
        """Return hits and visits of a cell."""
        at = row - self._first[0], col - self._first[1]
        return int(self.hits[at]), int(self.visits[at])

    def mean(self, row: int, col: int) -> tuple[float, float]:
        """Return the mean (x, y) of the points that ended in a cell, cells."""
        x, y = self._means[row - self._first[0], col - self._first[1]].tolist()
        return col + x, row + y

    def wall_cells(self) -> list[tuple[int, int]]:
        """Return (row, col) of every cell that is a wall."""
        return [(row + self._first[0], col + self._first[1]) for row, col in np.argwhere(self.walls).tolist()]
