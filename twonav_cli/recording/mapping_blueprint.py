"""How the viewer lays out a recording of the mapper."""

from __future__ import annotations

import rerun.blueprint as rrb
from rerun.blueprint.encodings import TimelineColumn

from twonav_cli.grid import GridFrame
from twonav_cli.recording import views
from twonav_cli.recording.mapping_picture import UNKNOWN_GREY

BEYOND = [UNKNOWN_GREY] * 3
"""Around the map nothing is known either."""
NEAR_M = 1.5
"""Half the width of the view that goes along with the robot."""
KEYFRAMES_PER_S = 10
"""When the recording is played."""


def mapping_blueprint(frame: GridFrame, *, truth: bool) -> rrb.Blueprint:
    """Lay out a run of the mapper.

    Args:
        frame: What the map's view shows.
        truth: Whether it is known where the robot really is.
    """
    believed = "believes (magenta), odometry alone (orange)" + (", is (blue)" if truth else "")
    map_ = rrb.Spatial2DView(
        origin="/mapping",
        contents=["$origin/**", "- $origin/map/particles"],
        name=f"Map of the best particle: where the robot {believed}",
        visual_bounds=views.bounds_of(frame),
        background=BEYOND,
    )
    near = rrb.Spatial2DView(
        origin="/mapping/map/here",
        contents=["/mapping/**", "- /mapping/map/trouble/**", "- /mapping/map/best/place"],
        name="Around the robot: the scan as it believes, all particles (bright: heavy)",
        visual_bounds=rrb.VisualBounds2D(x_range=[-NEAR_M, NEAR_M], y_range=[-NEAR_M, NEAR_M]),
        background=BEYOND,
    )
    beside = rrb.Vertical(near, _filter_plot(legend=False), _metres(truth), _log(), row_shares=[7, 3, 3, 4])
    main = rrb.Horizontal(map_, beside, column_shares=[5, 3], name="Map")
    time = rrb.TimePanel(timeline="keyframe", state="collapsed", play_state="following", fps=KEYFRAMES_PER_S)
    tabs = rrb.Tabs(main, _curves(truth), views.about_tab(), active_tab=0, name="twonav")
    return rrb.Blueprint(tabs, *views.panels(time))


def _filter_plot(*, legend: bool) -> rrb.TimeSeriesView:
    title = "Particles: effective number, drawn again (diamond), without a match"
    return views.plot("/filter", title, legend=legend)


def _metres(truth: bool) -> rrb.TimeSeriesView:
    """Return the three lengths that tell how sure the mapper is, and whether it is right to be.

    Beside the map plots are so low that a legend would hide their first keyframes: the title names the curves.
    """
    curves = ["/curves/correction_m", "/curves/spread_m", *(["/curves/error_m"] if truth else [])]
    title = "Correction of odometry's guess, spread of the particles" + (", error" if truth else "")
    return views.plot("/curves", f"{title} [m]", contents=curves, legend=False)


def _log() -> rrb.TextLogView:
    """Return what is worth knowing; the level DEBUG, every drawing of particles, can be switched on."""
    columns = rrb.TextLogColumns(timeline_columns=[TimelineColumn("keyframe")], text_log_columns=["LogLevel", "Body"])
    rows = rrb.TextLogRows(filter_by_log_level=["INFO", "WARN", "ERROR", "CRITICAL"])
    return rrb.TextLogView(origin="/log", name="What happened, and why", columns=columns, rows=rows)


def _curves(truth: bool) -> rrb.Vertical:
    """Return every number of the keyframes, metres on the left, degrees on the right."""
    pairs = [
        ("correction", "Correction of odometry's guess"),
        ("spread", "Spread of the particles"),
        ("from_odometry", "Distance from odometry alone"),
        *([("error", "Error: distance from the truth")] if truth else []),
    ]
    rows = [
        rrb.Horizontal(*(views.plot(f"/curves/{name}_{unit}", f"{title} [{unit}]") for unit in ("m", "deg")))
        for name, title in pairs
    ]
    return rrb.Vertical(_filter_plot(legend=True), *rows, name="Curves")
