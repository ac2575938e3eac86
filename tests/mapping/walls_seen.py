"""Walls in a map and a scan of them, without a range finder: for tests of scan matching. Lengths are in cells."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from twonav_cli.config import MappingConfig
from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cells import CellMap, TileStore
from twonav_cli.mapping.scan_match import matching_rule

RULE = matching_rule(MappingConfig())
TRUE = np.array([3.3, -4.6, 0.4])
"""[3] where the robot is."""

LOOSE = np.diag([0.5**2, 0.5**2, 15.0**2])
"""[3, 3] inverse covariance of an odometry that may be off by 2 cells and 4 degrees."""


class Scene(NamedTuple):
    """A map with walls in it and what a robot at TRUE sees of them."""

    store: TileStore
    points: FloatArray
    """[N, 2] ends in the robot's frame."""
    normals: FloatArray
    """[N, 2]."""

    @property
    def grid(self) -> CellMap:
        """The map of particle 0."""
        return self.store.map_of(0)


def by(x: float, y: float, turn_rad: float) -> FloatArray:
    """Return how far a pose [3] is off, map directions."""
    return np.array([x, y, turn_rad])


def line(begin: tuple[float, float], end: tuple[float, float], gap: float = 0.9) -> FloatArray:
    """Return points [N, 2] along a wall."""
    count = int(np.hypot(end[0] - begin[0], end[1] - begin[1]) / gap)
    return np.linspace(begin, end, count)


def scene_of(walls: list[FloatArray], particles: int = 1) -> Scene:
    """Return the scene of straight walls [N, 2] each; every point of them was hit once, and is seen."""
    store = TileStore(particles)
    for x, y in np.concatenate(walls).tolist():
        carve_scan(store, 0, np.array([x, y, 0.0]), np.zeros((1, 2)))
    store.draw_again(np.zeros(particles, dtype=np.int64))
    across = []
    for wall in walls:
        along = (wall[-1] - wall[0]) / np.hypot(*(wall[-1] - wall[0]))
        across.append(np.tile([-along[1], along[0]], (len(wall), 1)))
    cos, sin = np.cos(TRUE[2]), np.sin(TRUE[2])
    turn = np.array([[cos, -sin], [sin, cos]])  # rows times this are the map's directions in the robot's frame
    return Scene(store, (np.concatenate(walls) - TRUE[:2]) @ turn, np.concatenate(across) @ turn)


def corner(particles: int = 1) -> Scene:
    """Return a corner of two walls of 3 m, at 0.37 of a cell."""
    return scene_of([line((-30.0, 40.37), (30.37, 40.37)), line((30.37, 39.5), (30.37, -20.0))], particles)


def corridor() -> Scene:
    """Return two long walls along x, at 0.37 of a cell; what was hit and what is seen are different points of them."""
    rng = np.random.default_rng(0)
    heights = (20.37, -20.63)
    store = scene_of([np.stack([rng.uniform(-200, 200, 900), np.full(900, y)], axis=1) for y in heights]).store
    seen = scene_of([np.stack([np.sort(rng.uniform(-60, 60, 60)), np.full(60, y)], axis=1) for y in heights])
    return Scene(store, seen.points, seen.normals)
