"""The map that a perfect survey would give: which 5 cm pixels hold anything that the robot could run into.

MuJoCo's own collision detection is asked, so every kind of geom counts exactly as it stops the robot. A block of
columns, one per pixel, is moved over the map on a free joint: two bodies that stand still never collide.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import OBSTACLE_FLOOR_M, ROBOT_HEIGHT_M
from twonav_cli.errors import TwonavError
from twonav_cli.grid import GridFrame
from twonav_cli.scene.compiled_scene import LOAD_ERRORS, one_line
from twonav_cli.scene.engine import mujoco

if TYPE_CHECKING:
    from twonav_cli.scene.catalog import Scene

BLOCK_PX = 8
"""Edge of the block in pixels; contacts of 64 columns are found in one call."""

GAP_M = 1e-4
"""A column is narrower than its pixel by this on each side: a wall on the border belongs to one pixel only."""

PROBE = "twonav-probe"
EVERY_BIT = 2**31 - 1
CONTACT_MEMORY_BYTES = 2**27


def occupied_from_geometry(scene: Scene, frame: GridFrame) -> NDArray[np.bool_]:
    """Return which pixels [rows, cols] hold something between 0.03 m and the robot's height above the floor.

    Raises:
        TwonavError: MuJoCo refuses the scene.
    """
    model, data = _compiled_with_probe(scene, frame.resolution_m)
    first = int(model.body(PROBE).geomadr[0])
    address = int(model.joint(PROBE).qposadr[0])
    height_m = scene.floor_z_m + (OBSTACLE_FLOOR_M + ROBOT_HEIGHT_M) / 2
    rows = -(-frame.rows // BLOCK_PX)
    cols = -(-frame.cols // BLOCK_PX)
    occupied = np.zeros((rows * BLOCK_PX, cols * BLOCK_PX), dtype=np.bool_)
    size_m = BLOCK_PX * frame.resolution_m
    for row in range(rows):
        for col in range(cols):
            x_m = frame.x_min_m + (col + 0.5) * size_m
            y_m = frame.y_max_m - (row + 0.5) * size_m
            data.qpos[address : address + 3] = (x_m, y_m, height_m)
            mujoco.mj_kinematics(model, data)
            mujoco.mj_comPos(model, data)
            mujoco.mj_collision(model, data)
            if data.ncon:
                block = _columns_hit(data, first).reshape(BLOCK_PX, BLOCK_PX)
                occupied[row * BLOCK_PX : (row + 1) * BLOCK_PX, col * BLOCK_PX : (col + 1) * BLOCK_PX] = block
    return occupied[: frame.rows, : frame.cols]


def _columns_hit(data: Any, first: int) -> NDArray[np.bool_]:
    """Return which columns [64] something reaches into."""
    hit = np.zeros(BLOCK_PX * BLOCK_PX, dtype=np.bool_)
    inside = np.asarray(data.contact.dist)[: data.ncon] < 0
    columns = np.asarray(data.contact.geom)[: data.ncon][inside].ravel() - first
    hit[columns[(columns >= 0) & (columns < hit.size)]] = True
    return hit


def _compiled_with_probe(scene: Scene, resolution_m: float) -> tuple[Any, Any]:
    """Return model and state of the scene with the block of columns, row by row from the top left."""
    half_m = resolution_m / 2 - GAP_M
    half_height_m = (ROBOT_HEIGHT_M - OBSTACLE_FLOOR_M) / 2 - GAP_M
    offsets_m = (np.arange(BLOCK_PX) - (BLOCK_PX - 1) / 2) * resolution_m
    try:
        spec = mujoco.MjSpec.from_file(str(scene.xml_path))
        spec.option.disableflags = 0
        spec.memory = CONTACT_MEMORY_BYTES
        body = spec.worldbody.add_body(name=PROBE)
        body.add_freejoint(name=PROBE)
        for y_m in offsets_m[::-1]:
            for x_m in offsets_m:
                body.add_geom(
                    type=mujoco.mjtGeom.mjGEOM_BOX,
                    size=(half_m, half_m, half_height_m),
                    pos=(x_m, y_m, 0.0),
                    mass=1.0,
                    contype=EVERY_BIT,
                    conaffinity=EVERY_BIT,
                    condim=1,
                )
        model = spec.compile()
        return model, mujoco.MjData(model)
    except LOAD_ERRORS as error:
        raise TwonavError(f"{scene.xml_path} cannot be loaded to make its map: {one_line(error)}") from error
