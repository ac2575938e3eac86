"""The 3D stage: MuJoCo physics, the camera, and a pose that is only an estimate (§4.3.1).

At every cell border the agent looks once: the estimated pose sets the grid cell. Between two looks the local
controller trusts odometry from the last estimate, and the localizer is told what odometry reported.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from twonav_cli.config import DriveConfig, OdometryNoise
from twonav_cli.events import Clock, DriveTrace, Sink, Tick
from twonav_cli.geometry import FloatArray, Pose, distance_m, relative_pose, wrap_angle
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.floor import Floor
from twonav_cli.maze import Maze
from twonav_cli.navigation.cell_driver import CellDriver
from twonav_cli.rng import stream
from twonav_cli.scene.camera import Camera
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.robot_body import RobotBody
from twonav_cli.scene.world import World
from twonav_cli.stages.cell_places import Headings, beyond, nearest_free_cells, no_room
from twonav_cli.stages.localize import STILL, Image, Localize, Located
from twonav_cli.stages.stage import ActionResult, Observation

AGREE_M, AGREE_RAD = 0.30, 0.5
"""A look and the odometry since the look before agree within this; odometry itself errs by 1 or 2 cm on one cell, the
localizer by 13 cm in 95 % of its estimates (ours)."""


@dataclass(frozen=True)
class Sim3dOptions:
    """What may differ between runs of the 3D stage."""

    base: str = "omni"
    drive: DriveConfig = field(default_factory=DriveConfig)
    noise: OdometryNoise = field(default_factory=OdometryNoise)
    image_every_tick: bool = False
    """Look through the camera in every control period (for watching; the agent does not see these)."""
    trace: bool = False
    """Send what the controller weighed with every tick."""


class Sim3dStage:
    """A robot with a body in a furnished scene; implements `Stage`."""

    name = "3d"

    def __init__(self, floor: Floor, localize: Localize | None, seed: int, options: Sim3dOptions | None = None) -> None:
        """Build the world.

        Args:
            floor: Scene, map and maze.
            localize: Says where the robot is; None takes the simulator's truth.
            seed: Seed of the odometry noise and of the headings at places that name none.
            options: Base, controller and what to send along.
        """
        self.options = options or Sim3dOptions()
        self.maze: Maze = floor.maze
        self.frame: GridFrame = floor.maze_frame
        self.world = World(floor.scene, self.options.base)
        self.camera = Camera(self.world)
        self.localize = localize
        self._laser = RangeFinder(self.world)
        self._body = RobotBody(self.world, self._laser, self.options.noise, stream(seed, "odometry"))
        self._driver = CellDriver(self.options.drive, self.options.base, floor.map.occupied, floor.map.frame)
        self._headings = Headings(floor, stream(seed, "placing"))
        self._snap = nearest_free_cells(floor.maze)
        self._believed = self.world.pose()

    @property
    def time_s(self) -> float:
        """Simulated time."""
        return float(self.world.time_s)

    @property
    def collisions(self) -> int:
        """Control periods that ended touching something, since the stage was made."""
        return self._body.collisions

    def draw_from(self, rng: np.random.Generator) -> None:
        """Draw odometry's errors, headings and the filter's particles from a stream from here on."""
        self._body.draw_from(rng)
        self._headings.rng = rng
        if self.localize is not None:
            self.localize.draw_from(rng)

    def place(self, cell: Cell) -> Observation:
        """Put the robot at the centre of a cell, with the scene's heading if the cell is a start."""
        return self.place_at(Pose(*self.frame.centre_of(cell), self._headings.drawn(cell)))

    def place_at(self, pose: Pose) -> Observation:
        """Put the robot at any pose and look; what it saw before is forgotten."""
        if self.localize is not None:
            self.localize.forget()
        self.world.place(pose)
        return self._looked_from_here()

    def carry(self, cell: Cell) -> Observation:
        """Put the robot into a cell and look, without telling it: whoever filters believes what it believed.

        Raises:
            TwonavError: There it touches something at any heading.
        """
        for heading_rad in self._headings.tried(cell):
            self.world.place(Pose(*self.frame.centre_of(cell), wrap_angle(heading_rad)))
            if not self.world.touching():
                return self._looked_from_here()
        raise no_room(cell)

    def _looked_from_here(self) -> Observation:
        """Forget the motion of being put here, and look."""
        self._body.settle()
        return self.look()

    def picture(self, cell: Cell) -> tuple[Pose, Image]:
        """Put the robot into a cell and return where it stands and what it sees, without asking the localizer."""
        x_m, y_m = self.frame.centre_of(cell)
        self.world.place(Pose(x_m, y_m, self._headings.usual(cell)))
        return self.world.pose(), self.camera.image()

    def look(self, motion: Pose = STILL) -> Observation:
        """Take a picture, estimate the pose and take it as the pose that the controller believes.

        Args:
            motion: How odometry says that the robot moved since the last look, in its frame then.
        """
        true = self.world.pose()
        image = self.camera.image()
        located = Located(true) if self.localize is None else self.localize(image, motion)
        self._believed = located.pose
        return Observation(
            cell=self._snap[self.frame.cell_at(located.pose.x_m, located.pose.y_m)],
            true_cell=self.frame.cell_at(true.x_m, true.y_m),
            pose_true=true,
            pose_estimate=located.pose,
            image=image,
            belief=located.belief,
            filtered=located.filtered,
        )

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        """Drive to the neighbouring cell, or try to, and look."""
        here = self._snap[self.frame.cell_at(self._believed.x_m, self._believed.y_m)]
        target = beyond(self.frame, here, action)

        def on_tick(believed: Pose, scan_m: FloatArray, trace: DriveTrace | None) -> None:
            image = self.camera.image() if self.options.image_every_tick else None
            moment = replace(clock, time_s=self.time_s)
            sink(Tick(moment, self.world.pose(), believed, scan_m, trace, image))

        outcome, expected = self._driver.drive_to(self._body, self._believed, target, on_tick, self.options.trace)
        seen = self.look(relative_pose(self._believed, expected))
        return ActionResult(outcome, seen, _agree(expected, self._believed))

    def close(self) -> None:
        """Give back the renderer."""
        self.camera.close()


def _agree(expected: Pose, estimate: Pose) -> bool:
    """Return whether an estimate is where odometry says that the robot has driven to."""
    turned_rad = abs(wrap_angle(estimate.theta_rad - expected.theta_rad))
    return distance_m(expected, estimate) < AGREE_M and turned_rad < AGREE_RAD
