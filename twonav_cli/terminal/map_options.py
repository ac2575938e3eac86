"""The options of `twonav map`; sentences and defaults are the settings'."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import typer

from twonav_cli.config import MappingConfig
from twonav_cli.errors import TwonavError
from twonav_cli.terminal.learning_choices import option_of

SENTENCES = {field.name: field.metadata["help"] for field in fields(MappingConfig)}
"""Setting to the sentence that stands beside it in the configuration."""

USUAL = MappingConfig()
USUAL_TURN_DEG = round(math.degrees(USUAL.keyframe_turn_rad), 1)

LogArgument = Annotated[Path, typer.Argument(help="A laser log in the CARMEN format (.clf, .log), also .gz.")]
ParticlesOption = Annotated[
    int | None, typer.Option("--particles", help=SENTENCES["particles"], show_default=f"{USUAL.particles}")
]
ResolutionOption = Annotated[
    float | None, typer.Option("--resolution", help=SENTENCES["resolution_m"], show_default=f"{USUAL.resolution_m}")
]
MaxRangeOption = Annotated[
    float | None, typer.Option("--max-range", help=SENTENCES["max_range_m"], show_default=f"{USUAL.max_range_m}")
]
KeyframeDistanceOption = Annotated[
    float | None,
    typer.Option(
        "--keyframe-distance", help=SENTENCES["keyframe_distance_m"], show_default=f"{USUAL.keyframe_distance_m}"
    ),
]
KeyframeTurnOption = Annotated[
    float | None,
    typer.Option(
        "--keyframe-turn",
        help="Angle turned after which a scan goes into the map, degrees (ours).",
        show_default=f"{USUAL_TURN_DEG}",
    ),
]
LaserForwardOption = Annotated[
    float | None,
    typer.Option(
        "--laser-forward",
        help="Where the laser sits, metres forward of the robot's middle.",
        show_default="as the log says",
    ),
]
OutOption = Annotated[
    Path | None, typer.Option("--out", help="Folder for map, trajectory and card; default: runs/maps/LOG.")
]


class Setting(NamedTuple):
    """A setting of the mapper as it is typed."""

    field: str
    """Of MappingConfig."""
    low: float
    high: float
    unit: str


SETTINGS = {
    "particles": Setting("particles", 1, 1000, ""),
    "resolution": Setting("resolution_m", 0.01, 1.0, " m"),
    "max_range": Setting("max_range_m", 0.5, 1000.0, " m"),
    "keyframe_distance": Setting("keyframe_distance_m", 0.01, 100.0, " m"),
    "keyframe_turn": Setting("keyframe_turn_rad", 0.1, 360.0, " degrees"),
}
"""Option to its setting and the values that it may have."""


FARTHEST_LASER_M = 5.0
"""From the middle of a robot."""


def checked_forward(forward_m: float | None) -> float | None:
    """Return where the laser sits.

    Raises:
        TwonavError: It cannot sit there.
    """
    if forward_m is not None and not abs(forward_m) <= FARTHEST_LASER_M:
        raise TwonavError(f"--laser-forward must be within {FARTHEST_LASER_M:g} m: {forward_m} was given")
    return forward_m


@dataclass(frozen=True)
class MapChoices:
    """What the command line says about the settings; None is the usual one.

    Attributes:
        particles: Number of particles.
        resolution: Edge of a cell, metres.
        max_range: Where beams are cut, metres.
        keyframe_distance: Metres.
        keyframe_turn: Degrees, as on every screen.
    """

    particles: int | None = None
    resolution: float | None = None
    max_range: float | None = None
    keyframe_distance: float | None = None
    keyframe_turn: float | None = None

    def given(self) -> dict[str, Any]:
        """Return what was said."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def config(self) -> MappingConfig:
        """Return the settings.

        Raises:
            TwonavError: One is out of its range; says which values there are.
        """
        changes: dict[str, Any] = {}
        for name, value in self.given().items():
            field, low, high, unit = SETTINGS[name]
            if not low <= value <= high:  # what is not a number is in no range
                raise TwonavError(f"{option_of(name)} must be between {low:g} and {high:g}{unit}: {value} was given")
            changes[field] = math.radians(value) if field.endswith("_rad") else value
        return replace(USUAL, **changes)

    def arguments(self) -> list[str]:
        """Return what was said as it is typed."""
        return [part for name, value in self.given().items() for part in (option_of(name), str(value))]
