"""The robot's camera: 84 x 84 pictures, drawn without shadows and reflections."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import IMAGE_PX
from twonav_cli.errors import TwonavError
from twonav_cli.scene.engine import choose_renderer, install_command, mujoco
from twonav_cli.scene.robot import PREFIX

if TYPE_CHECKING:
    from twonav_cli.scene.world import World

__all__ = ["Camera", "choose_renderer", "top_view"]

ROOF_CUT_M = 1.5
"""What is higher above the floor than this is cut off in a view from the top."""


class Camera:
    """One drawing context that is kept for every picture.

    A picture depends on the world's state only, not on what was drawn before it.
    """

    def __init__(self, world: World) -> None:
        self._world = world
        self._renderer = _renderer(world.model, IMAGE_PX, IMAGE_PX)
        self._option = _shown()
        self._view = mujoco.MjvCamera()
        self._view.type = mujoco.mjtCamera.mjCAMERA_FIXED
        self._view.fixedcamid = world.model.camera(PREFIX + "camera").id

    def image(self) -> NDArray[np.uint8]:
        """Return what the camera sees now, [84, 84, 3] RGB, row 0 at the top."""
        self._renderer.update_scene(self._world.data, self._view, self._option)
        return np.asarray(self._renderer.render(), dtype=np.uint8)

    def close(self) -> None:
        """Give the drawing context back."""
        self._renderer.close()


def top_view(world: World, height_px: int = 960) -> NDArray[np.uint8]:
    """Return the map area seen straight from above, roofs cut off at 1.5 m, [height, width, 3] RGB."""
    frame = world.scene.map_frame
    width_px = round(height_px * frame.cols / frame.rows)
    renderer = _renderer(world.model, width_px, height_px)
    view = mujoco.MjvCamera()
    view.type = mujoco.mjtCamera.mjCAMERA_FREE
    view.orthographic = 1
    view.azimuth, view.elevation = 90.0, -90.0
    view.lookat[:] = (
        (frame.x_min_m + frame.x_max_m) / 2,
        (frame.y_min_m + frame.y_max_m) / 2,
        world.scene.floor_z_m,
    )
    view.distance = ROOF_CUT_M
    height_m, saved = frame.y_max_m - frame.y_min_m, (world.model.vis.global_.fovy, world.model.vis.map.znear)
    try:
        # Of an orthographic camera fovy is the height that is seen; the near plane, at eye level, cuts the roof off.
        world.model.vis.global_.fovy = height_m
        renderer.update_scene(world.data, view, _shown())
        return np.asarray(renderer.render(), dtype=np.uint8)
    finally:
        world.model.vis.global_.fovy, world.model.vis.map.znear = saved
        renderer.close()


def _shown() -> Any:
    """Return what is drawn: bodies as MuJoCo draws them by default, no sites."""
    option = mujoco.MjvOption()
    option.sitegroup[:] = 0
    return option


def _renderer(model: Any, width_px: int, height_px: int) -> Any:
    """Return a renderer without shadows and reflections.

    Raises:
        TwonavError: There is nothing to draw with.
    """
    renderer_name = choose_renderer()
    model.vis.global_.offwidth, model.vis.global_.offheight = width_px, height_px
    try:
        renderer = mujoco.Renderer(model, height_px, width_px)
    except Exception as error:  # EGL, GLFW and OSMesa each have exceptions of their own
        reason = (str(error).splitlines() or [type(error).__name__])[0]
        raise TwonavError(
            f"the camera cannot draw (MUJOCO_GL={renderer_name or 'not set'}: {reason}): "
            f"set MUJOCO_GL=egl, or type `{install_command()}`"
        ) from error
    renderer.scene.flags[mujoco.mjtRndFlag.mjRND_SHADOW] = 0
    renderer.scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
    return renderer
