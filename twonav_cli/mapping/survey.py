"""The robot surveys a scene by itself: it drives to where the known floor ends until nothing is left (Yamauchi 1997).

It knows where it starts, the area of interest and what its sensors say, and nothing of the scene's geometry. Then it
goes to what it has seen badly, and back to where it began.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import DriveConfig, MappingConfig, OdometryNoise
from twonav_cli.events import Sink, to_nobody
from twonav_cli.geometry import Pose
from twonav_cli.mapping.frontiers import Cells, View, clusters, frontier_cells, nearest_view
from twonav_cli.mapping.mapper import GridMapper
from twonav_cli.mapping.near_views import NearViews
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.route import Ways, ways_from
from twonav_cli.mapping.scan import StampedPose
from twonav_cli.mapping.survey_body import SurveyBody, sensor_of
from twonav_cli.mapping.survey_drive import Mapper, SurveyDrive
from twonav_cli.rng import stream
from twonav_cli.scene.catalog import Scene
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.robot_body import RobotBody
from twonav_cli.scene.world import World

BoolGrid = NDArray[np.bool_]


def _setting(default: Any, sentence: str) -> Any:
    return field(default=default, metadata={"help": sentence})


@dataclass(frozen=True)
class SurveyConfig:
    """How a scene is surveyed."""

    range_noise_m: float = _setting(0.01, "Deviation of a measured range, metres, as of a real laser (ours).")
    waypoint_m: float = _setting(0.4, "Distance between two points that are driven to, metres (ours).")
    view_m: float = _setting(1.5, "Farthest place from which a frontier is looked at, metres (ours).")
    near_m: float = _setting(2.5, "A cell that was seen from nearer than this is seen well, metres (ours).")
    sides: int = _setting(2, "Directions, of eight, from which a cell must have been seen (ours).")
    least_frontier: int = _setting(4, "Cells of the smallest frontier that is looked at (ours).")
    least_unknown: int = _setting(6, "Cells of the smallest unknown region that has a frontier (ours).")
    least_badly_seen: int = _setting(20, "Cells of the smallest region that is looked at again (ours).")
    tries: int = _setting(2, "Times that a place is tried before it is left out (ours).")
    time_limit_s: float = _setting(1800.0, "Simulated time after which the survey ends, seconds (ours).")


QUICK = SurveyConfig(sides=0, time_limit_s=240.0)
"""Shorter: nothing is looked at again."""


@dataclass(frozen=True)
class Surveyed:
    """What a survey brings home.

    Attributes:
        map: On the scene's map frame.
        trajectory: The mapper's keyframes.
        truth: The simulator's pose at every reading.
        outcome: "finished", "timed-out" or "stopped".
        time_s: Simulated time.
        driven_m: Length of the true way.
        collisions: Control periods that ended touching something.
    """

    map: OccupancyMap
    trajectory: list[StampedPose]
    truth: list[StampedPose]
    outcome: str
    time_s: float
    driven_m: float
    collisions: int


class Survey:
    """One survey of one scene."""

    def __init__(
        self,
        scene: Scene,
        config: SurveyConfig,
        mapper_config: MappingConfig,
        base: str = "omni",
        seed: int = 0,
        sink: Sink = to_nobody,
        noise: OdometryNoise | None = None,
        mapper: Mapper | None = None,
    ) -> None:
        """Put the robot at the scene's first start.

        Args:
            scene: Only its robot's world, first start and map area are looked at.
            config: How to survey.
            mapper_config: How to map.
            base: "omni" or "differential".
            seed: Of odometry, ranges and mapper.
            sink: Told what the mapper does.
            noise: Of odometry; default: that of the settings.
            mapper: Makes the map; default: a `GridMapper`.
        """
        self.config = config
        self._start = next(iter(scene.starts.values()))
        self._frame = scene.map_frame
        world = World(scene, base)
        world.place(self._start)
        laser = RangeFinder(world)
        robot = RobotBody(world, laser, noise or OdometryNoise(), stream(seed, "odometry"))
        self._body = SurveyBody(robot, laser.max_m, config.range_noise_m, stream(seed, "ranges"))
        sensor = sensor_of(laser)
        corner = (self._frame.x_min_m, self._frame.y_min_m)
        self.mapper = mapper or GridMapper(mapper_config, sensor, seed, self._start, sink, corner)
        self._near = NearViews(self._frame, sensor, config.near_m)
        self._drive = SurveyDrive(self._body, self.mapper, self._near, DriveConfig(), base)
        self._failed = np.zeros(self._frame.shape, dtype=np.uint8)
        self._tried = np.zeros(self._frame.shape, dtype=np.uint8)
        self._begun_s = self._body.time_s
        self._should_stop: Callable[[], bool] = lambda: False

    def run(self, should_stop: Callable[[], bool] | None = None) -> Surveyed:
        """Survey to the end, or until asked to stop."""
        self._should_stop = should_stop or self._should_stop
        self._drive.hear()
        self._look_round()
        self._see_all(self._frontiers, self.config.view_m, 0.0)
        if self.config.sides:
            self._tried[:] = 0
            self._see_all(self._badly_seen, self.config.near_m, 0.5 * self.config.near_m)
        self._return()
        outcome = "stopped" if self._should_stop() else "timed-out" if self._out_of_time() else "finished"
        truth = self._drive.truth
        return Surveyed(
            self._map(), self.mapper.trajectory(), truth, outcome, self._time_s(), _length_m(truth),
            self._body.collisions,
        )  # fmt: skip

    def _map(self) -> OccupancyMap:
        return self.mapper.occupancy(self._frame)

    def _time_s(self) -> float:
        return self._body.time_s - self._begun_s

    def _out_of_time(self) -> bool:
        return self._time_s() >= self.config.time_limit_s

    def _over(self) -> bool:
        return self._should_stop() or self._out_of_time()

    def _look_round(self) -> None:
        """Turn once on the spot, if there is room: the range finder sees one half only."""
        ways = self._ways(self._map())
        pose = self.mapper.pose()
        if ways is None:
            return
        for _ in range(3):
            self._drive.turn_to(pose.theta_rad, 0.0)
            self._drive.turn_by(2 * math.pi / 3)

    def _ways(self, map_: OccupancyMap) -> Ways | None:
        return ways_from(map_, self.mapper.pose(), self._failed >= self.config.tries)

    def _frontiers(self, map_: OccupancyMap) -> BoolGrid:
        """Return the cells [R, C] where the known floor ends, and that were not tried in vain."""
        return frontier_cells(map_, self.config.least_unknown) & (self._tried < self.config.tries)

    def _badly_seen(self, map_: OccupancyMap) -> BoolGrid:
        """Return the floor [R, C] that was seen from far or from one side only."""
        return map_.free & ~self._near.seen_from(self.config.sides) & (self._tried == 0)

    def _see_all(self, wanted: Callable[[OccupancyMap], BoolGrid], range_m: float, from_m: float) -> None:
        """Go where a kind of cell can be seen, the nearest first, until none can be."""
        least = self.config.least_frontier if wanted == self._frontiers else self.config.least_badly_seen
        resolution_m = self._frame.resolution_m
        while not self._over():
            map_ = self._map()
            ways = self._ways(map_)
            if ways is None:
                return
            groups = clusters(wanted(map_), least)
            view = nearest_view(
                groups, ways.tree.lengths, map_.occupied, range_m / resolution_m, from_m / resolution_m
            )
            if view is None:
                return
            self._visit(view, ways, wanted)

    def _visit(self, view: View, ways: Ways, wanted: Callable[[OccupancyMap], BoolGrid]) -> None:
        """Drive to a view and look, or stop on the way when there is nothing left to see or no way any more."""
        map_ = self._map()
        for point in ways.points_to(view.cell, self.config.waypoint_m):
            if self._over():
                return
            cell = self._frame.cell_at(*point)
            if map_.occupied[cell] or not self._drive.go(point, map_):
                self._note_failure(point)
                return
            map_ = self._map()
            if wanted(map_)[tuple(view.cluster.T)].mean() < 0.5:
                return
        pose = self.mapper.pose()
        x_m, y_m = self._frame.centre_of(view.facing)
        heading_rad = math.atan2(y_m - pose.y_m, x_m - pose.x_m)
        self._drive.turn_to(heading_rad, float(ways.room_m[self._frame.cell_at(pose.x_m, pose.y_m)]))
        self._note_try(view.cluster)

    def _note_failure(self, point: tuple[float, float]) -> None:
        """Remember a place that could not be driven to."""
        row, col = self._frame.cell_at(*point)
        self._failed[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2] += 1

    def _note_try(self, cluster: Cells) -> None:
        """Remember what was looked at."""
        from scipy.ndimage import binary_dilation

        looked = np.zeros(self._frame.shape, dtype=np.bool_)
        looked[tuple(cluster.T)] = True
        self._tried += binary_dilation(looked, iterations=2)

    def _return(self) -> None:
        """Drive back to the start."""
        for _ in range(2 * self.config.tries):
            map_ = self._map()
            ways = self._ways(map_)
            if ways is None or self._over():
                return
            cell = self._frame.cell_at(self._start.x_m, self._start.y_m)
            reached = np.isfinite(ways.tree.lengths)
            near = np.argwhere(reached)
            home = near[((near - cell) ** 2).sum(axis=1).argmin()]
            target = type(cell)(int(home[0]), int(home[1]))
            for point in ways.points_to(target, self.config.waypoint_m):
                if self._over():
                    return
                if not self._drive.go(point, self._map()):
                    self._note_failure(point)
                    break
            else:
                self._drive.turn_to(self._start.theta_rad, float(ways.room_m[target]))
                return


def _length_m(truth: list[StampedPose]) -> float:
    """Return the length of a way."""
    line = np.array([(stamped.pose.x_m, stamped.pose.y_m) for stamped in truth])
    return float(np.hypot(*np.diff(line, axis=0).T).sum()) if len(line) > 1 else 0.0


def _unused(pose: Pose) -> Pose:
    return pose
