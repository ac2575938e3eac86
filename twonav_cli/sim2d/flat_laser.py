"""The range finder of the 2D simulator: beams through the pixels of the map, exact to the pixel's border.

rows x cols pixels.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.navigation.costmap import LASER_X_M
from twonav_cli.navigation.footprint import FloatArray, WindowGrid

BEAMS = 180


@compiled
def cast_beam(
    occupied: NDArray[np.bool_], grid: WindowGrid, x_m: float, y_m: float, angle_rad: float, max_m: float
) -> float:
    """Return how far a beam gets before it enters an occupied pixel, at most `max_m` (Amanatides and Woo 1987)."""
    rows, cols = occupied.shape
    u, v = (x_m - grid.x_min_m) / grid.resolution_m, (y_m - grid.y_min_m) / grid.resolution_m
    du, dv = math.cos(angle_rad), math.sin(angle_rad)
    col, up = math.floor(u), math.floor(v)
    step_col, step_up = 1 if du > 0.0 else -1, 1 if dv > 0.0 else -1
    per_col, per_up = 1.0 / max(abs(du), 1e-12), 1.0 / max(abs(dv), 1e-12)
    to_col = (col + 1.0 - u if du > 0.0 else u - col) * per_col
    to_up = (up + 1.0 - v if dv > 0.0 else v - up) * per_up
    gone, most = 0.0, max_m / grid.resolution_m
    while gone < most:
        if 0 <= up < rows and 0 <= col < cols and occupied[rows - 1 - up, col]:
            return gone * grid.resolution_m
        if to_col < to_up:
            gone, to_col, col = to_col, to_col + per_col, col + step_col
        else:
            gone, to_up, up = to_up, to_up + per_up, up + step_up
    return max_m


@compiled
def fill_scan(
    occupied: NDArray[np.bool_],
    distance_m: FloatArray,
    grid: WindowGrid,
    pose: tuple[float, float, float],
    max_m: float,
    scan_m: FloatArray,
) -> None:
    """Write the ranges [180] from the right (-90 degrees) to the left (+90) of a robot at a pose.

    Args:
        occupied: [rows, cols] the map.
        distance_m: [rows, cols] from each pixel to the nearest occupied one: with nothing near no beam is cast.
        grid: Where the map lies.
        pose: x_m, y_m, theta_rad of the axle's middle.
        max_m: Range at which beams end.
        scan_m: [180] written.
    """
    x, y = pose[0] + LASER_X_M * math.cos(pose[2]), pose[1] + LASER_X_M * math.sin(pose[2])
    rows, cols = occupied.shape
    col, up = math.floor((x - grid.x_min_m) / grid.resolution_m), math.floor((y - grid.y_min_m) / grid.resolution_m)
    # Laser and wall may lie half a diagonal from the centres of their pixels.
    near = 0 <= up < rows and 0 <= col < cols and distance_m[rows - 1 - up, col] <= max_m + 1.4143 * grid.resolution_m
    for beam in range(scan_m.shape[0]):
        angle = pose[2] - 0.5 * np.pi + np.pi * beam / (scan_m.shape[0] - 1)
        scan_m[beam] = cast_beam(occupied, grid, x, y, angle, max_m) if near else max_m
