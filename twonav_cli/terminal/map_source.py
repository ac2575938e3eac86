"""Which map a command works on: the option, and the line that says how the robot makes its own."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from twonav_cli.terminal.console import err

if TYPE_CHECKING:
    from twonav_cli.mapping.floor import Floor

MapFromOption = Annotated[
    str | None,
    typer.Option(
        "--map-from",
        help="survey (the map that the robot made) or geometry (the simulator's).",
        show_default="survey where there is one",
    ),
]


def notice_of(floor: Floor, scene_name: str, map_from: str | None) -> str | None:
    """Return a sentence where nobody asked for the geometry's map and there is no other; else None."""
    from twonav_cli.mapping.floor import survey_command
    from twonav_cli.mapping.known_maps import GEOMETRY

    if map_from is not None or floor.map_source != GEOMETRY:
        return None
    used, command = "the map is that of the scene's geometry", survey_command(scene_name)
    if floor.outdated is not None:
        other = f"the survey in {floor.outdated} is of another version of the scene"
        return f"{used}: {other}, survey again with `{command}`"
    return f"{used}; the robot makes its own with `{command}`"


def tell_source(floor: Floor, scene_name: str, map_from: str | None) -> None:
    """Print that sentence on standard error, if there is one: at the end, so that an error stays one line."""
    notice = notice_of(floor, scene_name, map_from)
    if notice is not None:
        err().print(notice, soft_wrap=True, markup=False)
