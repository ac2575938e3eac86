"""The robot surveys a scene by itself: it drives to where the known floor ends until nothing is left (Yamauchi 1997).

It knows where it starts, the area of interest and what its sensors say (range finder, odometry, bumper, and how fast it
drives), and nothing of the scene's geometry. Then it goes to what it has seen badly, and back to where it began.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import ROBOT_CIRCUMSCRIBED_M, DriveConfig, MappingConfig, OdometryNoise
from twonav_cli.events import Clock, MapDrawn, Note, Sink, to_nobody
from twonav_cli.geometry import FloatArray
from twonav_cli.grid import Cell
from twonav_cli.mapping.frontiers import Cells, View, clusters, frontier_cells, nearest_view, tiles
from twonav_cli.mapping.mapper import GridMapper
from twonav_cli.mapping.near_views import NearViews
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.route import Ways, nearest_cell, ways_from
from twonav_cli.mapping.scan import StampedPose
from twonav_cli.mapping.survey_body import SurveyBody, sensor_of
from twonav_cli.mapping.survey_config import SurveyConfig
from twonav_cli.mapping.survey_drive import Mapper, SurveyDrive
from twonav_cli.rng import stream
from twonav_cli.scene.catalog import Scene
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.robot_body import RobotBody
from twonav_cli.scene.world import World

BoolGrid = NDArray[np.bool_]

TILE_M = 1.0
"""Floor that was seen badly is looked at again in squares of this edge (ours)."""

SEEN_SHARE = 0.5
"""A robot turns to the next place when less than this of what it drives to is still to be seen (ours)."""

FINISHED, TIMED_OUT, STOPPED = "finished", "timed-out", "stopped"


@dataclass(frozen=True)
class Surveyed:
    """What a survey brings home.

    Attributes:
        map: On the scene's map frame.
        walls: [K, 2] points on what is occupied, finer than pixels, metres.
        trajectory: The mapper's keyframes.
        truth: The simulator's pose at every reading.
        outcome: "finished", "timed-out" or "stopped".
        time_s: Simulated time.
        driven_m: Length of the true way.
        collisions: Control periods that ended touching something.
    """

    map: OccupancyMap
    walls: FloatArray
    trajectory: list[StampedPose]
    truth: list[StampedPose]
    outcome: str
    time_s: float
    driven_m: float
    collisions: int


@dataclass(frozen=True)
class _Wish:
    """What is to be seen, and from where."""

    cells: Callable[[OccupancyMap], BoolGrid]
    groups: Callable[[BoolGrid], list[Cells]]
    """Parts the cells into what is looked at in one go."""
    range_m: float
    """Farthest place from which it is looked at."""
    from_m: float
    """Nearer than this the robot need not come."""


class Survey:
    """One survey of one scene, from the scene's first start and back to it."""

    def __init__(
        self,
        scene: Scene,
        config: SurveyConfig,
        mapping: MappingConfig,
        base: str = "omni",
        seed: int = 0,
        sink: Sink = to_nobody,
        noise: OdometryNoise | None = None,
        mapper: Mapper | None = None,
    ) -> None:
        """Put the robot at the start.

        Args:
            scene: Only its first start and its map area are known to the robot.
            config: How to survey.
            mapping: How to map.
            base: "omni" or "differential".
            seed: Of odometry, ranges and mapper.
            sink: Told what the mapper does.
            noise: Of odometry; default: that of the settings.
            mapper: Makes the map; default: a `GridMapper`.

        Raises:
            TwonavError: The scene cannot be simulated, or there is no such base.
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
        self._mapper = mapper or GridMapper(mapping, sensor, seed, self._start, sink, corner)
        self._near = NearViews(self._frame, sensor, config.near_m)
        self._drive = SurveyDrive(self._body, self._mapper, self._near, DriveConfig(), base)
        self._failed = np.zeros(self._frame.shape, dtype=np.uint8)
        self._tried = np.zeros(self._frame.shape, dtype=np.uint8)
        self._begun_s = self._body.time_s
        self._sink = sink
        self._should_stop: Callable[[], bool] = lambda: False

    def run(self, should_stop: Callable[[], bool] | None = None) -> Surveyed:
        """Survey to the end, or until asked to stop (asked at every place that is driven to)."""
        config = self.config
        self._should_stop = should_stop or self._should_stop
        self._drive.hear()
        self._say("exploring: going to where the known floor ends")
        self._look_round()
        at_once = partial(clusters, least=config.least_frontier)
        self._see_all(_Wish(self._frontiers, at_once, config.view_m, 0.0))
        if config.sides and not self._over():
            self._say("looking again: every reachable frontier was looked at; going to what was seen badly")
            self._tried[:] = 0
            edge = round(TILE_M / self._frame.resolution_m)
            at_once = partial(tiles, edge=edge, least=config.least_badly_seen)
            self._see_all(_Wish(self._badly_seen, at_once, config.near_m, 0.5 * config.near_m))
        if not self._over():
            self._say("going back to the start")
        self._return()
        map_, path, truth, outcome = self._map(), self._mapper.trajectory(), self._drive.truth, self._outcome()
        self._sink(MapDrawn(self._clock(), map_.pixels, map_.frame, np.array([stamped.pose for stamped in path])))
        return Surveyed(
            map_, self._mapper.walls(), path, truth, outcome, self._time_s(), _length_m(truth), self._body.collisions
        )

    def _outcome(self) -> str:
        return STOPPED if self._should_stop() else TIMED_OUT if self._out_of_time() else FINISHED

    def _say(self, sentence: str) -> None:
        self._sink(Note(self._clock(), "INFO", sentence))

    def _clock(self) -> Clock:
        return Clock(step=len(self._mapper.trajectory()), time_s=self._time_s())

    def _map(self) -> OccupancyMap:
        return self._mapper.occupancy(self._frame)

    def _time_s(self) -> float:
        return self._body.time_s - self._begun_s

    def _out_of_time(self) -> bool:
        return self._time_s() >= self.config.time_limit_s

    def _over(self) -> bool:
        return self._should_stop() or self._out_of_time()

    def _ways(self, map_: OccupancyMap) -> Ways | None:
        return ways_from(map_, self._mapper.pose(), self._failed >= self.config.tries)

    def _has_room(self, map_: OccupancyMap) -> bool:
        """Whether nothing is known to stand where the outline goes when the robot turns on the spot."""
        pose = self._mapper.pose()
        radius = math.ceil(ROBOT_CIRCUMSCRIBED_M / self._frame.resolution_m)
        row, col = self._frame.cell_at(pose.x_m, pose.y_m)
        low_row, low_col = max(row - radius, 0), max(col - radius, 0)
        rows, cols = np.nonzero(map_.occupied[low_row : row + radius + 1, low_col : col + radius + 1])
        away = np.hypot(rows + low_row - row, cols + low_col - col)
        return bool((away * self._frame.resolution_m > ROBOT_CIRCUMSCRIBED_M).all())

    def _look_round(self) -> None:
        """Turn once on the spot, as far as there is room: the range finder sees one half only."""
        for _ in range(3):
            if not self._over() and self._has_room(self._map()):
                self._drive.turn_by(2 * math.pi / 3)

    def _frontiers(self, map_: OccupancyMap) -> BoolGrid:
        """Return the cells [R, C] where the known floor ends and that were not looked at in vain."""
        return frontier_cells(map_, self.config.least_unknown) & (self._tried < self.config.tries)

    def _badly_seen(self, map_: OccupancyMap) -> BoolGrid:
        """Return the floor [R, C] that was seen from far or from one side only, and was not looked at since."""
        seen_well = self._near.seen_from(self.config.sides)
        return np.asarray(map_.free & ~seen_well & (self._tried == 0))

    def _see_all(self, wish: _Wish) -> None:
        """Go where cells of a kind can be seen, the nearest first, until none can be."""
        resolution_m = self._frame.resolution_m
        while not self._over():
            map_ = self._map()
            ways = self._ways(map_)
            if ways is None:
                return
            groups = wish.groups(wish.cells(map_))
            lengths, occupied = ways.tree.lengths, map_.occupied
            view = nearest_view(groups, lengths, occupied, wish.range_m / resolution_m, wish.from_m / resolution_m)
            if view is None:
                return
            if self._go_along(ways, view.cell, partial(self._is_seen, wish, view)):
                self._look_at(view)

    def _is_seen(self, wish: _Wish, view: View, map_: OccupancyMap) -> bool:
        """Whether most of what a view is for was seen already."""
        return bool(wish.cells(map_)[tuple(view.cluster.T)].mean() < SEEN_SHARE)

    def _go_along(self, ways: Ways, cell: Cell, no_more: Callable[[OccupancyMap], bool]) -> bool:
        """Drive to a cell on its way; return False when that ended early: in vain, or nobody wants it any more."""
        map_ = self._map()
        for point in ways.points_to(cell, self.config.waypoint_m):
            if self._over():
                return False
            touched = self._body.collisions
            if map_.occupied[self._frame.cell_at(*point)] or not self._drive.go(point, map_):
                self._note_failure(point, touched=self._body.collisions > touched)
                return False
            map_ = self._map()
            if no_more(map_):
                return False
        return True

    def _look_at(self, view: View) -> None:
        """Turn to what the view is for, if there is room, and note that it was looked at."""
        from scipy.ndimage import binary_dilation

        pose = self._mapper.pose()
        x_m, y_m = self._frame.centre_of(view.facing)
        if self._has_room(self._map()):
            self._drive.turn_to(math.atan2(y_m - pose.y_m, x_m - pose.x_m))
        looked = np.zeros(self._frame.shape, dtype=np.bool_)
        looked[tuple(view.cluster.T)] = True
        self._tried += binary_dilation(looked, iterations=2)

    def _note_failure(self, point: tuple[float, float], touched: bool) -> None:
        """Remember a place that could not be driven to; what the bumper felt and no beam saw is not tried again."""
        row, col = self._frame.cell_at(*point)
        tries = self.config.tries if touched else 1
        self._failed[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2] += np.uint8(tries)

    def _return(self) -> None:
        """Drive back to the start, or as near to it as a way leads."""
        for _ in range(2 * self.config.tries):
            map_ = self._map()
            ways = self._ways(map_)
            if ways is None or self._over():
                return
            home = nearest_cell(np.isfinite(ways.tree.lengths), self._frame, self._start)
            if home is None:
                return
            if self._go_along(ways, home, lambda map_: False):
                if self._has_room(self._map()):
                    self._drive.turn_to(self._start.theta_rad)
                return


def _length_m(truth: list[StampedPose]) -> float:
    """Return the length of a way."""
    line = np.array([(stamped.pose.x_m, stamped.pose.y_m) for stamped in truth])
    return float(np.hypot(*np.diff(line, axis=0).T).sum()) if len(line) > 1 else 0.0
