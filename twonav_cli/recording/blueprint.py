"""How the viewer lays out each kind of recording: one layout per application id."""

from __future__ import annotations

from dataclasses import dataclass

import rerun as rr
import rerun.blueprint as rrb
from rerun.blueprint import components as blueprint_components
from rerun.blueprint import encodings as blueprint_encodings

from twonav_cli.grid import GridFrame
from twonav_cli.recording.scenery import goal_entity

_EDGE = rr.TimeRangeBoundary
# Without this a plot shows only a thousand ticks around the cursor.
WHOLE_RUN = rrb.TimeAxis(view_range=rr.TimeRange(start=_EDGE.infinite(), end=_EDGE.infinite()))
NEAR_CURSOR = [
    rrb.VisibleTimeRange("sim_time", start=_EDGE.cursor_relative(seconds=-30), end=_EDGE.cursor_relative(seconds=10)),
    rrb.VisibleTimeRange("step", start=_EDGE.cursor_relative(seq=-60), end=_EDGE.cursor_relative(seq=20)),
]
LEGEND = rrb.PlotLegend(corner=rrb.Corner2D.LeftTop)
MARGIN_M = 0.3


@dataclass(frozen=True)
class Replay:
    """The stretch of simulated time that is marked when a recording opens."""

    start_s: float
    end_s: float


def _bounds(frame: GridFrame) -> rrb.VisualBounds2D:
    return rrb.VisualBounds2D(
        x_range=[frame.x_min_m - MARGIN_M, frame.x_max_m + MARGIN_M],
        y_range=[-frame.y_max_m - MARGIN_M, -frame.y_min_m + MARGIN_M],
    )


def _panels(time: rrb.TimePanel) -> tuple[rrb.TimePanel, rrb.SelectionPanel, rrb.BlueprintPanel]:
    return time, rrb.SelectionPanel(state="collapsed"), rrb.BlueprintPanel(state="collapsed")


def _plot(origin: str, name: str, *, whole: bool = True, top: float | None = None) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        origin=origin,
        name=name,
        plot_legend=LEGEND,
        axis_x=WHOLE_RUN if whole else None,
        time_ranges=None if whole else NEAR_CURSOR,
        axis_y=rrb.ScalarAxis(range=(0.0, top)) if top is not None else None,
    )


def _log(timelines: list[str]) -> rrb.TextLogView:
    columns = rrb.TextLogColumns(
        timeline_columns=[blueprint_encodings.TimelineColumn(name) for name in timelines],
        text_log_columns=["LogLevel", "Body"],
    )
    return rrb.TextLogView(origin="/log", name="What happened, and why", columns=columns)


def _q_view(entity: str, name: str, frame: GridFrame) -> rrb.Spatial2DView:
    origin = "/" + entity.removesuffix("/map")
    return rrb.Spatial2DView(origin=origin, name=name, visual_bounds=_bounds(frame), background=[18, 18, 18])


def _q_grid(goals: list[str], frame: GridFrame, columns: int) -> rrb.Grid:
    every = [_q_view(goal_entity(i), goal, frame) for i, goal in enumerate(goals)]
    return rrb.Grid(*every, grid_columns=columns, name="Q-values")


def _q_tab(goals: list[str], frame: GridFrame) -> rrb.Horizontal:
    chosen = rrb.Vertical(
        _q_view("q/chosen/map", "Goal driven to: value of the best action, greedy action", frame),
        _plot("/metrics/q_values", "Q of the four actions where the robot believes to be", whole=False),
        row_shares=[3, 2],
    )
    return rrb.Horizontal(chosen, _q_grid(goals, frame, 2), column_shares=[3, 4], name="Q-values")


def _learning_tab() -> rrb.Horizontal:
    curves = rrb.Vertical(
        _plot("/learning/td_error", "TD error per goal after the trial, log10"),
        _plot("/learning/steps", "Actions per trial"),
        _plot("/learning/reached", "Share of the last trials that reached the goal", top=1.05),
    )
    choice = rrb.Vertical(
        rrb.TextDocumentView(origin="/learning/choice", name="Goals: chosen, and why"),
        rrb.BarChartView(origin="/learning/choices", name="How often each goal was chosen (in the order above)"),
        row_shares=[3, 2],
    )
    return rrb.Horizontal(curves, choice, column_shares=[3, 1], name="Learning")


_TRIAL_COLUMNS = ("number", "goal", "outcome", "cause", "evidence", "steps", "shortest", "start_row", "start_col")


def _trials_tab(timeline: str) -> rrb.DataframeView:
    query = rrb.archetypes.DataframeQuery(
        timeline=timeline, select=[timeline, *(f"/trials:{name}" for name in _TRIAL_COLUMNS)]
    )
    return rrb.DataframeView(origin="/trials", name="Trials", query=query)


