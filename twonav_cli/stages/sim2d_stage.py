"""The 2D stage: the robot's outline on the map, its controller, its odometry, and a pose that is right (§4.3.1).

An action is one compiled call. Whoever wants to see every control period gets the same action period by period.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from twonav_cli.config import DriveConfig, OdometryNoise
from twonav_cli.events import Clock, Sink, Tick
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.floor import Floor
from twonav_cli.maze import Maze
from twonav_cli.navigation.drive_periods import DONE, OUTCOMES, begin_drive, new_board, new_drive, setup_for
from twonav_cli.navigation.drive_trace import trace_is_due, traced
from twonav_cli.rng import stream
from twonav_cli.sim2d.flat_actions import carry_out, decide, drive_action
from twonav_cli.sim2d.flat_body import SCAN_MAX_M, FlatBody, fits, put
from twonav_cli.sim2d.flat_laser import BEAMS
from twonav_cli.sim2d.flat_world import flat_world
from twonav_cli.stages.cell_places import Headings, beyond, nearest_free_cells, no_room
from twonav_cli.stages.stage import ActionResult, Observation


@dataclass(frozen=True)
class Sim2dOptions:
    """What may differ between runs of the 2D stage."""

    base: str = "omni"
    drive: DriveConfig = field(default_factory=DriveConfig)
    noise: OdometryNoise = field(default_factory=OdometryNoise)
    ticks: bool = False
    """Send a Tick in every control period."""
    trace: bool = False
    """Send what the controller weighed with some of them."""


class Sim2dStage:
    """A robot with an outline on the 5 cm map; implements `Stage`."""

    name = "2d"

    def __init__(self, floor: Floor, seed: int, options: Sim2dOptions | None = None) -> None:
        """Lay out the map.

        Args:
            floor: Map and maze; the map is both what the robot knows and what there is.
            seed: Seed of the odometry noise and of the headings at places that name none.
            options: Base, controller and what to send along.
        """
        self.options = options or Sim2dOptions()
        self.maze: Maze = floor.maze
        self.frame: GridFrame = floor.maze_frame
        base, drive, map_ = self.options.base, self.options.drive, floor.map
        self.world = flat_world(map_.occupied, map_.frame, base)
        self.body = FlatBody(self.world, self.options.noise, stream(seed, "odometry"))
        self._setup = setup_for(drive, base, map_.occupied, map_.frame)
        self._board, self._drives = new_board(self._setup), new_drive()
        self._scan_m = np.empty(BEAMS)
        self._headings = Headings(floor, stream(seed, "placing"))
        self._snap = nearest_free_cells(floor.maze)

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return float(self.body.state["time_s"][0])

    @property
    def collisions(self) -> int:
        """Control periods that ended at something, since the stage was made."""
        return int(self.body.state["collisions"][0])

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw odometry's errors and headings from a stream from here on."""
        self.body.errors = self._headings.rng = rng

    def place(self, cell: Cell) -> Observation:
        """Put the robot at the centre of a cell, with the scene's heading if the cell is a start.

        Raises:
            TwonavError: Its outline does not fit there at any heading.
        """
        x_m, y_m = self.frame.centre_of(cell)
        for heading_rad in self._headings.tried(cell):
            if fits(self.world, x_m, y_m, heading_rad):
                put(self.body.state, x_m, y_m, heading_rad)
                return self._observed()
        raise no_room(cell)

    def carry(self, cell: Cell) -> Observation:
        """Put the robot into another free cell; in 2D it knows at once where it is."""
        return self.place(cell)

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        """Drive to the neighbouring cell, or try to."""
        before = self.body.pose()
        target = beyond(self.frame, self._snap[self.frame.cell_at(before.x_m, before.y_m)], action)
        if self.options.ticks or self.options.trace:
            self._act_watched(before, target, clock, sink)
        else:
            drive_action(
                self._setup, self._board, self._drives, self.world, self.body.state, self.body.rates, self.body.errors,
                self._scan_m, before, *target,
            )  # fmt: skip
        return ActionResult(OUTCOMES[int(self._drives["outcome"][0])], self._observed())

    def _act_watched(self, before: Pose, target: tuple[float, float], clock: Clock, sink: Sink) -> None:
        """Do the same from Python, and send every control period."""
        setup, board, drives, body = self._setup, self._board, self._drives, self.body
        body.odometry()
        believed = before
        begin_drive(setup, board, drives, believed, *target)
        while True:
            due = self.options.trace and trace_is_due(drives)
            command = decide(setup, board, drives, self.world, body.state, self._scan_m, believed, SCAN_MAX_M, not due)
            if drives["phase"][0] == DONE:
                return
            trace = traced(setup, board, drives, believed) if due else None
            moment = replace(clock, time_s=self.time_s)
            sink(Tick(moment, body.pose(), believed, self._scan_m.copy(), trace, None))
            believed = Pose(
                *carry_out(self.world, body.state, body.rates, body.errors, believed, command, setup.limits.tick_s)
            )

    def _observed(self) -> Observation:
        """Return where the robot is, which it knows (§4.3.1)."""
        pose = self.body.pose()
        cell = self.frame.cell_at(pose.x_m, pose.y_m)
        return Observation(self._snap[cell], cell, pose, pose)

    def close(self) -> None:
        """Nothing to give back."""
