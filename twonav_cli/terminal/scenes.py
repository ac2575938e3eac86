"""`twonav scenes` and `twonav scenes show`."""

from __future__ import annotations

import json
from pathlib import Path

from rich.table import Table

from twonav_cli.errors import TwonavError
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.approximate import largest_maze
from twonav_cli.mapping.occupancy import OccupancyMap, load_map
from twonav_cli.maze import Maze
from twonav_cli.scene.catalog import read_scene, scene_names
from twonav_cli.terminal.console import in_colour, out
from twonav_cli.terminal.map_source import tell_source

MAP_SUFFIXES = (".yaml", ".yml")
WHO = {"survey": "the robot, in a survey", "geometry": "the simulator, from the scene's geometry"}
"""Source of a map to who made it."""


def run_list(as_json: bool) -> int:
    """Print every shipped scene; returns the exit code."""
    scenes = [read_scene(name) for name in scene_names()]
    if as_json:
        rows = [
            {"name": s.name, "goals": list(s.goals), "starts": list(s.starts), "rooms": list(s.rooms)} for s in scenes
        ]
        print(json.dumps({"scenes": rows}))
        return 0
    table = Table(box=None, pad_edge=False)
    for heading in ("scene", "map", "rooms", "goals", "starts"):
        table.add_column(heading)
    for scene in scenes:
        x_min, y_min, x_max, y_max = scene.map_area_m
        size = f"{x_max - x_min:.1f} x {y_max - y_min:.1f} m"
        table.add_row(scene.name, size, ", ".join(scene.rooms), ", ".join(scene.goals), str(len(scene.starts)))
    out().print(table)
    return 0


def run_show(name: str, as_map: bool = False, map_from: str | None = None) -> int:
    """Draw the floor plan of a scene, its map, or any map by the path of its YAML file; returns the exit code.

    Raises:
        TwonavError: There is no such scene or map, or no maze can be made from it.
    """
    if Path(name).suffix.lower() == ".pgm":
        raise TwonavError(f"{name} is a map's picture: name the map's .yaml file, it says how large a pixel is")
    if Path(name).suffix.lower() in MAP_SUFFIXES:
        if map_from is not None:
            raise TwonavError("--map-from is for scenes: leave it out, the file says which map is meant")
        occupancy = load_map(Path(name).expanduser())
        _print_map(occupancy, *largest_maze(occupancy))
        return 0
    from twonav_cli.mapping.floor import read_floor
    from twonav_cli.terminal.screen.plan_drawing import draw_scene

    floor = read_floor(name, map_from, own_first=True)
    if as_map:
        _print_map(floor.map, floor.maze, floor.maze_frame)
        out().print(f"made by: {WHO[floor.map_source]}")
    else:
        plan, cols = floor.map, out().width
        out().print(draw_scene(floor.maze, floor.maze_frame, plan.occupied, plan.frame, cols, floor.scene.rooms))
    tell_source(floor, name, map_from)
    return 0


def _print_map(occupancy: OccupancyMap, maze: Maze, maze_frame: GridFrame) -> None:
    """Print a map with its maze, as wide as the terminal."""
    from twonav_cli.terminal.screen.map_drawing import map_text

    out().print(map_text(occupancy, maze, maze_frame, out().width, in_colour()), soft_wrap=True)