def _about_tab() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(origin="/readme", name="About")


def _map_view(frame: GridFrame, name: str) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(
        origin="/drive",
        contents=["$origin/**", "- $origin/map/dwa/cost"],
        name=name,
        visual_bounds=_bounds(frame),
        background=[18, 18, 18],
    )


def _states() -> rrb.StateTimelineView:
    return rrb.StateTimelineView(origin="/state", name="Goal, outcome and cause of every trial", time_view=WHOLE_RUN)


def _camera() -> rrb.Spatial2DView:
    bounds = rrb.VisualBounds2D(x_range=[0, 84], y_range=[0, 84])
    return rrb.Spatial2DView(origin="/camera", contents="$origin/rgb", name="Camera", visual_bounds=bounds)


def _errors() -> rrb.Vertical:
    return rrb.Vertical(
        _plot("/metrics/position_error", "Position error [m]", whole=False),
        _plot("/metrics/heading_error", "Heading error [deg]", whole=False),
    )


def drive_blueprint(goals: list[str], frame: GridFrame, replay: Replay | None) -> rrb.Blueprint:
    """Lay out a run in the 3D stage.

    Args:
        goals: Names of the goals.
        frame: Where the floor plan lies.
        replay: What to mark; None while the run goes on. The cursor opens on the end: there every failure is
            on the map and in the log (the layout cannot place the cursor elsewhere).
    """
    left = rrb.Vertical(
        _map_view(frame, "Map: is (blue), believes (magenta), localizer (orange)"), _states(), row_shares=[7, 2]
    )
    right = rrb.Vertical(
        rrb.Horizontal(_camera(), _errors(), column_shares=[1, 1]), _log(["trial", "sim_time"]), row_shares=[1, 1]
    )
    drive = rrb.Horizontal(left, right, column_shares=[5, 4], name="Drive")
    near = rrb.Spatial2DView(
        origin="/drive/map/here",
        contents=["/drive/**", "- /drive/map/goals/**", "- /drive/map/failures/**"],
        name="Around the robot: candidates by cost (dark is cheap, red would touch), chosen (black), cost map",
        visual_bounds=rrb.VisualBounds2D(x_range=[-1.6, 1.6], y_range=[-1.6, 1.6]),
        background=[18, 18, 18],
    )
    controller = rrb.Horizontal(near, rrb.Vertical(_camera(), _errors()), column_shares=[3, 2], name="Controller")
    selection = (
        blueprint_components.AbsoluteTimeRange(round(replay.start_s * 1e9), round(replay.end_s * 1e9))
        if replay
        else None
    )
    time = rrb.TimePanel(
        timeline="sim_time",
        state="collapsed",
        play_state="following",
        time_selection=selection,
    )
    tabs = rrb.Tabs(
        drive,
        _q_tab(goals, frame),
        _learning_tab(),
        controller,
        rrb.TextDocumentView(origin="/learning/trials", name="Trials"),
        _about_tab(),
        active_tab=0,
        name="twonav",
    )
    return rrb.Blueprint(tabs, *_panels(time))


def maze_blueprint(goals: list[str], frame: GridFrame) -> rrb.Blueprint:
    """Lay out a run in the maze."""
    maze = rrb.Horizontal(
        rrb.Vertical(_map_view(frame, "Maze"), _states(), row_shares=[7, 2]),
        _log(["trial", "step"]),
        column_shares=[5, 4],
        name="Maze",
    )
    time = rrb.TimePanel(timeline="trial", state="collapsed", play_state="following", fps=20)
    tabs = rrb.Tabs(
        _learning_tab(), _q_grid(goals, frame, 4), maze, _trials_tab("trial"), _about_tab(), active_tab=0, name="twonav"
    )
    return rrb.Blueprint(tabs, *_panels(time))


FITTING_UNITS = {"m": "metres", "deg": "degrees", "rad": "radians", "": "other"}
"""Last part of a metric's name to the plot it is drawn in."""


def fitting_blueprint(units: list[str]) -> rrb.Blueprint:
    """Lay out the training of a network.

    Args:
        units: Plots that have something to show (values of FITTING_UNITS).
    """
    measured = [_plot(f"/val/{unit}", f"Validation, {unit}") for unit in units]
    curves = rrb.Grid(
        _plot("/train/loss", "Loss"),
        *measured,
        _plot("/train/learning_rate", "Learning rate"),
        _plot("/train/images_per_s", "Images per second"),
        name="Curves",
    )
    log = _log(["batch", "epoch"])
    time = rrb.TimePanel(timeline="batch", state="collapsed", play_state="following")
    return rrb.Blueprint(
        rrb.Tabs(rrb.Vertical(curves, log, row_shares=[4, 1], name="Curves"), _about_tab(), active_tab=0),
        *_panels(time),
    )
