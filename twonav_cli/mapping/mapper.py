"""The mapper: scans and odometry in, a map and the way through it out (Rao-Blackwellized particle filter, §4.1).

Every particle is a path with a map of its own. Between keyframes one scan matcher follows the robot on the map of the
best particle; at a keyframe every particle moves by the improved proposal, is weighted, and puts the scan into its map.

Inside, lengths are in cells and rows grow with y; P particles, N beams that hit something.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import MappingConfig
from twonav_cli.events import Clock, KeyframeMapped, MapDrawn, Sink, to_nobody
from twonav_cli.geometry import FloatArray, Pose, compose, relative_pose, wrap_angle, wrap_angles
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.cells import TileStore, carve, touch
from twonav_cli.mapping.motion_model import composed, motion_covariance
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.paths_of_particles import PathTree
from twonav_cli.mapping.proposal import propose
from twonav_cli.mapping.resampling import effective_number, normalised, systematic
from twonav_cli.mapping.scan import RangeSensor, Reading, StampedPose, points_of, usable
from twonav_cli.mapping.scan_match import found_pose, surface_normals
from twonav_cli.mapping.tile_picture import drawn
from twonav_cli.rng import stream

KEYFRAMES_PER_DRAWING = 10


class GridMapper:
    """Builds a map from readings that are handed to it in order."""

    def __init__(
        self,
        config: MappingConfig,
        sensor: RangeSensor,
        seed: int = 0,
        start: Pose = Pose(0.0, 0.0, 0.0),
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
        self._limit_m = min(config.max_range_m, sensor.max_m)
        self._rng = stream(seed, "mapper")
        self._sink = sink
        self._corner = corner
        self._store = TileStore(config.particles)
        self._poses = np.tile(self._in_cells(start), (config.particles, 1))
        self._log_weights = np.zeros(config.particles)
        self._log_totals = np.zeros(config.particles)
        self._paths = PathTree(config.particles)
        self._best = 0
        self._tracked = start
        self._odom: Pose | None = None
        self._since = Pose(0.0, 0.0, 0.0)
        self._driven_m = self._turned_rad = 0.0
        self._first_s = 0.0
        self._to_map: Pose | None = None

    def add(self, reading: Reading, pose_true: Pose | None = None) -> bool:
        """Take one reading; return whether it went into the map as a keyframe.

        Args:
            reading: Scan and odometry.
            pose_true: The simulator's pose, only passed on to whoever listens.
        """
        if self._odom is None:
            self._odom, self._first_s = reading.pose_odom, reading.stamp_s
            self._to_map = compose(self._tracked, relative_pose(reading.pose_odom, Pose(0.0, 0.0, 0.0)))
            self._first_keyframe(reading, pose_true)
            return True
        moved = relative_pose(self._odom, reading.pose_odom)
        self._odom = reading.pose_odom
        self._since = compose(self._since, moved)
        self._driven_m += math.hypot(moved.x_m, moved.y_m)
        self._turned_rad += abs(moved.theta_rad)
        config = self.config
        points, normals = self._points(reading)
        self._track(moved, points, normals)
        if self._driven_m < config.keyframe_distance_m and self._turned_rad < config.keyframe_turn_rad:
            return False
        self._keyframe(reading, points, normals, pose_true)
        return True

    def pose(self) -> Pose:
        """Where the best particle believes the robot to be at the latest reading."""
        return self._tracked

    def trajectory(self) -> list[StampedPose]:
        """The best particle's pose at every keyframe, with the reading's own stamp."""
        stamps, path = self._paths.path_of(self._best)
        return [StampedPose(stamp, self._in_metres(pose)) for stamp, pose in zip(stamps, path, strict=True)]

    def occupancy(self, frame: GridFrame | None = None) -> OccupancyMap:
        """The map of the best particle, on a frame, or as far as anything was seen.

        Raises:
            TwonavError: The frame's cells do not lie on the mapper's.
        """
        return drawn(self._store, self._best, self.config.resolution_m, self._corner, frame)

    @property
    def map_bytes(self) -> int:
        """Bytes that the maps of all particles take."""
        return self._store.size_bytes

    def _points(self, reading: Reading) -> tuple[FloatArray, FloatArray]:
        """Return the ends of the beams [N, 2] in the robot's frame, in cells, and the directions across surfaces."""
        points_m = points_of(self.sensor, reading.ranges_m, Pose(0.0, 0.0, 0.0), self._limit_m)
        return points_m / self.config.resolution_m, surface_normals(points_m)

    def _rule(self) -> FloatArray:
        config = self.config
        wide, narrow = config.wide_sigma_m / config.resolution_m, config.sigma_m / config.resolution_m
        return np.array([config.evidence, wide, narrow, config.least_match, float(config.proposal == "gaussian")])

    def _track(self, moved: Pose, points: FloatArray, normals: FloatArray) -> None:
        """Follow the robot between keyframes on the best particle's map."""
        guess = compose(self._tracked, moved)
        start = self._in_cells(guess)
        covariance = motion_covariance(self.config, moved, self._tracked.theta_rad)
        store = self._store
        pose, _, share, _ = found_pose(
            store.cells, store.tables[self._best], store.first_row, store.first_col, points, normals,
            start, start, np.linalg.inv(covariance), self._rule(),
        )  # fmt: skip
        self._tracked = self._in_metres(pose) if share >= self.config.least_match else guess

    def _first_keyframe(self, reading: Reading, pose_true: Pose | None) -> None:
        self._paths.grow(reading.stamp_s, self._poses)
        # Every particle believes the same: one map, which all share.
        self._carve(reading, only=0)
        self._store.draw_again(np.zeros(self.config.particles, dtype=np.int64))
        self._tell(reading, np.zeros(self.config.particles), False, pose_true, 0)

    def _keyframe(self, reading: Reading, points: FloatArray, normals: FloatArray, pose_true: Pose | None) -> None:
        config, store = self.config, self._store
        followed = relative_pose(self._in_metres(self._poses[self._best]), self._tracked)
        starts = composed(self._poses, self._relative_in_cells(followed))
        priors = composed(self._poses, self._relative_in_cells(self._since))
        covariances = np.stack([motion_covariance(config, self._since, theta) for theta in self._poses[:, 2]])
        out = np.zeros((config.particles, 5))
        propose(
            store.cells, store.tables, store.first_row, store.first_col, points, normals, starts, priors,
            np.linalg.inv(covariances), np.linalg.cholesky(covariances),
            self._rng.standard_normal((config.particles, 3)), self._rule(), out,
        )  # fmt: skip
        self._poses = np.column_stack([out[:, :2], wrap_angles(out[:, 2])])
        self._log_weights += out[:, 3]
        self._log_totals += out[:, 3]
        weights = normalised(self._log_weights)
        self._best = int(np.argmax(self._log_totals))
        self._carve(reading)
        self._paths.grow(reading.stamp_s, self._poses)
        few = effective_number(weights) < config.resample_share * config.particles
        self._tracked = self._in_metres(self._poses[self._best])
        self._tell(reading, out[:, 4], few, pose_true, int((out[:, 4] < 0).sum()))
        if few:
            self._draw_again(systematic(weights, self._rng))
        self._since = Pose(0.0, 0.0, 0.0)
        self._driven_m = self._turned_rad = 0.0

    def _draw_again(self, parents: NDArray[np.int64]) -> None:
        """Go on with the chosen particles; the best one is found again among them."""
        self._store.draw_again(parents)
        self._poses = self._poses[parents]
        self._log_totals = self._log_totals[parents]
        self._log_weights = np.zeros(len(parents))
        self._paths.draw_again(parents)
        self._best = int(np.argmax(self._log_totals))
        self._tracked = self._in_metres(self._poses[self._best])

    def _carve(self, reading: Reading, only: int | None = None) -> None:
        """Put the scan into the maps, each from its particle's own pose."""
        store, res = self._store, self.config.resolution_m
        hit = usable(reading.ranges_m, self._limit_m)
        mount = self.sensor.mount
        for particle in range(self.config.particles) if only is None else (only,):
            pose = self._in_metres(self._poses[particle])
            at = compose(pose, mount)
            angles = self.sensor.angles_rad[hit] + at.theta_rad
            ranges = reading.ranges_m[hit]
            from_row, from_col = (at.y_m - self._corner[1]) / res, (at.x_m - self._corner[0]) / res
            ends = np.column_stack([from_row + np.sin(angles) * ranges / res, from_col + np.cos(angles) * ranges / res])
            low, high = ends.min(axis=0, initial=min(from_row, from_col)), ends.max(axis=0, initial=max(from_row, from_col))
            low, high = np.minimum(low, (from_row, from_col)), np.maximum(high, (from_row, from_col))
            store.cover(int(low[0]) - 40, int(low[1]) - 40, int(high[0]) + 40, int(high[1]) + 40)
            touched = np.zeros(store.tables.shape[1:], dtype=np.bool_)
            touch(touched, store.first_row, store.first_col, from_row, from_col, ends)
            store.own(particle, touched)
            carve(store.cells, store.tables[particle], store.first_row, store.first_col, from_row, from_col, ends)

    def _tell(
        self, reading: Reading, shares: FloatArray, resampled: bool, pose_true: Pose | None, unmatched: int
    ) -> None:
        """Send what happened at a keyframe."""
        self.keyframes += 1
        weights = normalised(self._log_weights)
        clock = Clock(step=self.keyframes, time_s=reading.stamp_s - self._first_s)
        pose = self._in_metres(self._poses[self._best])
        poses = np.array([self._in_metres(row) for row in self._poses])
        odom = compose(self._to_map, reading.pose_odom) if self._to_map else reading.pose_odom
        hits = points_of(self.sensor, reading.ranges_m, pose, self._limit_m)
        self._sink(
            KeyframeMapped(
                clock, pose, poses, weights, effective_number(weights), resampled, unmatched, hits, odom, pose_true
            )
        )
        if self.keyframes % KEYFRAMES_PER_DRAWING == 1:
            self.draw(clock)

    def draw(self, clock: Clock) -> None:
        """Send the map of the best particle as it is now."""
        if self._sink is to_nobody:
            return
        map_ = self.occupancy()
        path = np.array([stamped.pose for stamped in self.trajectory()])
        self._sink(MapDrawn(clock, map_.pixels, map_.frame, path))

    def _in_cells(self, pose: Pose) -> FloatArray:
        res = self.config.resolution_m
        return np.array([(pose.x_m - self._corner[0]) / res, (pose.y_m - self._corner[1]) / res, pose.theta_rad])

    def _in_metres(self, pose: FloatArray) -> Pose:
        res = self.config.resolution_m
        x_m, y_m = float(pose[0]) * res + self._corner[0], float(pose[1]) * res + self._corner[1]
        return Pose(x_m, y_m, wrap_angle(float(pose[2])))

    def _relative_in_cells(self, motion: Pose) -> FloatArray:
        res = self.config.resolution_m
        return np.array([motion.x_m / res, motion.y_m / res, motion.theta_rad])
