"""The views that the layouts of recordings are put together from."""

from __future__ import annotations

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint import encodings as blueprint_encodings

from twonav_cli.grid import GridFrame
from twonav_cli.recording.table_scenery import LEGEND_ROWS, Q_LEGEND, TD_LEGEND, goal_entity, td_entity

_EDGE = rr.TimeRangeBoundary
# Without this a plot shows only a thousand ticks around the cursor.
WHOLE_RUN = rrb.TimeAxis(view_range=rr.TimeRange(start=_EDGE.infinite(), end=_EDGE.infinite()))
NEAR_CURSOR = [
    rrb.VisibleTimeRange("sim_time", start=_EDGE.cursor_relative(seconds=-30), end=_EDGE.cursor_relative(seconds=10)),
    rrb.VisibleTimeRange("step", start=_EDGE.cursor_relative(seq=-60), end=_EDGE.cursor_relative(seq=20)),
]
MARGIN_M = 0.3
DARK = [18, 18, 18]


def bounds_of(frame: GridFrame) -> rrb.VisualBounds2D:
    """Return what a view shows of a grid and a little around it."""
    return rrb.VisualBounds2D(
        x_range=[frame.x_min_m - MARGIN_M, frame.x_max_m + MARGIN_M],
        y_range=[-frame.y_max_m - MARGIN_M, -frame.y_min_m + MARGIN_M],
    )


def panels(time: rrb.TimePanel) -> tuple[rrb.TimePanel, rrb.SelectionPanel, rrb.BlueprintPanel]:
    """Return the panels around the views: the others are folded away."""
    return time, rrb.SelectionPanel(state="collapsed"), rrb.BlueprintPanel(state="collapsed")


def plot(
    origin: str,
    name: str,
    *,
    whole: bool = True,
    top: float | None = None,
    contents: list[str] | None = None,
    corner: rrb.Corner2D = rrb.Corner2D.LeftTop,
    legend: bool = True,
) -> rrb.TimeSeriesView:
    """Return a plot of the scalars below an entity.

    Args:
        origin: The entity.
        name: Title.
        whole: Show the whole run, else what is near the cursor.
        top: Upper end of the vertical axis, which then begins at 0.
        contents: Entities to show; everything below the origin when None.
        corner: Of the legend.
        legend: False where the plot is too small for one.
    """
    return rrb.TimeSeriesView(
        origin=origin,
        contents=contents or "$origin/**",
        name=name,
        plot_legend=rrb.PlotLegend(corner=corner, visible=legend),
        axis_x=WHOLE_RUN if whole else None,
        time_ranges=None if whole else NEAR_CURSOR,
        axis_y=rrb.ScalarAxis(range=(0.0, top)) if top is not None else None,
    )


def td_error_plot() -> rrb.TimeSeriesView:
    """Return the curves of every goal's TD error, with a diamond where a goal was chosen."""
    return plot(
        "/learning",
        "TD error of every goal, log10 (4 is 10,000); diamond: chosen",
        contents=["/learning/td_error/**", "/learning/chosen"],
        corner=rrb.Corner2D.RightTop,
    )


def log(timelines: list[str]) -> rrb.TextLogView:
    """Return the log with a column for each of some timelines."""
    columns = rrb.TextLogColumns(
        timeline_columns=[blueprint_encodings.TimelineColumn(name) for name in timelines],
        text_log_columns=["LogLevel", "Body"],
    )
    return rrb.TextLogView(origin="/log", name="What happened, and why", columns=columns)


def table_view(entity: str, name: str, frame: GridFrame) -> rrb.Spatial2DView:
    """Return the picture of one goal's table."""
    origin = "/" + entity.removesuffix("/map")
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=bounds_of(frame), background=DARK)


def _legend(entity: str) -> rrb.Spatial2DView:
    bounds = rrb.VisualBounds2D(x_range=[-1.0, 10.0], y_range=[-0.5, LEGEND_ROWS + 0.5])
    return rrb.Spatial2DView(origin="/" + entity, name="Colours", visual_bounds=bounds, background=DARK)


def q_grid(goals: list[str], frame: GridFrame, columns: int) -> rrb.Grid:
    """Return the values of every goal side by side, and what their colours mean."""
    every = [table_view(goal_entity(index), goal, frame) for index, goal in enumerate(goals)]
    return rrb.Grid(*every, _legend(Q_LEGEND), grid_columns=columns, name="Q-values")


def td_grid(goals: list[str], frame: GridFrame, columns: int) -> rrb.Grid:
    """Return the TD errors of every goal side by side, and what their colours mean."""
    every = [table_view(td_entity(index), goal, frame) for index, goal in enumerate(goals)]
    return rrb.Grid(*every, _legend(TD_LEGEND), grid_columns=columns, name="TD errors")


def goal_lanes(name: str) -> rrb.StateTimelineView:
    """Return a lane per goal: waiting, current, learned."""
    return rrb.StateTimelineView(origin="/goals", name=name, time_view=WHOLE_RUN)


def choice() -> rrb.TextDocumentView:
    """Return which goal was chosen at the cursor, and the TD errors behind it."""
    return rrb.TextDocumentView(origin="/learning/choice", name="The goal at the cursor, and why it was chosen")


def totals() -> rrb.TextDocumentView:
    """Return the sums of all trials per goal."""
    return rrb.TextDocumentView(origin="/learning/totals", name="Trials of every goal in this recording so far")


def states() -> rrb.StateTimelineView:
    """Return the lanes of what every trial was for and how it ended."""
    return rrb.StateTimelineView(origin="/state", name="Goal, outcome and cause of every trial", time_view=WHOLE_RUN)


def map_view(frame: GridFrame, name: str) -> rrb.Spatial2DView:
    """Return the floor plan."""
    return rrb.Spatial2DView(
        origin="/drive",
        contents=["$origin/**", "- $origin/map/dwa/cost", "- $origin/map/belief/particles"],
        name=name,
        visual_bounds=bounds_of(frame),
        background=DARK,
    )


def belief_view(frame: GridFrame) -> rrb.Spatial2DView:
    """Return the floor plan with what the robot believes after its last look, without what hides it."""
    return rrb.Spatial2DView(
        origin="/drive",
        contents=["$origin/**", "- $origin/map/dwa/**", "- $origin/map/goals/names", "- $origin/map/scan"],
        name="Violet: what the last picture says alone; points: other places and their weights; dots: particles",
        visual_bounds=bounds_of(frame),
        background=DARK,
    )


def camera() -> rrb.Spatial2DView:
    """Return the camera's picture."""
    bounds = rrb.VisualBounds2D(x_range=[0, 84], y_range=[0, 84])
    return rrb.Spatial2DView(origin="/camera", contents="$origin/rgb", name="Camera", visual_bounds=bounds)


def errors() -> rrb.Vertical:
    """Return how far the robot is from where it believes to be."""
    return rrb.Vertical(
        plot("/metrics/position_error", "Position error [m]", whole=False),
        plot("/metrics/heading_error", "Heading error [deg]", whole=False),
    )


def confidence() -> rrb.TimeSeriesView:
    """Return how sure the robot is of its pose after every look."""
    return plot("/metrics/confidence", "Confidence, 0 to 1", whole=False, top=1.05, corner=rrb.Corner2D.LeftBottom)


def spread() -> rrb.TimeSeriesView:
    """Return how widely the belief is spread about the pose."""
    return plot("/metrics/spread", "Spread [m]", whole=False)


def about_tab() -> rrb.TextDocumentView:
    """Return the guide."""
    return rrb.TextDocumentView(origin="/readme", name="About")
