"""Driven tracks: what the robot sees and what its odometry reports on its way, with the true poses beside them.

The robot drives along shortest ways of the maze between random places; the controller knows the true pose, so that the
tracks do not depend on a localizer. N frames.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import IMAGE_PX, DriveConfig, OdometryNoise
from twonav_cli.dataset.poses import random_poses
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose, Twist, compose, distance_m
from twonav_cli.grid import Cell
from twonav_cli.mapping.floor import Floor
from twonav_cli.maze import Action
from twonav_cli.navigation.cell_driver import CellDriver
from twonav_cli.navigation.outcomes import REACHED
from twonav_cli.rng import stream
from twonav_cli.scene.camera import Camera
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.robot_body import RobotBody
from twonav_cli.scene.world import World

LOOK_EVERY_TICKS = 4
"""Control periods from one look to the next: 0.4 s, in which the robot drives up to 0.24 m (ours; about two looks in
each cell, while a picture and its estimate take a few milliseconds)."""

TRACK_FRAMES = 250
"""Frames of a track, after which the robot begins another one somewhere else (ours)."""

CARRIED_AT_LEAST_M = 1.0
"""A robot that is carried off comes down at least this far away (ours): nearer it would hardly count as lost."""

FAILURES_AT_MOST = 3
"""Actions in a row that fail before the robot is put somewhere else, which begins another track (ours)."""

PLACES = 4096
"""Random poses that a drive draws its starts from, and where it carries the robot to."""

STILL = Pose(0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Tracks:
    """Frames in the order in which they were taken.

    Attributes:
        images: [N, 84, 84, 3] uint8 RGB.
        poses: [N, 3] true poses, map frame.
        motions: [N, 3] what odometry reported since the frame before, in the robot's frame then; nothing at the first
            frame of a track, and nothing of being carried off.
        track: [N] number of the track that a frame belongs to.
        kidnapped: [N] whether the robot was carried off between the frame before and this one.
    """

    images: NDArray[np.uint8]
    poses: FloatArray
    motions: FloatArray
    track: NDArray[np.int64]
    kidnapped: NDArray[np.bool_]

    @property
    def begins(self) -> NDArray[np.bool_]:
        """Which frames [N] are the first of their track."""
        return np.concatenate([[True], np.diff(self.track) != 0])[: len(self.track)]


@dataclass
class _Film:
    """The frames so far, at most as many as are wanted."""

    frames: int
    images: list[NDArray[np.uint8]] = field(default_factory=list)
    poses: list[Pose] = field(default_factory=list)
    motions: list[Pose] = field(default_factory=list)
    track: list[int] = field(default_factory=list)
    kidnapped: list[bool] = field(default_factory=list)

    @property
    def full(self) -> bool:
        return len(self.poses) >= self.frames

    def tracks(self) -> Tracks:
        return Tracks(
            np.array(self.images, dtype=np.uint8).reshape(-1, IMAGE_PX, IMAGE_PX, 3),
            np.array(self.poses, dtype=np.float64).reshape(-1, 3),
            np.array(self.motions, dtype=np.float64).reshape(-1, 3),
            np.array(self.track, dtype=np.int64),
            np.array(self.kidnapped, dtype=np.bool_),
        )


class _FilmingBody:
    """The robot's body, which takes a frame every few control periods; implements the cell driver's `Body`."""

    def __init__(self, body: RobotBody, camera: Camera, film: _Film, told: Callable[[int, int], None]) -> None:
        self.body = body
        self.film = film
        self._camera = camera
        self._told = told
        self._moved, self._ticks, self._track = STILL, 0, -1

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Command a twist for one control period."""
        self.body.drive(twist, duration_s)
        self._ticks += 1

    def odometry(self) -> Pose:
        """Return what the wheels report, add it up, and look if it is time to."""
        reported = self.body.odometry()
        self._moved = compose(self._moved, reported)
        if self._ticks >= LOOK_EVERY_TICKS:
            self._look(carried=False)
        return reported

    def scan(self) -> FloatArray:
        """Return ranges [180]."""
        return self.body.scan()

    def twist(self) -> Twist:
        """Return how it moves now."""
        return self.body.twist()

    def begin(self, pose: Pose) -> None:
        """Begin another track somewhere."""
        self._put(pose)
        self._track += 1
        self._moved = STILL
        self._look(carried=False)

    def carry(self, pose: Pose) -> None:
        """Carry the robot off, which odometry does not notice."""
        self._put(pose)
        self._look(carried=True)

    def _put(self, pose: Pose) -> None:
        self.body.world.place(pose)
        self.body.settle()

    def _look(self, carried: bool) -> None:
        film, self._ticks = self.film, 0
        if film.full:
            return
        film.images.append(self._camera.image())
        film.poses.append(self.body.world.pose())
        film.motions.append(self._moved)
        film.track.append(self._track)
        film.kidnapped.append(carried)
        self._moved = STILL
        self._told(len(film.poses), film.frames)


