"""What the controller weighed in a control period, for a recording: candidates, the chosen one, the cost map."""

from __future__ import annotations

import numpy as np

from twonav_cli.events import DriveTrace
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.costmap import SUBDIVISION, inflated
from twonav_cli.navigation.drive_periods import BRAKE, NOTHING_PLANNED, Board, DriveState, Setup
from twonav_cli.navigation.dwa import rolled_out

TRACE_EVERY = 10
"""Periods from one trace of what the controller weighed to the next (ours)."""

TRACED_CANDIDATES = 60
"""Candidates of a period that are recorded, evenly taken (ours)."""


def trace_is_due(drives: DriveState) -> bool:
    """Whether the coming period is one of those that are traced: among them the first of every leg.

    Tracing weighs every candidate to its end, which costs four times as much.
    """
    # After braking the way back may begin; if it does not, nothing is weighed.
    return int(drives["phase"][0]) == BRAKE or int(drives["periods"][0]) % TRACE_EVERY == 0


def traced(setup: Setup, board: Board, drives: DriveState, believed: Pose) -> DriveTrace | None:
    """Return what was weighed in this period, at most TRACED_CANDIDATES of it; None while the robot brakes."""
    drive, window = drives[0], board.window
    best, count = int(drive["best"]), int(drive["count"])
    if best == NOTHING_PLANNED:
        return None
    stride = -(-count // TRACED_CANDIDATES)
    kept = list(range(0, count, stride))
    if best >= 0:
        kept[best // stride] = best
    pixels, planner = window.marks.shape[0] // SUBDIVISION, setup.planner
    return DriveTrace(
        candidates=rolled_out(planner, believed, board.choices.candidates[kept]),
        costs=board.choices.costs[kept].astype(np.float32),
        best=best // stride if best >= 0 else -1,
        cost_map=inflated(window.distance_m, planner.robot.inscribed_m, planner.rollout.inflation_m),
        cost_frame=GridFrame(
            float(drive["grid_x_m"]), float(drive["grid_y_m"]), setup.map_grid.resolution_m, pixels, pixels
        ),
    )
