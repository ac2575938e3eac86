"""The tables of every goal over the run: which of them are kept, and their pictures.

G goals, R rows, C columns, A actions, F free cells, n snapshots.
"""

from __future__ import annotations

from collections import defaultdict
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.events import Clock, GoalAdded, GoalChosen, QSnapshot
from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.q_pictures import GreedyArrows, value_picture
from twonav_cli.recording.rrd_file import RrdFile
from twonav_cli.recording.table_scenery import CHOSEN, goal_entity, td_entity, write_arrows, write_goal_tables
from twonav_cli.recording.td_pictures import td_levels

FIRST_SNAPSHOTS = 48
"""Snapshots that are kept whatever their distance."""
GROWTH = 1.08
"""After those, a snapshot must be this factor later in trials than the one before it."""
AT_ONCE = 8
"""Snapshots that are written together: a chunk of a file costs a kilobyte whatever it holds."""


class TableSnapshots:
    """Draws the tables when they are sent, and the chosen goal's values when the goal changes."""

    def __init__(self, file: RrdFile, maze: Maze, frame: GridFrame, goals: GoalList, *, at_once: int) -> None:
        """Prepare the pictures of the goals so far.

        Args:
            file: Where to.
            maze: Its walls.
            frame: Where its cells lie.
            goals: Grows when a goal is added.
            at_once: Snapshots that are written together; 1 writes each at once, and the chosen goal's picture too.
        """
        self._file, self._maze, self._frame, self._goals = file, maze, frame, goals
        self._at_once = at_once
        self._arrows = GreedyArrows(maze, frame)
        self._q: NDArray[np.float64] | None = None
        self._chosen: str | None = None
        self._written = self._prepared = self._held = 0
        self._last_trial = 0
        self._pending: QSnapshot | None = None
        self._rows: dict[str, list[tuple[Clock, NDArray[Any]]]] = defaultdict(list)
        self._latest: dict[str, bytes] = {}
        self._prepare(len(goals))

    def _prepare(self, count: int) -> None:
        """Write what never changes about the tables of goals that are seen for the first time."""
        for index in range(self._prepared, count):
            write_goal_tables(self._file.always, index, self._goals, self._maze, self._frame)
        self._prepared = max(self._prepared, count)

    def goal_added(self, event: GoalAdded) -> None:
        """Prepare the new goal's pictures, also when its tables came before its place was known."""
        self._prepared = min(self._prepared, len(self._goals) - 1)
        self._prepare(len(self._goals))

    def goal_chosen(self, event: GoalChosen) -> None:
        """Show the chosen goal's values."""
        self._chosen = event.goal
        centre = self._goals.position_of(event.goal)
        if centre is not None and self._at_once == 1:
            self._file.now(f"{CHOSEN}/goal", rr.Points2D.from_fields(positions=[centre]), event.clock)
            self._draw_chosen(event.clock)
            self._write()

    def snapshot(self, event: QSnapshot) -> None:
        """Keep the tables' pictures unless the last ones are nearly as late in the run."""
        self._q = event.q
        if self._written >= FIRST_SNAPSHOTS and event.clock.trial < self._last_trial * GROWTH:
            self._pending = event
            return
        self._draw(event)
        self._held += 1
        if self._held >= self._at_once:
            self._write()

    def close(self) -> None:
        """Write the snapshots that wait, and the last table of the run when it was left out."""
        if self._pending is not None:
            self._draw(self._pending)
        self._write()

    def _draw(self, event: QSnapshot) -> None:
        """Draw the pictures of every goal."""
        self._pending = None
        self._written += 1
        self._last_trial = event.clock.trial
        self._prepare(len(event.q))
        for index, q in enumerate(event.q):
            self._draw_values(goal_entity(index), q, event.clock)
            if event.td_errors is not None:
                levels = td_levels(event.td_errors[index], self._maze.blocked)
                self._hold(f"{td_entity(index)}/error", levels, event.clock)
        if self._at_once == 1:
            self._draw_chosen(event.clock)

    def _draw_chosen(self, clock: Clock) -> None:
        names = self._goals.names
        if self._q is not None and self._chosen in names and names.index(self._chosen) < len(self._q):
            self._draw_values(CHOSEN, self._q[names.index(self._chosen)], clock)

    def _draw_values(self, entity: str, q: NDArray[np.float64], clock: Clock) -> None:
        if f"{entity}/policy" not in self._latest:
            write_arrows(self._file.always, entity, self._arrows.origins)
        self._hold(f"{entity}/value", value_picture(q, self._maze.blocked), clock)
        self._hold(f"{entity}/policy", self._arrows.of(q), clock)

    def _hold(self, entity: str, picture: NDArray[Any], clock: Clock) -> None:
        """Keep a picture for the next shipment, unless it is the one that is shown already."""
        content = picture.tobytes()
        if self._latest.get(entity) != content:
            self._latest[entity] = content
            self._rows[entity].append((clock, picture))

    def _write(self) -> None:
        """Write the pictures that wait."""
        for entity, rows in self._rows.items():
            pictures = np.stack([picture for _, picture in rows])
            self._file.send(entity, [clock for clock, _ in rows], _columns_of(entity, pictures))
        self._rows.clear()
        self._held = 0


def _columns_of(entity: str, pictures: NDArray[Any]) -> Any:
    """Return pictures of one kind [n, ...] as the columns of their entity."""
    count, kind = len(pictures), entity.rsplit("/", 1)[-1]
    if kind == "policy":
        lengths = [pictures.shape[1]] * count
        return rr.Arrows2D.columns(vectors=pictures.reshape(-1, 2)).partition(lengths)
    pixels = pictures.reshape(count, -1).view(np.uint8)
    return rr.DepthImage.columns(buffer=pixels) if kind == "value" else rr.SegmentationImage.columns(buffer=pixels)
