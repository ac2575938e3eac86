"""Rows of a driving robot: poses, scans, the controller's candidates, the camera, the way, where trials failed."""

from __future__ import annotations

import numpy as np
import rerun as rr

from twonav_cli.events import Clock, Kidnapped, Looked, StepTaken, Tick, TrialEnded, TrialStarted
from twonav_cli.grid import GridFrame
from twonav_cli.maze import Action
from twonav_cli.recording.columns import Marks, cost_patch, goal_errors, thinned_candidates
from twonav_cli.recording.flight import Detail, has_failed
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.palette import CAUSE_COLOURS
from twonav_cli.recording.rrd_file import RrdFile

SCAN_EVERY = 4
CANDIDATES_EVERY = 4
COST_MAP_EVERY = 6
POSES_EVERY = 10
"""Ticks between two rows; the last one is for trials of which only the poses are kept."""
MAX_TRAIL = 150
MAX_FAILURES = 200
TOUCHED = 0xD55E00FF


class DriveRows:
    """Turns the events of a trial into rows."""

    def __init__(self, file: RrdFile, frame: GridFrame, goals: GoalList) -> None:
        self._file = file
        self._frame = frame
        self._goals = goals
        self._ticks = self._candidates_due = self._cost_map_due = 0
        self._trail: list[tuple[float, float]] = []
        self._lost = False
        self._failures = Marks([], [], [])
        self._kidnaps: list[list[tuple[float, float]]] = []

    def trial_started(self, event: TrialStarted) -> None:
        """Begin a new way and ring the goal."""
        self._ticks = self._candidates_due = self._cost_map_due = 0
        self._lost = False
        pose = event.pose_true
        self._trail = [(pose.x_m, pose.y_m) if pose else self._frame.centre_of(event.start)]
        place = self._goals.position_of(event.goal)
        if place is not None:
            self._file.put("goal", place, event.clock, Detail.POSES)

    def tick(self, event: Tick) -> None:
        """Buffer one control period; what is dear only every few periods."""
        put, clock, count = self._file.put, event.clock, self._ticks
        self._ticks += 1
        put("pose", (event.pose_true, event.pose_believed), clock, Detail.FULL if count % POSES_EVERY else Detail.POSES)
        if count % SCAN_EVERY == 0:
            put("scan", (event.pose_true, event.scan_m.astype(np.float32)), clock)
        if event.drive is not None and count >= self._candidates_due:
            self._candidates_due = count + CANDIDATES_EVERY
            put("candidates", thinned_candidates(event.drive), clock)
        if event.drive is not None and count >= self._cost_map_due:
            self._cost_map_due = count + COST_MAP_EVERY
            put("cost", cost_patch(event.drive), clock)
        if event.image is not None:
            put("camera", event.image.copy(), clock)

    def looked(self, event: Looked) -> None:
        """Buffer what a robot sees that stands, where it is, and where it believes to be."""
        believed = event.pose_true if event.pose_estimate is None else event.pose_estimate
        self._file.put("pose", (event.pose_true, believed), event.clock, Detail.POSES)
        if event.pose_estimate is not None:
            self._file.put("estimate", (event.pose_true, event.pose_estimate), event.clock, Detail.POSES)
        self._file.put("camera", event.image.copy(), event.clock)

    def step(self, event: StepTaken) -> None:
        """Buffer one action."""
        put, clock = self._file.put, event.clock
        if event.pose_true is None:
            here = self._frame.centre_of(event.true_cell or event.next_cell)
            put("position", here, clock, Detail.POSES)
        else:
            here = event.pose_true.x_m, event.pose_true.y_m
            if event.pose_estimate is not None:
                put("estimate", (event.pose_true, event.pose_estimate), clock, Detail.POSES)
        self._trail.append(here)
        put("trail", np.array(self._trail[-MAX_TRAIL:], dtype=np.float32), clock)
        put("step/q", event.q_values.copy(), clock)
        put("step/td_error", goal_errors(self._goals.at_start, event.td_errors), clock)
        if event.image is not None:
            put("camera", event.image.copy(), clock)
        self._say_what_is_wrong(event)

    def _say_what_is_wrong(self, event: StepTaken) -> None:
        if event.outcome != "reached":
            action = Action(event.action).name.lower()
            text = f"action {action} in cell {tuple(event.cell)} ended {event.outcome}"
            self._file.put("log", ("WARN", text), event.clock)
        lost = event.true_cell is not None and event.true_cell != event.next_cell
        if lost and not self._lost and event.true_cell is not None:
            text = f"believes to be in cell {tuple(event.next_cell)} but stands in {tuple(event.true_cell)}"
            self._file.put("log", ("WARN", text), event.clock)
        if self._lost and not lost:
            text = f"believes rightly again to be in cell {tuple(event.next_cell)}"
            self._file.put("log", ("INFO", text), event.clock)
        self._lost = lost

    def kidnapped(self, event: Kidnapped) -> None:
        """Draw where the robot was carried, and begin a new way there."""
        before, after = event.pose_before, event.pose_after
        self._trail = [(after.x_m, after.y_m)]
        self._kidnaps.append([(before.x_m, before.y_m), (after.x_m, after.y_m)])
        self._file.now("drive/map/kidnaps", rr.LineStrips2D(self._kidnaps[-MAX_FAILURES:]), event.clock)
        text = f"carried from ({before.x_m:.2f}, {before.y_m:.2f}) m to ({after.x_m:.2f}, {after.y_m:.2f}) m"
        self._file.put("log", ("WARN", text), event.clock, Detail.TRIAL)

    def trial_ended(self, event: TrialEnded) -> None:
        """Buffer the whole way, and mark the place of a failure."""
        if len(self._trail) > 1:
            self._file.put("trail", np.array(self._trail, dtype=np.float32), event.clock, Detail.POSES)
        if not has_failed(event.outcome):
            return
        pose = event.pose_true
        here = (pose.x_m, pose.y_m) if pose else (self._trail or [self._frame.centre_of(event.start)])[-1]
        marks = self._failures
        marks.points.append(here)
        marks.labels.append(f"trial {event.clock.trial}: {event.cause or event.outcome}")
        marks.colours.append(CAUSE_COLOURS.get(event.cause, TOUCHED))
        latest = Marks(marks.points[-MAX_FAILURES:], marks.labels[-MAX_FAILURES:], marks.colours[-MAX_FAILURES:])
        self._file.put("failures", latest, event.clock, Detail.TRIAL)


def unfinished(file: RrdFile, start: Clock, now: Clock) -> None:
    """Colour a trial that the end of the recording cut off."""
    file.put("state/outcome", "unfinished", start, Detail.TRIAL)
    file.put("log", ("INFO", f"trial {start.trial} was not finished"), now, Detail.TRIAL)
