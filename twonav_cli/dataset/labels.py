"""Where a frame was taken, as the robot itself finds it: the scan taken with the picture, matched with its map (§4.2).

The simulator's pose never becomes a label: it only stands for where the robot has driven to, give or take the odometry
since the label before.
"""

from __future__ import annotations

from twonav_cli.geometry import Pose, distance_m, wrap_angle
from twonav_cli.mapping.floor import Floor
from twonav_cli.mapping.relocate import MapMatcher
from twonav_cli.mapping.survey_body import noisy_ranges, sensor_of
from twonav_cli.mapping.survey_config import SurveyConfig
from twonav_cli.rng import stream
from twonav_cli.scene.laser import RangeFinder

GUESS_M, GUESS_RAD = 0.05, 0.05
"""How far the robot's own guess is off before it looks, one standard deviation (ours: more than odometry errs on the
25 cm from one place to the next)."""

FARTHEST = 5.0
"""A match that is more standard deviations from the guess is another place that looks alike (ours)."""


class MapLabels:
    """Labels the place where the robot stands in the simulator."""

    def __init__(self, floor: Floor, laser: RangeFinder, seed: int) -> None:
        """Take over the robot's map.

        Args:
            floor: Whose map is matched with.
            laser: Of the world in which the frames are taken.
            seed: Of the noise of ranges and guesses; a frame's noise depends on its number alone.
        """
        self._laser = laser
        self._seed = seed
        self._noise_m = SurveyConfig().range_noise_m
        self._matcher = MapMatcher(floor.map, sensor_of(laser), floor.walls)

    def __call__(self, index: int, pose: Pose) -> Pose | None:
        """Return where the robot finds itself to be; None where the scan fits nothing near the guess.

        Args:
            index: Of the frame.
            pose: Where the robot was put just now.
        """
        rng = stream(self._seed, "labels", index)
        ranges_m = noisy_ranges(self._laser.scan(), self._laser.max_m, self._noise_m, rng)
        x, y, turn = (float(value) for value in rng.standard_normal(3))
        guess = Pose(
            pose.x_m + GUESS_M * x, pose.y_m + GUESS_M * y, wrap_angle(pose.theta_rad + GUESS_RAD * turn)
        )  # fmt: skip
        found = self._matcher.match(ranges_m, guess)
        return found if found is not None and _agree(found, guess) else None


def _agree(found: Pose, guess: Pose) -> bool:
    """Return whether a match is as near to the guess as odometry lets it be."""
    turned_rad = abs(wrap_angle(found.theta_rad - guess.theta_rad))
    return distance_m(found, guess) < FARTHEST * GUESS_M and turned_rad < FARTHEST * GUESS_RAD
