"""The range finder: 180 beams in the plane of the laser, cast when a scan is wanted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from twonav_cli.scene.engine import mujoco
from twonav_cli.scene.robot import PREFIX

if TYPE_CHECKING:
    from twonav_cli.scene.world import World

FloatArray = NDArray[np.float64]

BEAMS = 180
BEAM_ANGLES_RAD: FloatArray = np.linspace(-np.pi / 2, np.pi / 2, BEAMS)
"""[180] direction of each beam in the robot's frame, from the right (-90 degrees) to the left (+90 degrees)."""


class RangeFinder:
    """Measures distances from the laser (0.02 m ahead of the axle, 0.30 m high); the robot does not see itself."""

    def __init__(self, world: World, max_m: float = 8.0) -> None:
        self._world = world
        self.max_m = max_m
        self._site = world.model.site(PREFIX + "laser").id
        self._directions = np.stack([np.cos(BEAM_ANGLES_RAD), np.sin(BEAM_ANGLES_RAD), np.zeros(BEAMS)])  # [3, 180]
        self._groups = _groups_of_solids(world)
        self._geoms = np.empty(BEAMS, dtype=np.int32)
        self._ranges_m = np.empty(BEAMS, dtype=np.float64)

    def scan(self) -> FloatArray:
        """Return the distance [180] along each beam; `max_m` where nothing is hit within it."""
        data = self._world.data
        rotation = data.site_xmat[self._site].reshape(3, 3)
        vectors = np.ascontiguousarray((rotation @ self._directions).T).reshape(-1)
        mujoco.mj_multiRay(
            self._world.model,
            data,
            data.site_xpos[self._site],
            vectors,
            self._groups,
            True,
            self._world.chassis_id,
            self._geoms,
            self._ranges_m,
            None,
            BEAMS,
            self.max_m,
        )
        return np.where((self._ranges_m < 0) | (self._ranges_m > self.max_m), self.max_m, self._ranges_m)


def _groups_of_solids(world: World) -> NDArray[np.uint8]:
    """Return which of the six geom groups [6] hold anything that the robot can run into.

    Beams are cast at these only: a scene that draws with one group and collides with another has each wall twice, and
    rays at drawn meshes cost three times as much.
    """
    model = world.model
    others = np.asarray(model.body_rootid)[np.asarray(model.geom_bodyid)] != world.chassis_id
    solid = (np.asarray(model.geom_contype) | np.asarray(model.geom_conaffinity)) != 0
    groups = np.zeros(6, dtype=np.uint8)
    groups[np.clip(np.asarray(model.geom_group)[others & solid], 0, 5)] = 1
    return groups
