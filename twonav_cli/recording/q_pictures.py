"""Pictures of the Q-table: value of the best action and greedy action per cell.

R rows, C columns, A actions, F free cells.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.maze import OFFSETS, Maze

FloatArray = NDArray[np.float64]

ARROW_CELLS = 0.62
"""Length of a greedy arrow in cells."""


def value_picture(q: FloatArray, blocked: NDArray[np.bool_]) -> NDArray[np.float16]:
    """Return the value of the best action in every cell [R, C]; not a number, which is drawn black, in blocked ones."""
    return np.where(blocked, np.nan, q.max(axis=-1)).astype(np.float16)


class GreedyArrows:
    """The greedy action in every free cell as an arrow from the cell's centre.

    Attributes:
        origins: [F, 2] centres, which never change, in the map frame, metres.
    """

    def __init__(self, maze: Maze, frame: GridFrame) -> None:
        self.origins = np.array([frame.centre_of(cell) for cell in maze.free_cells], dtype=np.float32).reshape(-1, 2)
        self._rows, self._cols = np.array(maze.free_cells, dtype=np.intp).reshape(-1, 2).T
        # Row down is y down: (row, col) steps become (x, y) steps.
        self._directions = np.array([(col, -row) for row, col in OFFSETS]) * frame.resolution_m * ARROW_CELLS

    def of(self, q: FloatArray) -> NDArray[np.float32]:
        """Return the arrows [F, 2] of a goal's table [R, C, A], metres; none where all actions are worth the same."""
        values = q[self._rows, self._cols]
        vectors = self._directions[values.argmax(axis=-1)]
        vectors[np.ptp(values, axis=-1) == 0] = 0.0
        return np.asarray(vectors, dtype=np.float32)
