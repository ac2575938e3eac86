"""What one picture says about the pose: places and headings it could be, how likely each is and how precisely known.

K places, J headings, N poses; rows, cols of the grid.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from twonav_cli.geometry import FloatArray, Pose, wrap_angle, wrap_angles
from twonav_cli.grid import GridFrame


@dataclass(frozen=True)
class Belief:
    """A belief over poses, p(x, y) p(theta): round bells around places and around headings, over an even floor.

    Attributes:
        places: [K, 4] weight, x_m, y_m, sigma_m (deviation along each axis), highest peak first; weights add up to 1.
        headings: [J, 3] weight, theta_rad, sigma_rad, highest peak first; weights add up to 1.
        lost: Share of the belief that is spread evenly over `area_m2` and all headings, whatever the picture shows.
        area_m2: Floor on which the robot can be.
        grid: [rows, cols] float32 probability of each position bin, as the network gives it: for pictures.
        frame: Where the bins lie.
    """

    places: FloatArray
    headings: FloatArray
    lost: float
    area_m2: float
    grid: NDArray[np.float32]
    frame: GridFrame

    @property
    def pose(self) -> Pose:
        """The place and the heading of the highest peaks."""
        return Pose(float(self.places[0, 1]), float(self.places[0, 2]), wrap_angle(float(self.headings[0, 1])))

    @property
    def confidence(self) -> float:
        """Probability of that place, 0 to 1."""
        return float((1.0 - self.lost) * self.places[0, 0])

    def place_density(self, points: FloatArray) -> FloatArray:
        """Return the density [N] per square metre at points [N, 2]."""
        weight, x_m, y_m, sigma_m = self.places.T
        squared = (points[:, :1] - x_m) ** 2 + (points[:, 1:2] - y_m) ** 2
        bells = weight / (2 * np.pi * sigma_m**2) * np.exp(-0.5 * squared / sigma_m**2)
        return np.asarray((1.0 - self.lost) * bells.sum(axis=1) + self.lost / self.area_m2)

    def heading_density(self, angles_rad: FloatArray) -> FloatArray:
        """Return the density [N] per radian at angles [N]."""
        weight, theta_rad, sigma_rad = self.headings.T
        away_rad = wrap_angles(angles_rad[:, None] - theta_rad)
        bells = weight / (np.sqrt(2 * np.pi) * sigma_rad) * np.exp(-0.5 * (away_rad / sigma_rad) ** 2)
        return np.asarray((1.0 - self.lost) * bells.sum(axis=1) + self.lost / (2 * np.pi))

    def density(self, poses: FloatArray) -> FloatArray:
        """Return the density [N] per square metre and radian at poses [N, 3]."""
        return self.place_density(poses[:, :2]) * self.heading_density(poses[:, 2])

    def sample(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Draw poses [N, 3] from the bells; the even floor is left out, since this knows no map."""
        place = self.places[rng.choice(len(self.places), size=count, p=_shares(self.places[:, 0]))]
        heading = self.headings[rng.choice(len(self.headings), size=count, p=_shares(self.headings[:, 0]))]
        noise = rng.standard_normal((count, 3))
        spread = np.column_stack([place[:, 3], place[:, 3], heading[:, 2]])
        poses = np.column_stack([place[:, 1:3], heading[:, 1]]) + spread * noise
        poses[:, 2] = wrap_angles(poses[:, 2])
        return poses


def _shares(weights: FloatArray) -> FloatArray:
    return np.asarray(weights / weights.sum())
