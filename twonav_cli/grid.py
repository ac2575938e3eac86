"""The one place that converts between metres and cells.

Arrays are [row, col]; row 0 is the top, where y is largest. A point on a border belongs to the cell to its right
or above it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError


class Cell(NamedTuple):
    """A cell of a grid: row 0 is the top, column 0 the left."""

    row: int
    col: int


@dataclass(frozen=True)
class GridFrame:
    """Where a grid lies in the map frame.

    Attributes:
        x_min_m: Left border of column 0.
        y_min_m: Lower border of the last row.
        resolution_m: Edge of a cell.
        rows: Number of rows.
        cols: Number of columns.
    """

    x_min_m: float
    y_min_m: float
    resolution_m: float
    rows: int
    cols: int

    def __post_init__(self) -> None:
        if self.resolution_m <= 0 or self.rows < 1 or self.cols < 1:
            raise TwonavError(f"a grid needs cells: {self.rows} x {self.cols} of {self.resolution_m} m was asked for")

    @property
    def x_max_m(self) -> float:
        """Right border of the last column."""
        return self.x_min_m + self.cols * self.resolution_m

    @property
    def y_max_m(self) -> float:
        """Upper border of row 0."""
        return self.y_min_m + self.rows * self.resolution_m

    @property
    def shape(self) -> tuple[int, int]:
        """(rows, cols)."""
        return self.rows, self.cols

    def contains(self, x_m: float, y_m: float) -> bool:
        """Whether a point lies on the grid."""
        return self.x_min_m <= x_m < self.x_max_m and self.y_min_m <= y_m < self.y_max_m

    def cell_at(self, x_m: float, y_m: float) -> Cell:
        """Return the cell that holds a point; points outside go to the nearest border cell."""
        col = math.floor((x_m - self.x_min_m) / self.resolution_m + 1e-9)
        up = math.floor((y_m - self.y_min_m) / self.resolution_m + 1e-9)
        return Cell(min(max(self.rows - 1 - up, 0), self.rows - 1), min(max(col, 0), self.cols - 1))

    def cells_at(
        self, x_m: NDArray[np.float64], y_m: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]:
        """Return row, column and whether it lies on the grid for many points of any shape: `cell_at` for arrays."""
        cols = np.floor((x_m - self.x_min_m) / self.resolution_m + 1e-9).astype(np.int64)
        rows = self.rows - 1 - np.floor((y_m - self.y_min_m) / self.resolution_m + 1e-9).astype(np.int64)
        inside = (rows >= 0) & (rows < self.rows) & (cols >= 0) & (cols < self.cols)
        return rows.clip(0, self.rows - 1), cols.clip(0, self.cols - 1), np.asarray(inside)

    def centre_of(self, cell: Cell) -> tuple[float, float]:
        """Return the centre (x_m, y_m) of a cell."""
        return (
            self.x_min_m + (cell.col + 0.5) * self.resolution_m,
            self.y_min_m + (self.rows - cell.row - 0.5) * self.resolution_m,
        )

    def centres(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the x of every column [cols] and the y of every row [rows], at the centres."""
        xs = self.x_min_m + (np.arange(self.cols) + 0.5) * self.resolution_m
        ys = self.y_min_m + (self.rows - np.arange(self.rows) - 0.5) * self.resolution_m
        return np.asarray(xs, dtype=np.float64), np.asarray(ys, dtype=np.float64)

    def coarser(self, resolution_m: float) -> GridFrame:
        """Return the grid of larger cells that starts at the same top left corner and covers the same area.

        A last row or column that would not be full is dropped, as dividing the map by the cell size does (§4.3).
        """
        cols = int(self.cols * self.resolution_m / resolution_m + 1e-6)
        rows = int(self.rows * self.resolution_m / resolution_m + 1e-6)
        return GridFrame(self.x_min_m, self.y_max_m - rows * resolution_m, resolution_m, rows, cols)
