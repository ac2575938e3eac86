"""A scene as MuJoCo compiled it, without the robot: what it declares and where its floor is."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import MAZE_RESOLUTION_M, ROBOT_HEIGHT_M
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.scene.catalog import MAP_NUMERIC
from twonav_cli.scene.engine import mujoco

MAX_EXTENT_M = 200.0
"""A map of 5 cm pixels over more than this would not fit into memory with everything that is made from it."""

LOAD_ERRORS = (ValueError, RuntimeError, mujoco.FatalError, UnicodeError)
"""What MuJoCo raises when a scene is not to its liking."""

OLD_WORDS = ("sensornoise", "passive", "collision", "mpr_iterations", "apirate", "convexhull", "exactmeshinertia")
"""Attributes that MuJoCo 4 no longer knows."""

Area = tuple[float, float, float, float]
FloatArray = NDArray[np.float64]


class Place(NamedTuple):
    """A declared pose and the height of its site."""

    pose: Pose
    z_m: float


def one_line(error: Exception) -> str:
    """Return what MuJoCo said in one line."""
    words = " ".join(str(error).split()) or type(error).__name__
    old = next((word for word in OLD_WORDS if f"attribute: '{word}'" in words), None)
    hint = f"; written for an older MuJoCo: remove the attribute {old!r}" if old else ""
    return words + hint


class CompiledScene:
    """The compiled scene with everything at its initial position.

    Raises:
        TwonavError: MuJoCo refuses the scene, or a number in it is not finite or absurd.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            self.model = mujoco.MjSpec.from_file(str(path)).compile()
            self.data = mujoco.MjData(self.model)
        except LOAD_ERRORS as error:
            raise TwonavError(f"{path} cannot be loaded: {one_line(error)}") from error
        self._refuse_absurd_numbers()
        mujoco.mj_forward(self.model, self.data)
        if not np.isfinite(self.data.geom_xpos).all():
            raise TwonavError(f"{path} places something nowhere: look for joints with impossible numbers")

    def _refuse_absurd_numbers(self) -> None:
        """Refuse NaN, infinity and distances beyond the planet, which MuJoCo loads without a word."""
        model = self.model
        named = {
            "geom position": model.geom_pos,
            "geom rotation": model.geom_quat,
            "geom size": model.geom_size,
            "geom friction": model.geom_friction,
            "body position": model.body_pos,
            "body rotation": model.body_quat,
            "body mass": model.body_mass,
            "site position": model.site_pos,
            "site rotation": model.site_quat,
            "joint position": model.qpos0,
            "light or camera position": np.concatenate([model.light_pos.ravel(), model.cam_pos.ravel()]),
            "number of <custom>": model.numeric_data,
        }
        for what, values in named.items():
            numbers = np.asarray(values)
            if not (np.isfinite(numbers) & (np.abs(numbers) < 1e6)).all():
                raise TwonavError(
                    f"{self.path} holds a {what} that is not a finite number (NaN, inf or huge): correct it"
                )

    def poses(self, prefix: str) -> dict[str, Place]:
        """Return the sites whose name starts with `prefix`: the name's rest to its pose.

        Raises:
            TwonavError: A site has the prefix and nothing after it.
        """
        found: dict[str, Place] = {}
        for index, name in self._sites(prefix):
            x_m, y_m, z_m = (float(value) for value in self.data.site_xpos[index])
            theta_rad = math.atan2(self.data.site_xmat[index][3], self.data.site_xmat[index][0])
            found[name] = Place(Pose(x_m, y_m, float(theta_rad)), z_m)
        return found

    def _sites(self, prefix: str) -> list[tuple[int, str]]:
        """Return index and short name of the sites with a prefix, in the order of the file."""
        found = []
        for index in range(self.model.nsite):
            try:
                name = str(self.model.site(index).name)
            except UnicodeDecodeError:
                continue
            if name == prefix:
                raise TwonavError(f"{self.path} has a site named {prefix!r} without a name after the slash: add one")
            if name.startswith(prefix):
                found.append((index, name.removeprefix(prefix)))
        return found

    def rooms(self) -> dict[str, Area]:
        """Return the box sites room/<name> as areas.

        Raises:
            TwonavError: A room's site is not a box.
        """
        found: dict[str, Area] = {}
        for index, name in self._sites("room/"):
            if self.model.site_type[index] != mujoco.mjtGeom.mjGEOM_BOX:
                raise TwonavError(f'{self.path}: site room/{name} is not a box: give it type="box"')
            x_m, y_m, _ = (float(value) for value in self.data.site_xpos[index])
            half = np.abs(self.data.site_xmat[index].reshape(3, 3)) @ self.model.site_size[index]
            found[name] = (x_m - float(half[0]), y_m - float(half[1]), x_m + float(half[0]), y_m + float(half[1]))
        return found

    def map_area_m(self) -> Area:
        """Return the area of the map: as declared, else what encloses everything that stands still.

        Raises:
            TwonavError: The area declared is not one, or too large, or there is nothing to enclose.
        """
        declared = self._declared_area()
        area = declared or self._enclosing_area()
        if not (area[0] < area[2] and area[1] < area[3]):
            raise TwonavError(f"{self.path}: {MAP_NUMERIC} must be x_min y_min x_max y_max, growing; it is {area}")
        if max(area[2] - area[0], area[3] - area[1]) > MAX_EXTENT_M:
            raise TwonavError(
                f"{self.path} is {area[2] - area[0]:.0f} x {area[3] - area[1]:.0f} m, at most {MAX_EXTENT_M:.0f} m: "
                f'give it <custom><numeric name="{MAP_NUMERIC}" data="x_min y_min x_max y_max"/></custom>'
            )
        return area

    def _declared_area(self) -> Area | None:
        """Return the numeric twonav.map, if there is one."""
        for index in range(self.model.nnumeric):
            if self.model.numeric(index).name != MAP_NUMERIC:
                continue
            start, size = int(self.model.numeric_adr[index]), int(self.model.numeric_size[index])
            if size != 4:
                raise TwonavError(f"{self.path}: {MAP_NUMERIC} needs 4 numbers (x_min y_min x_max y_max), has {size}")
            x_min, y_min, x_max, y_max = (float(value) for value in self.model.numeric_data[start : start + 4])
            return x_min, y_min, x_max, y_max
        return None

    def _enclosing_area(self) -> Area:
        """Return the bounding box of the solid geoms that stand still, planes left out, grown to whole maze cells."""
        model, data = self.model, self.data
        solid = (np.asarray(model.geom_contype) | np.asarray(model.geom_conaffinity)) != 0
        still = np.asarray(model.body_weldid)[np.asarray(model.geom_bodyid)] == 0
        chosen = solid & still & (np.asarray(model.geom_type) != mujoco.mjtGeom.mjGEOM_PLANE)
        if not chosen.any():
            raise TwonavError(
                f"{self.path} has no walls to tell its size from: "
                f'add <custom><numeric name="{MAP_NUMERIC}" data="x_min y_min x_max y_max"/></custom>'
            )
        rotation = np.asarray(data.geom_xmat)[chosen].reshape(-1, 3, 3)  # [geoms, 3, 3]
        local = np.asarray(model.geom_aabb)[chosen]  # [geoms, 6] middle and half sizes
        middle = np.asarray(data.geom_xpos)[chosen] + np.einsum("gij,gj->gi", rotation, local[:, :3])
        half = np.einsum("gij,gj->gi", np.abs(rotation), local[:, 3:])
        lower = np.floor((middle - half).min(axis=0) / MAZE_RESOLUTION_M + 1e-6) * MAZE_RESOLUTION_M
        upper = np.ceil((middle + half).max(axis=0) / MAZE_RESOLUTION_M - 1e-6) * MAZE_RESOLUTION_M
        x_min, y_min, x_max, y_max = (round(float(edge), 6) for edge in (*lower[:2], *upper[:2]))
        return x_min, y_min, x_max, y_max

    def floor_z_m(self, places: Iterable[Place]) -> float:
        """Return the height of the floor: what most places stand on, seen by a ray downward.

        The ray starts less than the robot's height above the site, where nothing can be if the robot fits there.

        Raises:
            TwonavError: There is no floor under any of them.
        """
        heights = [height for place in places if (height := self._ground_below(place)) is not None]
        if not heights:
            raise TwonavError(f"{self.path} has no floor under its goals: add a plane, or correct the goals' heights")
        most_common = Counter(round(height, 3) for height in heights).most_common()
        # A rug lifts some places: of heights that are equally common the lowest is the floor.
        return min(height for height, count in most_common if count == most_common[0][1])

    def _ground_below(self, place: Place) -> float | None:
        """Return the height of the highest solid surface under a site, or None."""
        start = np.array([place.pose.x_m, place.pose.y_m, place.z_m + ROBOT_HEIGHT_M - 0.01])
        down, geom = np.array([0.0, 0.0, -1.0]), np.full(1, -1, dtype=np.int32)
        for _ in range(16):
            distance_m = mujoco.mj_ray(self.model, self.data, start, down, None, True, -1, geom)
            if distance_m < 0:
                return self._plane_below(place)
            start[2] -= distance_m
            if self.model.geom_contype[geom[0]] or self.model.geom_conaffinity[geom[0]]:
                return float(start[2])
            start[2] -= 1e-5
        return None

    def _plane_below(self, place: Place) -> float | None:
        """Return the height of the lowest level plane: contacts with it are infinite, rays end at its drawn size."""
        planes = np.asarray(self.model.geom_type) == mujoco.mjtGeom.mjGEOM_PLANE
        level = planes & (np.asarray(self.data.geom_xmat)[:, 8] > 0.999)
        heights = np.asarray(self.data.geom_xpos)[level, 2]
        return float(heights.min()) if heights.size else None
