"""One action becomes motion: from the believed pose to the centre of the neighbouring cell (§3.1.3).

Within an action the pose is believed by odometry only. A control period: look, update the cost map, plan, drive.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import DriveConfig
from twonav_cli.events import DriveTrace
from twonav_cli.geometry import Pose, Twist, compose
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.drive_periods import (
    DONE,
    OUTCOMES,
    begin_drive,
    new_board,
    new_drive,
    next_command,
    setup_for,
)
from twonav_cli.navigation.drive_trace import trace_is_due, traced

FloatArray = NDArray[np.float64]
OnTick = Callable[[Pose, FloatArray, DriveTrace | None], None]


class Body(Protocol):
    """What is driven: a simulated robot, or a point in a test."""

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Command a twist for some time."""

    def odometry(self) -> Pose:
        """Return the motion since the last call, in the frame of then, as the wheels report it."""

    def scan(self) -> FloatArray:
        """Return ranges [180] from the right (-90 degrees) to the left (+90), in metres."""

    def twist(self) -> Twist:
        """Return how it moves now."""


class CellDriver:
    """Drives single actions on one map with one base ("omni" or "differential")."""

    def __init__(self, config: DriveConfig, base: str, occupied: NDArray[np.bool_], map_frame: GridFrame) -> None:
        self._config = config
        self._setup = setup_for(config, base, occupied, map_frame)
        self._board = new_board(self._setup)
        self._drives = new_drive()

    def drive_to(
        self,
        body: Body,
        believed: Pose,
        target_xy: tuple[float, float],
        on_tick: OnTick | None = None,
        trace: bool = False,
    ) -> tuple[str, Pose]:
        """Drive to a neighbouring cell's centre and stand still there.

        A blocked robot goes back to where it started, so a bump leaves it in its cell.

        Args:
            body: What is driven; motion it has not reported by odometry yet is forgotten.
            believed: Where the robot believes to be now.
            target_xy: Where it is to go, map frame, metres.
            on_tick: Called in every control period before driving: believed pose, scan [180], trace.
            trace: Whether to hand `on_tick` what the controller weighed; it decides the same without.

        Returns:
            "reached", "blocked" or "timed-out", and the believed pose at the end.
        """
        body.odometry()
        setup, board, drives = self._setup, self._board, self._drives
        begin_drive(setup, board, drives, believed, *(float(value) for value in target_xy))
        while True:
            scan_m = body.scan()
            due = trace and trace_is_due(drives)
            command = Twist(*next_command(setup, board, drives, believed, body.twist(), scan_m, not due))
            if drives["phase"][0] == DONE:
                return OUTCOMES[int(drives["outcome"][0])], believed
            if on_tick is not None:
                on_tick(believed, scan_m, traced(setup, board, drives, believed) if due else None)
            body.drive(command, self._config.tick_s)
            believed = compose(believed, body.odometry())
