"""How everything in a recording of the mapper looks: written once."""

from __future__ import annotations

from typing import Any

import rerun as rr

from twonav_cli.recording import palette
from twonav_cli.recording.palette import packed
from twonav_cli.recording.scenery import Y_UP, Always

BEST_COLOUR, ODOMETRY_COLOUR, TRUTH_COLOUR = palette.BELIEVED_COLOUR, palette.ESTIMATE_COLOUR, palette.TRUE_COLOUR
SCAN_COLOUR = palette.OUTCOME_COLOURS["reached"]
TROUBLE_COLOUR = palette.ERROR_COLOUR
EFFECTIVE_COLOUR = palette.GOAL_COLOURS[0]
RESAMPLED_COLOUR = palette.GOAL_COLOURS[3]

WAY = -1.3
"""Half the width of a way: less than 0 is in points of the screen, for maps are of every size."""


def write_mapping_looks(always: Always) -> None:
    """Write colours, widths and drawing order."""
    always("mapping/map", Y_UP)
    for entity, looks in _LOOKS.items():
        always(entity, looks)


def _arrow(colour: int, order: float) -> rr.Arrows2D:
    return rr.Arrows2D.from_fields(colors=packed([colour]), radii=0.03, draw_order=order)


def _strip(colour: int, radius: float, order: float) -> rr.LineStrips2D:
    return rr.LineStrips2D.from_fields(colors=packed([colour]), radii=radius, draw_order=order)


def _dot(colour: int, screen_points: float, order: float) -> rr.Points2D:
    return rr.Points2D.from_fields(colors=packed([colour]), radii=-screen_points, draw_order=order)


def _line(name: str, colour: int) -> rr.SeriesLines:
    return rr.SeriesLines(names=name, colors=packed([colour]), widths=1.6)


_LOOKS: dict[str, Any] = {
    "mapping/map/odometry/way": _strip(ODOMETRY_COLOUR, WAY, 10.0),
    "mapping/map/truth/way": _strip(TRUTH_COLOUR, WAY, 11.0),
    "mapping/map/best/way": _strip(BEST_COLOUR, WAY, 12.0),
    "mapping/map/best/latest": _strip(BEST_COLOUR, WAY, 12.0),
    "mapping/map/best/place": _dot(BEST_COLOUR, 5.0, 30.0),
    "mapping/map/scan": _dot(SCAN_COLOUR, 1.6, 15.0),
    "mapping/map/particles": rr.Arrows2D.from_fields(radii=0.008, draw_order=35.0),
    "mapping/map/odometry": _arrow(ODOMETRY_COLOUR, 31.0),
    "mapping/map/truth": _arrow(TRUTH_COLOUR, 33.0),
    "mapping/map/error": _strip(TROUBLE_COLOUR, -2.0, 32.0),
    "mapping/map/best": _arrow(BEST_COLOUR, 34.0),
    "mapping/map/trouble": _dot(TROUBLE_COLOUR, 4.0, 20.0),
    "mapping/map/trouble/latest": rr.Points2D.from_fields(
        colors=packed([TROUBLE_COLOUR]), radii=-5.0, draw_order=21.0, show_labels=True
    ),
    "filter/effective": _line("effective number", EFFECTIVE_COLOUR),
    "filter/resampled": rr.SeriesPoints(
        names="drawn again", colors=packed([RESAMPLED_COLOUR]), markers="diamond", marker_sizes=5.0
    ),
    "filter/unmatched": _line("without a match", TROUBLE_COLOUR),
    "curves/spread_m": _line("spread", EFFECTIVE_COLOUR),
    "curves/spread_deg": _line("spread", EFFECTIVE_COLOUR),
    "curves/correction_m": _line("correction", BEST_COLOUR),
    "curves/correction_deg": _line("correction", BEST_COLOUR),
    "curves/from_odometry_m": _line("from odometry", ODOMETRY_COLOUR),
    "curves/from_odometry_deg": _line("from odometry", ODOMETRY_COLOUR),
    "curves/error_m": _line("from the truth", TRUTH_COLOUR),
    "curves/error_deg": _line("from the truth", TRUTH_COLOUR),
}
