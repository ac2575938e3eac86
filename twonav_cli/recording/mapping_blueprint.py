"""How the viewer lays out a recording of the mapper."""

from __future__ import annotations

import rerun.blueprint as rrb

from twonav_cli.grid import GridFrame
from twonav_cli.recording import views
from twonav_cli.recording.mapping_columns import UNKNOWN_GREY

BEYOND = [UNKNOWN_GREY] * 3
"""Around the map nothing is known either."""
NEAR_M = 2.0
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
        contents=["/mapping/**", "- /mapping/map/trouble", "- /mapping/map/odometry/**"],
        name="Around the robot: scan as believed, particles (bright: heavy)",
        visual_bounds=rrb.VisualBounds2D(x_range=[-NEAR_M, NEAR_M], y_range=[-NEAR_M, NEAR_M]),
        background=BEYOND,
    )
    last = (
        views.plot("/curves/error_m", "Distance from the truth [m]")
        if truth
        else views.plot("/curves/correction_m", "How far scan matching moved odometry's guess [m]")
    )
    beside = rrb.Vertical(
        near, _filter_plot(), last, views.log(["keyframe", "time"]), row_shares=[7, 3, 3, 4]
    )
    main = rrb.Horizontal(map_, beside, column_shares=[5, 3], name="Map")
    time = rrb.TimePanel(timeline="keyframe", state="collapsed", play_state="following", fps=KEYFRAMES_PER_S)
    tabs = rrb.Tabs(main, _curves(truth), views.about_tab(), active_tab=0, name="twonav")
    return rrb.Blueprint(tabs, *views.panels(time))


def _filter_plot() -> rrb.TimeSeriesView:
    return views.plot("/filter", "Particles: effective number, drawn again (diamond), without a match")


def _curves(truth: bool) -> rrb.Grid:
    """Return every number of the keyframes side by side."""
    pairs = [
        ("correction", "Scan matching moved odometry's guess by"),
        ("spread", "Spread of the particles"),
        ("from_odometry", "Distance from odometry alone"),
        *([("error", "Distance from the truth")] if truth else []),
    ]
    plots = [
        views.plot(f"/curves/{name}_{unit}", f"{title} [{unit}]") for name, title in pairs for unit in ("m", "deg")
    ]
    return rrb.Grid(_filter_plot(), rrb.TimeSeriesView(origin="/none", name=" "), *plots, grid_columns=2, name="Curves")
