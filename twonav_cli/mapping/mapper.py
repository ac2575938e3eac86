"""The mapper: scans and odometry in, a map and the way through it out (Rao-Blackwellized particle filter, §4.1).

Every particle is a path with a map of its own. Between keyframes one scan matcher follows the robot on the map of the
best particle; at a keyframe every particle moves by the improved proposal, is weighted, and puts the scan into its map.
"""

from __future__ import annotations

import math

import numpy as np

from twonav_cli.config import MappingConfig
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, KeyframeMapped, MapDrawn, Sink, to_nobody
from twonav_cli.geometry import FloatArray, Pose, compose, relative_pose
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.cell_units import CellUnits
from twonav_cli.mapping.look_around import found_pose
from twonav_cli.mapping.motion_model import motion_covariance
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.particles import Particles
from twonav_cli.mapping.scan import RangeSensor, Reading, StampedPose, clear_points, points_of
from twonav_cli.mapping.scan_match import matching_rule
from twonav_cli.mapping.surface_normals import surface_normals
from twonav_cli.mapping.tile_picture import drawn, wall_points
from twonav_cli.rng import stream

KEYFRAMES_PER_DRAWING = 10
"""How often the map is drawn for whoever listens."""

ORIGIN = Pose(0.0, 0.0, 0.0)


