"""A scene with its map and its maze: what every stage and every command starts from.

The map of a shipped scene travels with its checkpoints; another scene's map is made from its geometry once and
kept in the runs folder.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.approximate import approximate_maze
from twonav_cli.mapping.occupancy import OccupancyMap, load_map, save_map
from twonav_cli.maze import Maze
from twonav_cli.paths import checkpoints_dir, runs_dir
from twonav_cli.scene.catalog import Scene, read_scene

MAP_FILE = "map.yaml"
CARD_FILE = "card.json"


@dataclass(frozen=True)
class Floor:
    """A scene, its 5 cm occupancy map and its 40 cm maze."""

    scene: Scene
    map: OccupancyMap
    maze: Maze
    maze_frame: GridFrame

    def start_cells(self) -> list[Cell]:
        """Cells of the starts, in the scene's order."""
        return list(self.maze.starts.values())


def read_floor(scene_name: str) -> Floor:
    """Read a scene, find or make its map, and make its maze (§4.3).

    Args:
        scene_name: Name of a shipped scene, or a path to a scene of one's own.

    Raises:
        TwonavError: The scene, its goals or its map are wrong.
    """
    scene = read_scene(scene_name)
    occupancy = _known_map(scene) or make_map(scene, runs_dir() / scene.name / "map")
    maze, frame = approximate_maze(occupancy, scene.goals, scene.starts)
    return Floor(scene, occupancy, maze, frame)


def make_map(scene: Scene, folder: Path) -> OccupancyMap:
    """Make the occupancy map from the scene's geometry and write it as PGM, YAML and a card into `folder`."""
    from twonav_cli.scene.geometry_map import occupied_from_geometry

    occupied = occupied_from_geometry(scene, scene.map_frame)
    occupancy = OccupancyMap.from_occupied(occupied, scene.map_frame)
    save_map(occupancy, folder / MAP_FILE)
    card = {"kind": "map", "scene": scene.name, "scene_digest": scene.digest, "map_digest": occupancy.digest}
    write_whole(folder / CARD_FILE, json.dumps(card, indent=2) + "\n")
    return occupancy


def _known_map(scene: Scene) -> OccupancyMap | None:
    """Return the shipped or cached map that was made from this very scene, if there is one."""
    for folder in (checkpoints_dir() / scene.name / "map", runs_dir() / scene.name / "map"):
        try:
            card = json.loads((folder / CARD_FILE).read_text())
            if card["scene_digest"] != scene.digest:
                continue
            occupancy = load_map(folder / MAP_FILE)
        except (OSError, ValueError, KeyError, TypeError, TwonavError):
            continue  # a map can always be made again
        if occupancy.digest == card.get("map_digest"):
            return occupancy
    return None
