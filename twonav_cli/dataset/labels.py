"""Where a frame was taken, as the robot itself finds it: the scan taken with the picture, matched with its map (§4.2).

The simulator's pose never becomes a label. On the way from frame to frame the robot knows its odometry, and where a
scan does not fit, odometry is all it has (§4.1).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import FloatArray, Pose, compose, distance_m, relative_pose, wrap_angle
from twonav_cli.mapping.floor import Floor
from twonav_cli.mapping.relocate import MapMatcher
from twonav_cli.mapping.survey_body import noisy_ranges, sensor_of
from twonav_cli.mapping.survey_config import SurveyConfig
from twonav_cli.motion import noisy_motion
from twonav_cli.rng import stream
from twonav_cli.scene.laser import RangeFinder

GUESS_M, GUESS_RAD = 0.05, 0.05
"""How far the robot's own guess is off where it was set down, one standard deviation (ours: more than odometry errs on
the 25 cm from one place to the next)."""

WAYPOINTS_FROM = 2**40
"""Numbers from here on are those of waypoints: no frame has one so high."""

WAYPOINTS_AT_MOST = 4096
"""Numbers that are kept for the waypoints of one way."""

FARTHEST = 5.0
"""A match that is more standard deviations from the guess is another place that looks alike (ours)."""


class MapLabels:
    """Finds the robot on its own map: set down somewhere, or on its way."""

    def __init__(self, floor: Floor, laser: RangeFinder, seed: int) -> None:
        """Take over the robot's map.

        Args:
            floor: Whose map is matched with.
            laser: Of the world in which the frames are taken.
            seed: Of the noise of ranges, guesses and odometry; a frame's noise depends on its number alone.
        """
        self._laser = laser
        self._seed = seed
        self._range_noise_m = SurveyConfig().range_noise_m
        self._odometry_noise = OdometryNoise()
        self._matcher = MapMatcher(floor.map, sensor_of(laser), floor.walls)

    def set_down(self, index: int, pose: Pose) -> Pose | None:
        """Return where the robot finds itself to be; None where the scan fits nothing near the guess.

        Args:
            index: Of the frame.
            pose: Where the robot was put just now.
        """
        rng = stream(self._seed, "labels", index)
        return self._match(_disturbed(pose, rng), rng)

    def on_the_way(self, index: int, believed: Pose, before: Pose, now: Pose) -> tuple[Pose, bool]:
        """Return where the robot finds itself to be after a motion, and whether the scan says so.

        Args:
            index: Of the frame, or of the waypoint.
            believed: Where it believed to be before.
            before: Where it was.
            now: Where it was moved just now.
        """
        rng = stream(self._seed, "labels", index)
        guess = compose(believed, noisy_motion(relative_pose(before, now), self._odometry_noise, rng))
        found = self._match(guess, rng)
        return (guess, False) if found is None else (found, True)

    def guessing(self, index: int) -> np.random.Generator:
        """Return the stream from which a robot guesses where it is that nothing tells it."""
        return stream(self._seed, "guesses", index)

    def _match(self, guess: Pose, rng: np.random.Generator) -> Pose | None:
        ranges_m = noisy_ranges(self._laser.scan(), self._laser.max_m, self._range_noise_m, rng)
        found = self._matcher.match(ranges_m, guess)
        return found if found is not None and _agree(found, guess) else None


class TourLabels:
    """Labels the frames of one cell of the tour: the robot comes along the way, then turns on the spot."""

    def __init__(self, labels: MapLabels, place: Callable[[Pose], None], first: int, way: FloatArray) -> None:
        """Come to the cell.

        Args:
            labels: Match scans.
            place: Moves the robot in the simulator.
            first: Number of the cell's first frame.
            way: [W, 2] points of the way, metres; it begins where the robot was left in the cell before.
        """
        self._labels = labels
        self._at, *following = _poses_on(way)
        place(self._at)
        index = WAYPOINTS_FROM + first * WAYPOINTS_AT_MOST
        self._believed = labels.set_down(index, self._at) or _disturbed(self._at, labels.guessing(first))
        for number, pose in enumerate(following, start=1):
            place(pose)
            index = WAYPOINTS_FROM + first * WAYPOINTS_AT_MOST + number
            self._believed, _ = labels.on_the_way(index, self._believed, self._at, pose)
            self._at = pose

    def __call__(self, index: int, pose: Pose) -> Pose | None:
        """Return the label of a frame whose picture is taken now; None where only odometry knows.

        Args:
            index: Of the frame.
            pose: Where the robot was turned to just now.
        """
        self._believed, seen = self._labels.on_the_way(index, self._believed, self._at, pose)
        self._at = pose
        return self._believed if seen else None


def _poses_on(way: FloatArray) -> list[Pose]:
    """Return the poses on a way [W, 2], each in the direction of travel; the last keeps the heading it came with."""
    if len(way) == 1:
        return [Pose(float(way[0, 0]), float(way[0, 1]), 0.0)]
    steps = np.diff(way, axis=0)
    headings = np.arctan2(steps[:, 1], steps[:, 0])
    headings = np.concatenate([headings, headings[-1:]])
    return [Pose(float(x), float(y), float(theta)) for (x, y), theta in zip(way, headings, strict=True)]


def _disturbed(pose: Pose, rng: np.random.Generator) -> Pose:
    """Return a guess that is off as far as a guess is."""
    x, y, turn = (float(value) for value in rng.standard_normal(3))
    return Pose(pose.x_m + GUESS_M * x, pose.y_m + GUESS_M * y, wrap_angle(pose.theta_rad + GUESS_RAD * turn))


def _agree(found: Pose, guess: Pose) -> bool:
    """Return whether a match is as near to the guess as odometry lets it be."""
    turned_rad = abs(wrap_angle(found.theta_rad - guess.theta_rad))
    return distance_m(found, guess) < FARTHEST * GUESS_M and turned_rad < FARTHEST * GUESS_RAD
