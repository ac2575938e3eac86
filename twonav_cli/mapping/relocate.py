"""Where a robot is on a finished map: one scan, matched near a guess.

N beams that hit something, K wall points.
"""

from __future__ import annotations

import numpy as np

from twonav_cli.config import MappingConfig
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cell_units import CellUnits
from twonav_cli.mapping.cells import TileStore
from twonav_cli.mapping.look_around import found_pose
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.scan import RangeSensor, points_of
from twonav_cli.mapping.scan_match import matching_rule
from twonav_cli.mapping.surface_normals import surface_normals

GUESS_M, GUESS_RAD = 0.1, 0.1
"""How far a guess may be off, one standard deviation (ours)."""

ORIGIN = Pose(0.0, 0.0, 0.0)


class MapMatcher:
    """Matches scans with one map that stays as it is."""

    def __init__(self, map_: OccupancyMap, sensor: RangeSensor, walls: FloatArray | None = None) -> None:
        """Take over a map.

        Args:
            map_: Gives the cells.
            sensor: What measures the ranges.
            walls: [K, 2] points on the walls, metres, as `GridMapper.walls` gives them; without them the middles of the
                occupied pixels, which are up to half a pixel off.
        """
        self.sensor = sensor
        self._units = CellUnits(map_.frame.resolution_m, (map_.frame.x_min_m, map_.frame.y_min_m))
        points = _middles(map_) if walls is None else walls
        self._store = TileStore(1)
        # A beam of no length hits where it begins: every point becomes a cell that was hit once.
        for x_m, y_m in points.tolist():
            carve_scan(self._store, 0, self._units.of_pose(Pose(x_m, y_m, 0.0)), np.zeros((1, 2)))
        config = MappingConfig(resolution_m=self._units.resolution_m)
        self._rule, self._limit_m, self._least = matching_rule(config), config.max_range_m, config.least_match
        off = GUESS_M / self._units.resolution_m
        self._information = np.diag([off**-2, off**-2, GUESS_RAD**-2])

    def match(self, ranges_m: FloatArray, guess: Pose) -> Pose | None:
        """Return the robot's pose at which a scan [B] fits best near a guess; None where it does not fit."""
        points_m = points_of(self.sensor, ranges_m, ORIGIN, self._limit_m)
        if not len(points_m):
            return None
        found = found_pose(
            self._store.map_of(0), points_m / self._units.resolution_m, surface_normals(points_m),
            [self._units.of_pose(guess)], self._information, self._rule,
        )  # fmt: skip
        return self._units.pose(found.pose) if found.share >= self._least else None


def _middles(map_: OccupancyMap) -> FloatArray:
    """Return the middles [K, 2] of the occupied pixels, metres."""
    rows, cols = np.nonzero(map_.occupied)
    xs_m, ys_m = map_.frame.centres()
    return np.stack([xs_m[cols], ys_m[rows]], axis=1)
