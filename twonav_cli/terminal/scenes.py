"""`twonav scenes` and `twonav scenes show`."""

from __future__ import annotations

import json

from rich.table import Table

from twonav_cli.scene.catalog import read_scene, scene_names
from twonav_cli.terminal.console import out


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


def run_show(name: str) -> int:
    """Draw the floor plan of a scene; returns the exit code."""
    from twonav_cli.mapping.floor import read_floor
    from twonav_cli.terminal.screen.plan_drawing import draw_scene

    floor = read_floor(name)
    console = out()
    console.print(
        draw_scene(floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame, console.width, floor.scene.rooms)
    )
    return 0
