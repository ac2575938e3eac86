"""Pictures of the Q-table: value of the best action and greedy action per cell.

R rows, C columns, A actions, F free cells.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.events import Clock, GoalChosen, QSnapshot
from twonav_cli.grid import GridFrame
from twonav_cli.maze import OFFSETS, Maze
from twonav_cli.recording.rrd_file import RrdFile
from twonav_cli.recording.scenery import ARROW_CELLS, goal_entity

FloatArray = NDArray[np.float64]

FIRST_SNAPSHOTS = 24
"""Snapshots that are kept whatever their distance."""
GROWTH = 1.08
"""After those, a snapshot must be this factor later in trials than the one before it."""


class QPictures:
    """Draws the table when it is sent, and the chosen goal's part of it when the goal changes."""

    def __init__(self, file: RrdFile, maze: Maze, frame: GridFrame) -> None:
        self._file = file
        self._maze = maze
        self._frame = frame
        self._cells = np.array(maze.free_cells).reshape(-1, 2)  # (F, 2)
        self._centres = np.array([frame.centre_of(cell) for cell in maze.free_cells]).reshape(-1, 2)
        # Row down is y down: (row, col) steps become (x, y) steps.
        self._directions = np.array([(col, -row) for row, col in OFFSETS]) * frame.resolution_m * ARROW_CELLS
        self._q: FloatArray | None = None
        self._chosen: str | None = None
        self._written = 0
        self._last_trial = 0
        self._pending: QSnapshot | None = None

    def goal_chosen(self, event: GoalChosen) -> None:
        """Show the chosen goal's values."""
        self._chosen = event.goal
        if event.goal in self._maze.goals:
            centre = self._frame.centre_of(self._maze.goals[event.goal])
            self._file.now("q/chosen/map/goal", rr.Points2D.from_fields(positions=[centre]), event.clock)
            self._draw_chosen(event.clock)

    def snapshot(self, event: QSnapshot) -> None:
        """Write the table's pictures unless the last ones are nearly as late in the run."""
        self._q = event.q
        if self._written >= FIRST_SNAPSHOTS and event.clock.trial < self._last_trial * GROWTH:
            self._pending = event
            return
        self.write(event)

    def write_pending(self) -> None:
        """Write the last table of the run when it was left out."""
        if self._pending is not None:
            self.write(self._pending)

    def write(self, event: QSnapshot) -> None:
        """Write the pictures of every goal."""
        self._pending = None
        self._written += 1
        self._last_trial = event.clock.trial
        for index in range(len(self._maze.goals)):
            self._draw(goal_entity(index), event.q[index], event.clock)
        self._draw_chosen(event.clock)

    def _draw_chosen(self, clock: Clock) -> None:
        if self._q is not None and self._chosen in self._maze.goals:
            index = self._maze.goal_names.index(self._chosen)
            self._draw("q/chosen/map", self._q[index], clock)

    def _draw(self, entity: str, q: FloatArray, clock: Clock) -> None:
        """Write value and policy of one goal's table [R, C, A]."""
        value, arrows = self._picture(q)
        self._file.send(f"{entity}/value", [clock], value)
        self._file.send(f"{entity}/policy", [clock], arrows)

    def _picture(self, q: FloatArray) -> tuple[Any, Any]:
        # NaN is drawn black: the blocked cells.
        value = np.where(self._maze.blocked, np.nan, q.max(axis=-1)).astype(np.float16)
        greedy = q[self._cells[:, 0], self._cells[:, 1]].argmax(axis=-1)
        vectors = self._directions[greedy]
        vectors[np.ptp(q[self._cells[:, 0], self._cells[:, 1]], axis=-1) == 0] = 0.0  # nothing learned, no arrow
        count = [len(vectors)]
        arrows = [
            *rr.Arrows2D.columns(origins=(self._centres - vectors / 2).astype(np.float32)).partition(count),
            *rr.Arrows2D.columns(vectors=vectors.astype(np.float32)).partition(count),
        ]
        return rr.DepthImage.columns(buffer=value.reshape(1, -1).view(np.uint8)), arrows