class GridMapper:
    """Builds a map from readings that are handed to it in order."""

    def __init__(
        self,
        config: MappingConfig,
        sensor: RangeSensor,
        seed: int = 0,
        start: Pose = ORIGIN,
        sink: Sink = to_nobody,
        corner: tuple[float, float] = (0.0, 0.0),
    ) -> None:
        """Begin an empty map.

        Args:
            config: Settings.
            sensor: What measures the ranges.
            seed: Of everything that is drawn.
            start: Where the robot is at the first reading, map frame.
            sink: Told of every keyframe.
            corner: A point of the map frame, metres, where four cells meet.
        """
        self.config = config
        self.sensor = sensor
        self.keyframes = 0
        self._units = CellUnits(config.resolution_m, corner)
        self._limit_m = min(config.max_range_m, sensor.max_m)
        self._particles = Particles(config, self._units.of_pose(start), stream(seed, "mapper"))
        self._sink = sink
        self._tracked = start
        self._first: Reading | None = None
        self._start = start
        self._odom = self._driven = ORIGIN
        self._way_m = self._turned_rad = 0.0

    def add(self, reading: Reading, pose_true: Pose | None = None) -> bool:
        """Take one reading; return whether it went into the map as a keyframe.

        Args:
            reading: Scan and odometry.
            pose_true: The simulator's pose, only passed on to whoever listens.

        Raises:
            TwonavError: Its odometry is not a number, or goes so far that no map would hold it.
        """
        if not np.isfinite(reading.pose_odom).all():
            raise TwonavError(f"the odometry at {reading.stamp_s:.3f} s is not a number: leave that scan out")
        ends_m = points_of(self.sensor, reading.ranges_m, ORIGIN, self._limit_m)
        if self._first is None:
            self._first, self._odom = reading, reading.pose_odom
            self._particles.begin(reading.stamp_s, self._units.of_motion(self.sensor.mount), *self._seen(reading))
            self._tell(reading, False, 0, pose_true)
            return True
        moved = relative_pose(self._odom, reading.pose_odom)
        self._odom = reading.pose_odom
        self._driven = compose(self._driven, moved)
        self._way_m += math.hypot(moved.x_m, moved.y_m)
        self._turned_rad += abs(moved.theta_rad)
        points, normals = ends_m / self.config.resolution_m, surface_normals(ends_m)
        self._follow(moved, points, normals)
        if self._way_m < self.config.keyframe_distance_m and self._turned_rad < self.config.keyframe_turn_rad:
            return False
        self._keyframe(reading, points, normals, pose_true)
        return True

    def pose(self) -> Pose:
        """Where the best particle believes the robot to be at the latest reading."""
        return self._tracked

    def trajectory(self) -> list[StampedPose]:
        """The best particle's pose at every keyframe, with the reading's own stamp."""
        stamps, path = self._particles.paths.path_of(self._particles.best)
        return [StampedPose(stamp, self._units.pose(pose)) for stamp, pose in zip(stamps, path, strict=True)]

    def occupancy(self, frame: GridFrame | None = None) -> OccupancyMap:
        """The map of the best particle, on a frame, or as far as anything was seen.

        Raises:
            TwonavError: The frame's cells do not lie on the mapper's.
        """
        return drawn(self._particles.store, self._particles.best, self._units, frame)

    def walls(self) -> FloatArray:
        """The mean point [K, 2] of the hits in every occupied cell of the best particle's map, metres."""
        return wall_points(self._particles.store, self._particles.best, self._units)

    @property
    def map_bytes(self) -> int:
        """Bytes that the maps of all particles take."""
        return self._particles.store.size_bytes

    def draw(self) -> None:
        """Send the map of the best particle as it is now."""
        if self._sink is to_nobody:
            return
        map_ = self.occupancy()
        path = np.array([stamped.pose for stamped in self.trajectory()])
        self._sink(MapDrawn(self._clock, map_.pixels, map_.frame, path))

    def _seen(self, reading: Reading) -> tuple[FloatArray, int]:
        """Return the ends of the beams [N, 2] in the range finder's own frame, in cells, and how many hit something.

        Those that hit nothing come last.
        """
        at = relative_pose(self.sensor.mount, ORIGIN)
        hits = points_of(self.sensor, reading.ranges_m, at, self._limit_m)
        clear = clear_points(self.sensor, reading.ranges_m, self._limit_m)
        return np.concatenate([hits, clear]) / self.config.resolution_m, len(hits)

    def _follow(self, moved: Pose, points: FloatArray, normals: FloatArray) -> None:
        """Follow the robot between keyframes on the best particle's map.

        Odometry can stand still for a second and catch up in one jump. So where the scan does not fit at the end of
        the last motion, it is also tried where the whole way since the keyframe ends, and where the robot was.
        """
        here, best = self._tracked, self._particles.best
        keyframe = self._units.pose(self._particles.poses[best])
        guesses = [compose(here, moved), compose(keyframe, self._driven), here]
        information = np.linalg.inv(motion_covariance(self.config, moved, here.theta_rad))
        match = found_pose(
            self._particles.store.map_of(best), points, normals, [self._units.of_pose(guess) for guess in guesses],
            np.asarray(information, dtype=np.float64), matching_rule(self.config),
        )  # fmt: skip
        self._tracked = self._units.pose(match.pose) if match.share >= self.config.least_match else guesses[0]

    def _keyframe(self, reading: Reading, points: FloatArray, normals: FloatArray, pose_true: Pose | None) -> None:
        """Move and weigh the particles, map the scan, and draw them again if too few carry the weight."""
        particles, units = self._particles, self._units
        followed = relative_pose(units.pose(particles.poses[particles.best]), self._tracked)
        covariances = [motion_covariance(self.config, self._driven, theta) for theta in particles.poses[:, 2]]
        unmatched = particles.move(
            points, normals, units.of_motion(followed), units.of_motion(self._driven), np.stack(covariances)
        )
        particles.map_scan(reading.stamp_s, units.of_motion(self.sensor.mount), *self._seen(reading))
        few = particles.few
        self._tell(reading, few, unmatched, pose_true)
        if few:
            particles.draw_again()
        self._tracked = units.pose(particles.poses[particles.best])
        self._driven = ORIGIN
        self._way_m = self._turned_rad = 0.0

    @property
    def _clock(self) -> Clock:
        """The keyframes so far, and the time from the first scan to the latest one in the map."""
        first_s = self._first.stamp_s if self._first else 0.0
        return Clock(step=self.keyframes, time_s=self._particles.paths.latest_s - first_s)

    def _tell(self, reading: Reading, resampled: bool, unmatched: int, pose_true: Pose | None) -> None:
        """Send what happened at a keyframe."""
        self.keyframes += 1
        if self._sink is to_nobody or self._first is None:
            return
        particles = self._particles
        pose = self._units.pose(particles.poses[particles.best])
        poses = np.array([self._units.pose(cells) for cells in particles.poses])
        odom = compose(self._start, relative_pose(self._first.pose_odom, reading.pose_odom))
        hits = points_of(self.sensor, reading.ranges_m, pose, self._limit_m)
        self._sink(
            KeyframeMapped(
                self._clock, pose, poses, particles.weights, particles.effective, resampled, unmatched, hits, odom,
                pose_true,
            )
        )  # fmt: skip
        if self.keyframes % KEYFRAMES_PER_DRAWING == 1:
            self.draw()
