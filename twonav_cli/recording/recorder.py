"""The recorder: a sink that turns the events of a run into one .rrd file.

It sees events and nothing else, so it can never change a result.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import TracebackType
from typing import Any

import rerun as rr
import rerun.blueprint as rrb

from twonav_cli import __version__, events
from twonav_cli.errors import unknown_name
from twonav_cli.events import Clock, Event
from twonav_cli.grid import GridFrame
from twonav_cli.maze import Maze
from twonav_cli.recording.belief_rows import BeliefRows
from twonav_cli.recording.blueprint import Replay, drive_blueprint, fitting_blueprint, maze_blueprint
from twonav_cli.recording.choice_rows import ChoiceRows
from twonav_cli.recording.drive_rows import DriveRows, unfinished
from twonav_cli.recording.fitting_rows import FittingRows
from twonav_cli.recording.flight import Detail, FlightRule, has_failed
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.guide_text import about
from twonav_cli.recording.learning_rows import LearningRows
from twonav_cli.recording.mapping_rows import MappingRows
from twonav_cli.recording.rrd_file import FITTING_TIMELINES, MAPPING_TIMELINES, TIMELINES, RrdFile
from twonav_cli.recording.scenery import write_floor, write_goals, write_looks
from twonav_cli.recording.snapshots import AT_ONCE, TableSnapshots
from twonav_cli.recording.table_scenery import write_table_scenery

APPLICATION_IDS = {
    "maze": "twonav_maze_2", "2d": "twonav_flat", "3d": "twonav_mujoco_3", "localizer": "twonav_fit",
    "map": "twonav_map",
}  # fmt: skip
"""Stage to application id: one id, one layout, for the viewer keeps the layout of the first file of an id."""

KIND_TIMELINES = {"localizer": FITTING_TIMELINES, "map": MAPPING_TIMELINES}
"""Kinds whose clock counts something else than actions and trials."""

DRIVEN = ("2d", "3d")
"""Kinds with a robot that drives."""

FORMAT = 1
STEPS_PER_SHIPMENT = 50
"""Actions after which a trial that is kept anyway is written, so that a killed game loses little."""
REPLAY_S = 8.0
"""A recording marks this many seconds before its last failure."""

ACTIONS_SHOWN = 4.0
"""Longest shortest ways that the plot of actions is high."""


def longest_way(maze: Maze) -> int:
    """Return the length of the longest of the shortest ways between starts and goals, at least 1."""
    ways = [maze.distances_to(goal)[start] for goal in maze.goals.values() for start in maze.starts.values()]
    return max([1, *(int(way) for way in ways)])


Layout = Callable[[Replay | None], rrb.Blueprint]


class Recorder:
    """Writes what happens to an .rrd file."""

    def __init__(self, path: Path, kind: str, *, every_trial: bool = True, budget_mb: float = 200.0) -> None:
        """Open the file.

        Args:
            path: Must end in .rrd; a file that is there is replaced.
            kind: "map", "maze", "2d", "3d" or "localizer".
            every_trial: Keep every trial in full; else failed ones, the first five and every twentieth.
            budget_mb: Size after which only one row per trial is written.

        Raises:
            TwonavError: The path cannot be written, or there is no such kind.
        """
        if kind not in APPLICATION_IDS:
            raise unknown_name("kind of recording", kind, APPLICATION_IDS)
        self.path = Path(path)
        self._kind = kind
        self._rule = FlightRule(every_trial=every_trial, budget_bytes=int(budget_mb * 1e6))
        self._file = RrdFile(self.path, APPLICATION_IDS[kind], KIND_TIMELINES.get(kind, TIMELINES))
        self._clock = Clock()
        self._trial: Clock | None = None
        self._trials = 0
        self._actions = 0
        self._replay: Replay | None = None
        self._replays_failure = False
        self._snapshots = 0
        self._at_once = AT_ONCE if kind == "maze" else 1
        self._layout: Layout | None = None
        self._finish: list[Callable[[], None]] = []
        self._closed = False
        self._takers: dict[type[Event], list[Callable[[Any], None]]] = {
            events.RunStarted: [self._run_started],
            events.Note: [self._note],
            events.RunEnded: [self._run_ended],
        }

    def __call__(self, event: Event) -> None:
        """Record an event; kinds without a row are passed over."""
        if self._closed:
            return
        self._clock = event.clock
        for take in self._takers.get(type(event), ()):
            take(event)

    def __enter__(self) -> Recorder:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if kind is not None and not self._closed:
            self._file.put("log", ("ERROR", f"the run was stopped: {kind.__name__}"), self._clock, Detail.TRIAL)
        self.close()

    def close(self) -> None:
        """Write what is buffered, the layout that marks the last failure, and the footer."""
        if self._closed:
            return
        self._closed = True
        if self._trial is not None:
            unfinished(self._file, self._trial, self._clock)
            self._remember_replay(self._trial, self._clock, failed=False)
        for finish in self._finish:
            finish()
        self._file.ship(self._rule.level(0, True, self._file.size_bytes))
        if self._kind in DRIVEN and self._layout is not None:
            self._file.show(self._layout(self._replay))
        self._file.close()

    def _run_started(self, event: events.RunStarted) -> None:
        name = f"{event.command} {event.scene}, stage {event.stage}, seed {event.seed}"
        properties = {
            "format": FORMAT,
            "twonav": __version__,
            "kind": self._kind,
            "command": event.command,
            "stage": event.stage,
            "scene": event.scene,
            "seed": event.seed,
            "settings": json.dumps(event.settings),
            "goals": json.dumps(event.maze.goal_names if event.maze else []),
        }
        self._file.describe(name, properties)
        self._file.always("readme", rr.TextDocument(about(event, self._kind), media_type="text/markdown"))
        if self._kind == "localizer":
            self._take_fitting()
        elif self._kind == "map":
            self._take_mapping()
        elif event.maze is not None:
            self._take_trials(event)
        self._file.ship(Detail.FULL)

    def _take_fitting(self) -> None:
        rows = FittingRows(self._file)
        self._file.show(fitting_blueprint([]))
        self._takers[events.FittingStep] = [rows.step]
        self._takers[events.FittingValidated] = [rows.validated]

    def _take_mapping(self) -> None:
        rows = MappingRows(self._file, lambda: self._rule.level(0, True, self._file.size_bytes))
        self._takers[events.KeyframeMapped] = [rows.keyframe]
        self._takers[events.MapDrawn] = [rows.drawn]
        self._finish = [rows.close]

    def _take_trials(self, event: events.RunStarted) -> None:
        maze, always = event.maze, self._file.always
        assert maze is not None
        frame = event.maze_frame or GridFrame(0.0, 0.0, 1.0, maze.rows, maze.cols)
        goals = GoalList(maze, frame)
        self._layout = self._layout_of(event, goals, maze, event.map_frame or frame)
        self._file.show(self._layout(None))
        write_floor(always, maze, frame, event.occupied, event.map_frame)
        write_goals(always, goals)
        write_looks(always, goals.names)
        write_table_scenery(always, maze, frame)
        drive, learning = DriveRows(self._file, frame, goals), LearningRows(self._file, maze, goals)
        choices, beliefs = ChoiceRows(self._file, goals, event.clock), BeliefRows(self._file)
        tables = TableSnapshots(self._file, maze, frame, goals, at_once=self._at_once)
        self._finish = [learning.write_batches, tables.close]
        adding: list[Callable[[Any], None]] = [choices.goal_added, learning.goal_added, tables.goal_added]
        started: list[Callable[[Any], None]] = [choices.trial_started, learning.trial_started, drive.trial_started]
        self._takers |= {
            events.GoalChosen: [choices.goal_chosen, tables.goal_chosen],
            events.TrialStarted: [self._trial_started, *started],
            events.Tick: [drive.tick],
            events.Looked: [drive.looked, beliefs.look],
            events.StepTaken: [drive.step, beliefs.look, self._step_taken],
            events.TrialEnded: [drive.trial_ended, learning.trial_ended, self._trial_ended],
            events.TrialBatch: [choices.batch, learning.batch],
            # Its sentence first: the trials that it ends take it along.
            events.GoalLearned: [choices.goal_learned, learning.goal_learned],
            events.GoalAdded: [partial(self._goal_added, goals), *adding],
            events.QSnapshot: [tables.snapshot, learning.snapshot, self._between_trials],
            events.Kidnapped: [drive.kidnapped],
        }

    def _layout_of(self, event: events.RunStarted, goals: GoalList, maze: Maze, frame: GridFrame) -> Layout:
        """Return what lays the recording out for the goals so far."""
        if self._kind in DRIVEN:
            return lambda replay: drive_blueprint(goals.names, frame, replay, camera=self._kind == "3d")
        top, learns = ACTIONS_SHOWN * longest_way(maze), event.command == "train"
        return lambda replay: maze_blueprint(goals.names, frame, top, learns=learns)

    def _goal_added(self, goals: GoalList, event: events.GoalAdded) -> None:
        goals.add(event.name, event.cell)
        write_goals(self._file.always, goals)
        if self._layout is not None:
            self._file.show(self._layout(None))

    def _between_trials(self, event: events.QSnapshot) -> None:
        """Write what learning said so far, so that a killed run loses little, but not in chunks of single rows."""
        self._snapshots += 1
        if self._trial is None and self._snapshots % self._at_once == 0:
            self._file.ship(self._rule.level(0, True, self._file.size_bytes))

    def _trial_started(self, event: events.TrialStarted) -> None:
        self._trial = event.clock

    def _step_taken(self, event: events.StepTaken) -> None:
        self._actions += 1
        if self._rule.every_trial and self._actions >= STEPS_PER_SHIPMENT:
            self._actions = 0
            self._file.ship(self._rule.level(self._trials, False, self._file.size_bytes))

    def _trial_ended(self, event: events.TrialEnded) -> None:
        failed = has_failed(event.outcome)
        level = self._rule.level(self._trials, failed, self._file.size_bytes)
        self._trials += 1
        if self._trial is not None and level == Detail.FULL:
            self._remember_replay(self._trial, event.clock, failed=failed)
        self._trial = None
        self._actions = 0
        self._file.ship(level)

    def _remember_replay(self, start: Clock, end: Clock, *, failed: bool) -> None:
        """Keep the stretch that the recording marks: of the last failure, else of the last trial."""
        if (self._replays_failure and not failed) or end.time_s <= start.time_s:
            return
        self._replays_failure = failed
        self._replay = Replay(max(start.time_s, end.time_s - REPLAY_S), end.time_s + 0.5)

    def _note(self, event: events.Note) -> None:
        self._file.put("log", (event.level, event.text), event.clock, Detail.TRIAL)
        if event.level == "WARN":
            # Also as a row that can be read back: the log holds much else.
            self._file.put("warnings", {"text": event.text}, event.clock, Detail.TRIAL)

    def _run_ended(self, event: events.RunEnded) -> None:
        self._file.put("log", ("INFO", f"run ended: {event.outcome}"), event.clock, Detail.TRIAL)
        self._file.now("ending", rr.AnyValues(outcome=event.outcome), event.clock)
