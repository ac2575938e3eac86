"""The world of the 2D simulator: what is occupied on the map, and how far everything is from it.

rows x cols pixels of the map.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.grid import GridFrame
from twonav_cli.navigation.distance import distances_m
from twonav_cli.navigation.footprint import FloatArray, Footprint, WindowGrid, robot_footprint


class FlatWorld(NamedTuple):
    """A map and a robot on it."""

    occupied: NDArray[np.bool_]
    """[rows, cols]"""
    distance_m: FloatArray
    """[rows, cols] from each pixel's centre to the nearest occupied pixel's centre."""
    grid: WindowGrid
    robot: Footprint
    """The true outline, not grown as the controller's."""
    omni: bool


def flat_world(occupied: NDArray[np.bool_], frame: GridFrame, base: str) -> FlatWorld:
    """Return the world that a map [rows, cols] stands for, for a base ("omni" or "differential")."""
    pixels = np.ascontiguousarray(occupied, dtype=np.bool_)
    grid = WindowGrid(frame.x_min_m, frame.y_min_m, frame.resolution_m)
    return FlatWorld(
        pixels, distances_m(pixels, frame.resolution_m), grid, robot_footprint(grown_m=0.0), base == "omni"
    )
