"""Scenes: which there are, and what one declares (goals, starts, rooms, the area of its map)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

from twonav_cli.config import MAP_RESOLUTION_M
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.paths import scenes_dir
from twonav_cli.scene.scene_files import digest_of_scene

SCENE_FILE = "scene.xml"
MAP_NUMERIC = "twonav.map"


@dataclass(frozen=True)
class Room:
    """A named rectangle of floor."""

    x_min_m: float
    y_min_m: float
    x_max_m: float
    y_max_m: float

    def contains(self, x_m: float, y_m: float) -> bool:
        """Whether a point lies in the room."""
        return self.x_min_m <= x_m < self.x_max_m and self.y_min_m <= y_m < self.y_max_m


@dataclass(frozen=True)
class Scene:
    """What a scene declares.

    Attributes:
        name: Of its folder, or of its file.
        xml_path: Where it is.
        digest: Of the XML and every file that it names.
        goals: Name to pose, in the order of the file.
        starts: Name to pose; the goals where the scene declares no start.
        rooms: Name to rectangle.
        map_area_m: (x_min, y_min, x_max, y_max) of the map.
        floor_z_m: Height of the floor.
    """

    name: str
    xml_path: Path
    digest: str
    goals: dict[str, Pose]
    starts: dict[str, Pose]
    rooms: dict[str, Room]
    map_area_m: tuple[float, float, float, float]
    floor_z_m: float = 0.0

    @property
    def map_frame(self) -> GridFrame:
        """The 5 cm grid of the map area."""
        x_min_m, y_min_m, x_max_m, y_max_m = self.map_area_m
        cols = math.ceil((x_max_m - x_min_m) / MAP_RESOLUTION_M - 1e-6)
        rows = math.ceil((y_max_m - y_min_m) / MAP_RESOLUTION_M - 1e-6)
        return GridFrame(x_min_m, y_min_m, MAP_RESOLUTION_M, rows, cols)

    def room_at(self, x_m: float, y_m: float) -> str | None:
        """Return the name of the room that holds a point, if any."""
        return next((name for name, room in self.rooms.items() if room.contains(x_m, y_m)), None)


def scene_names() -> list[str]:
    """Return the names of the shipped scenes."""
    return sorted(path.parent.name for path in scenes_dir().glob(f"*/{SCENE_FILE}"))


def scene_path(name_or_path: str) -> Path:
    """Return the XML file that a name or a path means.

    Raises:
        TwonavError: There is no such scene.
    """
    if name_or_path in scene_names():
        return scenes_dir() / name_or_path / SCENE_FILE
    path = Path(name_or_path).expanduser()
    if (path / SCENE_FILE).is_file():
        return path / SCENE_FILE
    if path.is_file():
        return path
    if path.suffix.lower() in (".xml", ".mjcf") or len(path.parts) > 1:
        raise TwonavError(
            f"there is no scene at {path}: name an MJCF file, a folder with {SCENE_FILE}, or one of "
            f"{', '.join(scene_names())}"
        )
    raise unknown_name("scene", name_or_path, scene_names())


def read_scene(name_or_path: str) -> Scene:
    """Read and check a scene.

    Args:
        name_or_path: A shipped scene's name, an MJCF file, or a folder that holds scene.xml.

    Raises:
        TwonavError: There is no such scene, or it is broken, or declares no goal.
    """
    from twonav_cli.scene.compiled_scene import CompiledScene

    path = scene_path(name_or_path)
    digest = digest_of_scene(path)
    compiled = CompiledScene(path)
    goals = compiled.poses("goal/")
    if not goals:
        raise TwonavError(f'{path} declares no goal: add a site such as <site name="goal/kitchen" pos="1 2 0"/>')
    starts = compiled.poses("start/") or dict(goals)
    floor_z_m = compiled.floor_z_m([*goals.values(), *starts.values()])
    scene = Scene(
        name=path.parent.name if path.name == SCENE_FILE else path.stem,
        xml_path=path,
        digest=digest,
        goals={name: place.pose for name, place in goals.items()},
        starts={name: place.pose for name, place in starts.items()},
        rooms={name: Room(*area) for name, area in compiled.rooms().items()},
        map_area_m=compiled.map_area_m(),
        floor_z_m=floor_z_m,
    )
    _refuse_outside(scene)
    return scene


def _refuse_outside(scene: Scene) -> None:
    """Refuse a goal or start that is not on the map."""
    for kind, poses in (("goal", scene.goals), ("start", scene.starts)):
        for name, pose in poses.items():
            if not scene.map_frame.contains(pose.x_m, pose.y_m):
                raise TwonavError(
                    f"{scene.xml_path}: {kind} {name!r} at ({pose.x_m:.2f}, {pose.y_m:.2f}) lies outside the map "
                    f"{tuple(round(edge, 2) for edge in scene.map_area_m)}: move it, or enlarge {MAP_NUMERIC}"
                )