def drive_tracks(
    floor: Floor,
    seed: int,
    frames: int,
    kidnap_every: int = 0,
    base: str = "omni",
    progress: Callable[[int, int], None] = lambda done, wanted: None,
) -> Tracks:
    """Drive through a scene and return every frame.

    Args:
        floor: Scene, map and maze.
        seed: Places, goals and the odometry's noise have streams of their own.
        frames: Frames to take.
        kidnap_every: Frames after which the robot is carried off, at the end of its action; 0: never.
        base: "omni" or "differential".
        progress: Told (frames taken, frames wanted).

    Raises:
        TwonavError: No renderer, nothing asked for, or the robot fits nowhere.
    """
    if frames < 1 or kidnap_every < 0:
        raise TwonavError(f"{frames} frames with a kidnap every {kidnap_every}: give a positive number of frames")
    world = World(floor.scene, base)
    camera = Camera(world)
    body = RobotBody(world, RangeFinder(world), OdometryNoise(), stream(seed, "track odometry"))
    try:
        filming = _FilmingBody(body, camera, _Film(frames), progress)
        _Walk(floor, filming, CellDriver(DriveConfig(), base, floor.map.occupied, floor.map.frame), seed).run(
            kidnap_every
        )
    finally:
        camera.close()
    return filming.film.tracks()


class _Walk:
    """Where the robot goes."""

    def __init__(self, floor: Floor, body: _FilmingBody, driver: CellDriver, seed: int) -> None:
        self._maze, self._frame = floor.maze, floor.maze_frame
        self._body, self._driver = body, driver
        self._rng = stream(seed, "track places")
        starts = list(floor.scene.starts.values())
        drawn = random_poses(~floor.map.free, floor.map.frame, starts, PLACES, stream(seed, "track poses"))
        poses = [Pose(*pose) for pose in drawn.tolist()]
        self._poses = [pose for pose in poses if not self._maze.blocked[self._cell_of(pose)]]
        if not self._poses:
            raise TwonavError("the robot can be at no free cell of the maze: check the scene's starts")

    def run(self, kidnap_every: int) -> None:
        """Drive until there are frames enough."""
        film = self._body.film
        while not film.full:
            first = since = len(film.poses)
            self._body.begin(self._drawn_pose())
            failures = 0
            while not film.full and failures < FAILURES_AT_MOST and len(film.poses) - first < TRACK_FRAMES:
                if kidnap_every and len(film.poses) - since >= kidnap_every:
                    since = len(film.poses)
                    self._body.carry(self._pose_far_off())
                reached = self._go_somewhere(until=min(first + TRACK_FRAMES, since + (kidnap_every or TRACK_FRAMES)))
                failures = 0 if reached else failures + 1

    def _go_somewhere(self, until: int) -> bool:
        """Drive to a random cell, cell by cell, and return whether nothing went wrong; end early at some frame."""
        cell = self._cell_of(self._here())
        cells = self._maze.free_cells
        goal = cells[int(self._rng.integers(len(cells)))]
        distances = self._maze.distances_to(goal)
        if self._maze.blocked[cell] or not self._reaches(cell):
            return False
        while cell != goal and len(self._body.film.poses) < until and not self._body.film.full:
            nearer = [n for a in Action if distances[n := self._maze.moved(cell, a)] == distances[cell] - 1]
            cell = nearer[int(self._rng.integers(len(nearer)))]
            if not self._reaches(cell):
                return False
        return True

    def _reaches(self, cell: Cell) -> bool:
        outcome, _ = self._driver.drive_to(self._body, self._here(), self._frame.centre_of(cell))
        return outcome == REACHED

    def _here(self) -> Pose:
        return self._body.body.world.pose()

    def _cell_of(self, pose: Pose) -> Cell:
        return self._frame.cell_at(pose.x_m, pose.y_m)

    def _drawn_pose(self) -> Pose:
        return self._poses[int(self._rng.integers(len(self._poses)))]

    def _pose_far_off(self) -> Pose:
        """Return a pose away from here, or the farthest one where there is none."""
        here = self._here()
        far = [pose for pose in self._poses if distance_m(here, pose) >= CARRIED_AT_LEAST_M]
        if not far:
            return max(self._poses, key=lambda pose: distance_m(here, pose))
        return far[int(self._rng.integers(len(far)))]
