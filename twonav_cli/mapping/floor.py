"""A scene with its map and its maze: what every stage and every command starts from.

The map is the one that the robot made in a survey of the scene (§4.1), where there is one; else it is made from the
scene's geometry once and kept in the runs folder.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.geometry import FloatArray
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.approximate import approximate_maze
from twonav_cli.mapping.known_maps import (
    FOLDER,
    GEOMETRY,
    GEOMETRY_FOLDER,
    SOURCES,
    SURVEY,
    card_in,
    find_map,
    make_map,
)
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.maze import Maze
from twonav_cli.paths import runs_dir
from twonav_cli.scene.catalog import Scene, read_scene


@dataclass(frozen=True)
class Floor:
    """A scene, its 5 cm occupancy map and its 40 cm maze.

    Attributes:
        map_source: "survey" or "geometry".
        walls: [K, 2] points on the walls of a survey's map, metres, where they were kept.
        outdated: Folder of the user's survey of another version of the scene, where the geometry's map is used for
            want of one of this version.
    """

    scene: Scene
    map: OccupancyMap
    maze: Maze
    maze_frame: GridFrame
    map_source: str = GEOMETRY
    walls: FloatArray | None = None
    outdated: Path | None = None

    def start_cells(self) -> list[Cell]:
        """Cells of the starts, in the scene's order."""
        return list(self.maze.starts.values())


def read_floor(
    scene_name: str, map_from: str | None = None, own_first: bool = False, chosen: Path | None = None
) -> Floor:
    """Read a scene, find or make its map, and make its maze (§4.3).

    Args:
        scene_name: Name of a shipped scene, or a path to a scene of one's own.
        map_from: "survey" or "geometry"; None takes the survey's map where there is one, else the geometry's.
        own_first: Whether a survey of the user's own goes before the shipped one (training does, playing does not).
        chosen: A folder of a scene's checkpoints whose map goes before both.

    Raises:
        TwonavError: The scene, its goals or its map are wrong, or there is no survey of it.
    """
    if map_from is not None and map_from not in SOURCES:
        raise unknown_name("map source", map_from, SOURCES)
    scene = read_scene(scene_name)
    found = find_map(scene, map_from, own_first, chosen)
    if found is None and map_from == SURVEY:
        raise TwonavError(
            f"the robot has not surveyed {scene.name} yet, or the scene has changed since: "
            f"let it make the map with `{survey_command(scene_name)}`"
        )
    occupancy, source = (found.map, found.source) if found else (geometry_map(scene), GEOMETRY)
    try:
        maze, frame = approximate_maze(occupancy, scene.goals, scene.starts)
    except TwonavError as error:
        if source == GEOMETRY:
            raise
        raise TwonavError(
            f"on the map that the robot made, {error}; or survey again with another --seed, or add --map-from geometry"
        ) from error
    outdated = None if found or map_from is not None else _outdated_survey(scene)
    return Floor(scene, occupancy, maze, frame, source, found.walls if found else None, outdated)


def _outdated_survey(scene: Scene) -> Path | None:
    """Return the folder of the user's survey if it is of another version of the scene, else None."""
    folder = runs_dir() / scene.name / FOLDER
    card = card_in(folder)
    other = card.get("source") == SURVEY and card.get("scene_digest") != scene.digest
    return folder if other else None


def survey_command(scene_name: str) -> str:
    """Return the command with which the robot makes its own map of a scene."""
    return shlex.join(["twonav", "train", "--stage", "map", "--scene", scene_name])


def geometry_map(scene: Scene) -> OccupancyMap:
    """Return the map that the scene's geometry gives; it is made once and kept in the runs folder."""
    found = find_map(scene, GEOMETRY)
    return found.map if found else make_map(scene, runs_dir() / scene.name / GEOMETRY_FOLDER)
