"""A recording of Fig. 7: the errors of every network over the floor plan, with the number under the pointer.

R, C rows and columns of a picture.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from twonav_cli import __version__
from twonav_cli.grid import GridFrame
from twonav_cli.recording import views
from twonav_cli.recording.palette import VIRIDIS
from twonav_cli.recording.rrd_file import RrdFile
from twonav_cli.recording.scenery import FREE_RGB, WALL_RGB, Y_UP, image_transform

APPLICATION_ID = "twonav_cnn_errors"

LEVELS = 120
"""Steps of the scale, equal factors apart; level 0 is where there is no cell."""

COLUMNS = 2

FloatArray = NDArray[np.float64]


class ErrorPanel(NamedTuple):
    """The errors of a network: [R, C] in metres, not a number where there is no cell; and the paper's ends."""

    name: str
    heat_m: FloatArray
    frame: GridFrame
    paper_m: tuple[float, float] | None


def record_error_maps(
    path: Path,
    scene: str,
    seed: int,
    command: str,
    panels: Sequence[ErrorPanel],
    occupied: NDArray[np.bool_],
    map_frame: GridFrame,
) -> Path:
    """Write the error maps of a scene, all on one scale, and return the path.

    Args:
        path: Must end in .rrd.
        scene: Name.
        seed: Of the frames and the trainings.
        command: What makes it again.
        panels: One for each network.
        occupied: [R, C] of the floor plan.
        map_frame: Where it lies.

    Raises:
        TwonavError: The path cannot be written.
    """
    file = RrdFile(path, APPLICATION_ID)
    properties = {
        "format": 1, "twonav": __version__, "kind": "localizer", "command": "reproduce", "stage": "fig7",
        "scene": scene, "seed": seed, "settings": json.dumps({"command": command}), "goals": "[]",
    }  # fmt: skip
    file.describe(f"reproduce fig7 {scene}, seed {seed}", properties)
    file.show(_blueprint(panels, map_frame))
    low_m, high_m = _ends(panels)
    file.always("errors/map", Y_UP)
    file.always("errors/map/floor", rr.AnnotationContext([(0, "free", FREE_RGB), (1, "occupied", WALL_RGB)]))
    floor = rr.SegmentationImage(occupied.astype(np.uint8), draw_order=-10.0)
    file.always("errors/map/floor", image_transform(map_frame), floor)
    scale = rr.AnnotationContext(level_classes(low_m, high_m))
    for panel in panels:
        levels = rr.SegmentationImage(error_levels(panel.heat_m, low_m, high_m), opacity=1.0, draw_order=0.0)
        file.always(_heat(panel), scale)
        file.always(_heat(panel), image_transform(panel.frame), levels)
        file.always(f"errors/map/{panel.name}/cells", *_cells(panel))
    file.always("numbers", rr.TextDocument(_numbers(scene, command, panels), media_type="text/markdown"))
    file.close()
    return path


def error_levels(heat_m: FloatArray, low_m: float, high_m: float) -> NDArray[np.uint8]:
    """Return the level [R, C] of every error: 0 where there is none, else 1 to LEVELS on a logarithmic scale."""
    known = np.isfinite(heat_m)
    share = np.log(np.where(known, heat_m, low_m).clip(low_m, high_m) / low_m) / np.log(high_m / low_m)
    return np.where(known, 1 + np.rint(share * (LEVELS - 1)), 0).astype(np.uint8)


def level_classes(low_m: float, high_m: float) -> list[tuple[int, str, tuple[int, int, int, int]]]:
    """Return level, what the viewer says when it is pointed at, and colour."""
    shares = np.linspace(0.0, 1.0, LEVELS)
    colours = [int(VIRIDIS[round(share * 255)]) for share in shares]
    scale = [
        (number, f"about {low_m * (high_m / low_m) ** share:.2g} m", _channels(colour))
        for number, (share, colour) in enumerate(zip(shares, colours, strict=True), start=1)
    ]
    return [(0, "no cell", (0, 0, 0, 0)), *scale]


def _channels(colour: int) -> tuple[int, int, int, int]:
    return colour >> 24 & 255, colour >> 16 & 255, colour >> 8 & 255, colour & 255


def _ends(panels: Sequence[ErrorPanel]) -> tuple[float, float]:
    """Return the smallest and the largest error of all panels, never the same."""
    values = np.concatenate([panel.heat_m[np.isfinite(panel.heat_m)] for panel in panels])
    low_m = max(float(values.min()), 1e-3)
    return low_m, max(float(values.max()), 1.01 * low_m)


def _heat(panel: ErrorPanel) -> str:
    return f"errors/map/{panel.name}/heat"


def _cells(panel: ErrorPanel) -> tuple[rr.Points2D, rr.AnyValues]:
    """Return a small point in every cell, with its error when it is pointed at or selected."""
    xs_m, ys_m = panel.frame.centres()
    rows, cols = np.nonzero(np.isfinite(panel.heat_m))
    errors_m = panel.heat_m[rows, cols]
    places = np.column_stack([xs_m[cols], ys_m[rows]])
    labels = [f"{error:.3f} m" for error in errors_m]
    points = rr.Points2D(places, labels=labels, show_labels=False, radii=0.02, colors=[(0, 0, 0, 90)], draw_order=5.0)
    return points, rr.AnyValues(error_m=errors_m)


def _numbers(scene: str, command: str, panels: Sequence[ErrorPanel]) -> str:
    """Return the ends and the mean of every network beside the paper's, as Markdown."""
    lines = [
        f"# Position errors in the {scene}, metres",
        "Mean over the paper's test frames of each 25 cm cell (Fig. 7). Dark is a small error, bright a large one; all "
        "maps share one logarithmic scale. Point at a cell for its number.",
        "",
        "| network | smallest | mean | largest | the paper's |",
        "|---|---|---|---|---|",
    ]
    for panel in panels:
        errors_m = panel.heat_m[np.isfinite(panel.heat_m)]
        ours = " | ".join(f"{value:.3f}" for value in (errors_m.min(), errors_m.mean(), errors_m.max()))
        paper = "" if panel.paper_m is None else f"{panel.paper_m[0]:g} to {panel.paper_m[1]:g}"
        lines.append(f"| {panel.name} | {ours} | {paper} |")
    return "\n".join([*lines, "", f"`{command}`"])


def _blueprint(panels: Sequence[ErrorPanel], map_frame: GridFrame) -> rrb.Blueprint:
    """Lay the maps out beside each other, the numbers below."""
    maps = [
        rrb.Spatial2DView(
            origin="/errors",
            contents=["/errors/map/floor", f"/errors/map/{panel.name}/**"],
            name=panel.name,
            visual_bounds=views.bounds_of(map_frame),
        )
        for panel in panels
    ]
    numbers = rrb.TextDocumentView(origin="/numbers", name="Numbers")
    main = rrb.Vertical(rrb.Grid(*maps, grid_columns=COLUMNS), numbers, row_shares=[3, 1], name="Errors")
    return rrb.Blueprint(main, *views.panels(rrb.TimePanel(state="collapsed")))
