"""Shortest paths over free cells: SciPy's Dijkstra on the graph of the eight neighbours.

N cells of the grid, in row order. A diagonal step costs the square root of two and needs both cells beside it free.
"""

from __future__ import annotations

from dataclasses import dataclass
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


def _graph_of(free: NDArray[np.bool_], weight: NDArray[np.float64] | None) -> csr_matrix:
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
        if weight is not None:
            lengths[-1] *= 0.5 * (weight[row_a, col_a][open_] + weight[row_b, col_b][open_])
    edges = (np.concatenate(lengths), (np.concatenate(sources), np.concatenate(ends)))
    return csr_matrix(edges, shape=(free.size, free.size))


@dataclass(frozen=True)
class PathTree:
    """The shortest paths from one cell to every other.

    Attributes:
        lengths: [rows, cols] in cells, times the weights on the way; inf where no path leads.
        before: [N] number of the cell before each one on its path.
        start: Where the paths begin.
    """

    lengths: NDArray[np.float64]
    before: NDArray[np.int32]
    start: Cell

    def path_to(self, goal: Cell) -> list[Cell]:
        """Return the cells of the path to a cell, both ends among them.

        Raises:
            TwonavError: No path leads there.
        """
        if not np.isfinite(self.lengths[goal]):
            raise TwonavError(f"no path joins cells {tuple(self.start)} and {tuple(goal)}: choose another goal")
        cols = self.lengths.shape[1]
        cells = [goal]
        while cells[-1] != self.start:
            cells.append(Cell(*divmod(int(self.before[cells[-1].row * cols + cells[-1].col]), cols)))
        return cells[::-1]


class FreeSpace:
    """The graph of a grid's free cells, built once.

    Args:
        free: [rows, cols] cells that may be entered.
        weight: [rows, cols] what a step costs there, as a factor on its length; default: 1 everywhere.
    """

    def __init__(self, free: NDArray[np.bool_], weight: NDArray[np.float64] | None = None) -> None:
        self.free = np.asarray(free, dtype=np.bool_)
        self._graph = _graph_of(self.free, weight)

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

    def tree(self, start: Cell, limit: float = np.inf) -> PathTree:
        """Return the shortest paths from a cell to every other.

        Args:
            start: Where they begin.
            limit: Cells further away than this, in cells, count as not reached.

        Raises:
            TwonavError: `start` is not free.
        """
        from scipy.sparse.csgraph import dijkstra

        first = self._check(start)
        lengths, before = dijkstra(self._graph, directed=False, indices=first, return_predecessors=True, limit=limit)
        return PathTree(np.asarray(lengths, dtype=np.float64).reshape(self.free.shape), before, start)

    def path(self, start: Cell, goal: Cell) -> list[Cell]:
        """Return the cells of a shortest path, both ends among them.

        Raises:
            TwonavError: An end is not free, or no path joins them.
        """
        self._check(goal)
        return self.tree(start).path_to(goal)


def path(free: NDArray[np.bool_], start: Cell, goal: Cell) -> list[Cell]:
    """Return a shortest path over the free cells [rows, cols]; `FreeSpace.path` for more than one."""
    return FreeSpace(free).path(start, goal)


def distances(free: NDArray[np.bool_], start: Cell) -> NDArray[np.float64]:
    """Return the length [rows, cols], in cells, of the shortest paths from `start`; inf where there is none."""
    return FreeSpace(free).distances(start)
