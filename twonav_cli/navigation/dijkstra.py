"""Shortest paths over free cells: SciPy's Dijkstra on the graph of the eight neighbours.

N cells of the grid, in row order. A diagonal step costs the square root of two and needs both cells beside it free.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell

if TYPE_CHECKING:
    from scipy.sparse import csr_matrix


def free_for_radius(occupied: NDArray[np.bool_], resolution_m: float, radius_m: float) -> NDArray[np.bool_]:
    """Return where [rows, cols] the centre of a robot of some radius can be."""
    from twonav_cli.navigation.distance import distances_m

    return np.asarray(distances_m(occupied, resolution_m) > radius_m + 0.5 * resolution_m)


def _slices(offset: int) -> tuple[slice, slice]:
    """Return where a step by `offset` along an axis starts and where it ends."""
    if offset == 0:
        return slice(None), slice(None)
    return (slice(None, -1), slice(1, None)) if offset > 0 else (slice(1, None), slice(None, -1))


def _graph_of(free: NDArray[np.bool_]) -> csr_matrix:
    """Return the graph [N, N] of the steps between free cells; each step once, to be read as undirected."""
    from scipy.sparse import csr_matrix

    numbers = np.arange(free.size).reshape(free.shape)
    sources, ends, lengths = [], [], []
    for d_row, d_col in ((0, 1), (1, 0), (1, 1), (1, -1)):
        (row_a, row_b), (col_a, col_b) = _slices(d_row), _slices(d_col)
        open_ = free[row_a, col_a] & free[row_b, col_b]
        if d_row and d_col:
            open_ = open_ & free[row_a, col_b] & free[row_b, col_a]
        sources.append(numbers[row_a, col_a][open_])
        ends.append(numbers[row_b, col_b][open_])
        lengths.append(np.full(sources[-1].size, np.hypot(d_row, d_col)))
    edges = (np.concatenate(lengths), (np.concatenate(sources), np.concatenate(ends)))
    return csr_matrix(edges, shape=(free.size, free.size))


class FreeSpace:
    """The graph of a grid's free cells, built once."""

    def __init__(self, free: NDArray[np.bool_]) -> None:
        self.free = np.asarray(free, dtype=np.bool_)
        self._graph = _graph_of(self.free)

    def _check(self, cell: Cell) -> int:
        rows, cols = self.free.shape
        if not (0 <= cell.row < rows and 0 <= cell.col < cols and self.free[cell]):
            raise TwonavError(f"cell {tuple(cell)} is not free: choose a free one")
        return int(cell.row * cols + cell.col)

    def distances(self, start: Cell) -> NDArray[np.float64]:
        """Return the length [rows, cols], in cells, of the shortest path from `start`; inf where there is none.

        Raises:
            TwonavError: `start` is not free.
        """
        from scipy.sparse.csgraph import dijkstra

        lengths = dijkstra(self._graph, directed=False, indices=self._check(start))
        return np.asarray(lengths, dtype=np.float64).reshape(self.free.shape)

    def path(self, start: Cell, goal: Cell) -> list[Cell]:
        """Return the cells of a shortest path, both ends among them.

        Raises:
            TwonavError: An end is not free, or no path joins them.
        """
        from scipy.sparse.csgraph import dijkstra

        first, last = self._check(start), self._check(goal)
        lengths, before = dijkstra(self._graph, directed=False, indices=first, return_predecessors=True)
        if not np.isfinite(lengths[last]):
            raise TwonavError(f"no path joins cells {tuple(start)} and {tuple(goal)}: choose another goal")
        cells = [last]
        while cells[-1] != first:
            cells.append(int(before[cells[-1]]))
        return [Cell(*divmod(cell, self.free.shape[1])) for cell in reversed(cells)]


def path(free: NDArray[np.bool_], start: Cell, goal: Cell) -> list[Cell]:
    """Return a shortest path over the free cells [rows, cols]; `FreeSpace.path` for more than one."""
    return FreeSpace(free).path(start, goal)


def distances(free: NDArray[np.bool_], start: Cell) -> NDArray[np.float64]:
    """Return the length [rows, cols], in cells, of the shortest paths from `start`; inf where there is none."""
    return FreeSpace(free).distances(start)
