"""Where the known floor ends, and from where the robot looks at what lies behind it (Yamauchi 1997).

R rows, C columns of the map; K cells of a cluster.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import Cell
from twonav_cli.mapping.occupancy import UNKNOWN, OccupancyMap

BoolGrid = NDArray[np.bool_]
FloatGrid = NDArray[np.float64]
Cells = NDArray[np.int64]

EIGHT = np.ones((3, 3), dtype=np.bool_)
"""Cells that touch with a corner are neighbours."""

GAP_COST = 2.0
"""A metre between the robot and what it looks at counts as this many metres driven (ours)."""


class View(NamedTuple):
    """A place to look from, and what is looked at."""

    cell: Cell
    """Where the robot goes."""
    cluster: Cells
    """[K, 2] cells that are to be seen."""
    facing: Cell
    """The cell of the cluster that is nearest to the robot then."""


def frontier_cells(map_: OccupancyMap, least_unknown: int) -> BoolGrid:
    """Return the free cells [R, C] beside an unknown region of at least so many cells; the map's border is none."""
    from scipy.ndimage import binary_dilation

    return np.asarray(map_.free & binary_dilation(without_specks(map_.pixels == UNKNOWN, least_unknown)))


def without_specks(cells: BoolGrid, least: int) -> BoolGrid:
    """Return the cells [R, C] whose connected region has at least so many cells."""
    from scipy.ndimage import label

    regions, _ = label(cells, EIGHT)
    large = np.bincount(regions.ravel()) >= least
    large[0] = False
    return np.asarray(large[regions])


def clusters(cells: BoolGrid, least: int) -> list[Cells]:
    """Return the connected groups [K, 2] of at least so many cells, from the top left on."""
    from scipy.ndimage import find_objects, label

    regions, _ = label(cells, EIGHT)
    found = []
    for number, box in enumerate(find_objects(regions), start=1):
        inside = np.argwhere(regions[box] == number)
        if len(inside) >= least:
            found.append(inside + np.array([box[0].start, box[1].start]))
    return found


def tiles(cells: BoolGrid, edge: int, least: int) -> list[Cells]:
    """Return the cells of every square of `edge` x `edge` [K, 2] that holds at least so many, from the top left on."""
    found = []
    for row in range(0, cells.shape[0], edge):
        for col in range(0, cells.shape[1], edge):
            inside = np.argwhere(cells[row : row + edge, col : col + edge])
            if len(inside) >= least:
                found.append(inside + np.array([row, col]))
    return found


def nearest_view(
    groups: list[Cells], lengths: FloatGrid, occupied: BoolGrid, range_cells: float, from_cells: float = 0.0
) -> View | None:
    """Return the view that is cheapest to reach: the way there, and the gap between the robot and what it looks at.

    Args:
        groups: Clusters [K, 2] that are to be seen.
        lengths: [R, C] cost of the way to every cell, in cells; inf where the robot cannot be.
        occupied: [R, C] what nobody looks through.
        range_cells: Farther than this nothing is looked at.
        from_cells: Nearer than this the robot need not come.

    Returns:
        None where no cluster can be looked at.
    """
    best: tuple[float, View] | None = None
    for group in groups:
        found = _view_of(group, lengths, occupied, range_cells, from_cells, np.inf if best is None else best[0])
        best = found or best
    return best[1] if best else None


def _view_of(
    group: Cells, lengths: FloatGrid, occupied: BoolGrid, range_cells: float, from_cells: float, below: float
) -> tuple[float, View] | None:
    """Return the cheapest view of one cluster and its cost, if it costs less than `below`."""
    reach = int(np.ceil(range_cells))
    low, high = np.maximum(group.min(axis=0) - reach, 0), group.max(axis=0) + reach + 1
    window = lengths[low[0] : high[0], low[1] : high[1]]
    rows, cols = np.nonzero(window < below)
    if not rows.size:
        return None
    middle = group[((group - group.mean(axis=0)) ** 2).sum(axis=1).argmin()]
    gaps = np.hypot(rows + low[0] - middle[0], cols + low[1] - middle[1])
    costs = window[rows, cols] + GAP_COST * np.maximum(gaps - from_cells, 0.0)
    near = np.flatnonzero((gaps <= range_cells) & (costs < below))
    for at in near[np.argsort(costs[near], kind="stable")]:
        cell = Cell(int(rows[at] + low[0]), int(cols[at] + low[1]))
        facing = Cell(int(middle[0]), int(middle[1]))
        if in_sight(cell, facing, occupied):
            return float(costs[at]), View(cell, group, facing)
    return None


def in_sight(here: Cell, there: Cell, occupied: BoolGrid) -> bool:
    """Return whether nothing stands on the straight line between two cells, the last one left out."""
    steps = 2 * max(abs(there.row - here.row), abs(there.col - here.col))
    if steps == 0:
        return True
    share = np.arange(steps) / steps
    rows = np.rint(here.row + share * (there.row - here.row)).astype(np.int64)
    cols = np.rint(here.col + share * (there.col - here.col)).astype(np.int64)
    before_last = (rows != there.row) | (cols != there.col)
    return not bool(occupied[rows, cols][before_last].any())
