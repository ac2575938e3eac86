"""How the viewer lays out each kind of recording: one layout per application id."""

from __future__ import annotations

from dataclasses import dataclass

import rerun.blueprint as rrb
from rerun.blueprint import components as blueprint_components

from twonav_cli.grid import GridFrame
from twonav_cli.recording import views
from twonav_cli.recording.table_scenery import CHOSEN


@dataclass(frozen=True)
class Replay:
    """The stretch of simulated time that is marked when a recording opens."""

    start_s: float
    end_s: float


def _belief_tab(frame: GridFrame) -> rrb.Horizontal:
    beside = rrb.Vertical(
        rrb.Horizontal(views.camera(), views.confidence(), column_shares=[1, 1]),
        rrb.Horizontal(views.errors(), views.spread(), column_shares=[1, 1]),
        views.log(["trial", "sim_time"]),
        row_shares=[4, 4, 3],
    )
    return rrb.Horizontal(views.belief_view(frame), beside, column_shares=[5, 4], name="Belief")


def _q_tab(goals: list[str], frame: GridFrame) -> rrb.Horizontal:
    chosen = rrb.Vertical(
        views.table_view(CHOSEN, "Goal driven to: value of the best action, greedy action", frame),
        views.plot("/metrics/q_values", "Q of the four actions where the robot believes to be", whole=False),
        row_shares=[3, 2],
    )
    return rrb.Horizontal(chosen, views.q_grid(goals, frame, 3), column_shares=[2, 3], name="Q-values")


def _learning_tab() -> rrb.Horizontal:
    curves = rrb.Vertical(
        views.td_error_plot(),
        views.plot("/learning/steps", "Actions per trial"),
        views.plot("/learning/reached", "Share of the last trials that reached the goal", top=1.05),
        views.goal_lanes("Goals over the run"),
        row_shares=[6, 5, 3, 9],
    )
    choice = rrb.Vertical(views.choice(), views.totals(), row_shares=[1, 1])
    return rrb.Horizontal(curves, choice, column_shares=[2, 1], name="Learning")


_TRIAL_COLUMNS = ("number", "goal", "outcome", "cause", "evidence", "steps", "shortest", "start_row", "start_col")


def _trials_tab(timeline: str) -> rrb.DataframeView:
    query = rrb.archetypes.DataframeQuery(
        timeline=timeline, select=[timeline, *(f"/trials:{name}" for name in _TRIAL_COLUMNS)]
    )
    return rrb.DataframeView(origin="/trials", name="Trials", query=query)


def _seen(camera: bool) -> list[rrb.Spatial2DView]:
    """Return the view of the camera if there is one; each tab needs its own, or the viewer leaves one of them empty."""
    return [views.camera()] if camera else []


def _controller_tab(camera: bool) -> rrb.Horizontal:
    near = rrb.Spatial2DView(
        origin="/drive/map/here",
        contents=["/drive/**", "- /drive/map/goals/**", "- /drive/map/failures/**"],
        name="Around the robot: candidates by cost (dark is cheap, red would touch), chosen (black), cost map",
        visual_bounds=rrb.VisualBounds2D(x_range=[-1.6, 1.6], y_range=[-1.6, 1.6]),
        background=views.DARK,
    )
    beside = rrb.Vertical(*_seen(camera), views.errors())
    return rrb.Horizontal(near, beside, column_shares=[3, 2], name="Controller")


MAP_TITLE, PICTURE_TITLE = "Map: is (blue), believes (magenta), last look (orange)", ", what its picture says (violet)"


def drive_blueprint(goals: list[str], frame: GridFrame, replay: Replay | None, *, camera: bool = True) -> rrb.Blueprint:
    """Lay out a run in which a robot drives.

    Args:
        goals: Names of the goals.
        frame: Where the floor plan lies.
        replay: What to mark; None while the run goes on. The cursor opens on the end: there every failure is
            on the map and in the log (the layout cannot place the cursor elsewhere).
        camera: Whether the robot has one, and so has to estimate where it is.
    """
    left = rrb.Vertical(
        views.map_view(frame, MAP_TITLE + (PICTURE_TITLE if camera else "")),
        views.states(),
        row_shares=[7, 2],
    )
    right = rrb.Vertical(
        rrb.Horizontal(*_seen(camera), views.errors(), column_shares=[1] * (1 + camera)),
        views.log(["trial", "sim_time"]),
        row_shares=[1, 1],
    )
    drive = rrb.Horizontal(left, right, column_shares=[5, 4], name="Drive")
    selection = (
        blueprint_components.AbsoluteTimeRange(round(replay.start_s * 1e9), round(replay.end_s * 1e9))
        if replay
        else None
    )
    time = rrb.TimePanel(timeline="sim_time", state="collapsed", play_state="following", time_selection=selection)
    tabs = rrb.Tabs(
        drive,
        *([_belief_tab(frame)] if camera else []),
        _q_tab(goals, frame),
        views.td_grid(goals, frame, 4),
        _learning_tab(),
        _controller_tab(camera),
        rrb.TextDocumentView(origin="/learning/trials", name="Trials"),
        views.about_tab(),
        active_tab=0,
        name="twonav",
    )
    return rrb.Blueprint(tabs, *views.panels(time))


def maze_blueprint(goals: list[str], frame: GridFrame, top: float, *, learns: bool) -> rrb.Blueprint:
    """Lay out a run in the maze.

    Args:
        goals: Names of the goals.
        frame: Where the floor plan lies.
        top: Actions at which the plot of actions ends: the very first trials would hide all the others.
        learns: Open on the story of the training, else on the maze.
    """
    actions = views.plot(
        "/learning/round",
        f"Actions per trial, mean over a trial from each start (the first ones go beyond {top:.0f})",
        top=top,
        corner=rrb.Corner2D.RightTop,
    )
    curves = rrb.Vertical(
        views.goal_lanes("Goals: waiting, current, learned"), views.td_error_plot(), actions, row_shares=[10, 6, 5]
    )
    words = rrb.Vertical(views.log(["trial"]), views.choice(), views.totals(), row_shares=[10, 11, 10])
    story = rrb.Horizontal(curves, words, column_shares=[5, 3], name="Story")
    maze = rrb.Horizontal(
        rrb.Vertical(views.map_view(frame, "Maze"), views.states(), row_shares=[7, 2]),
        rrb.Vertical(
            views.plot("/learning/steps", "Actions of every trial"),
            views.plot("/learning/reached", "Share of the last trials that reached the goal", top=1.05),
            views.log(["trial", "step"]),
        ),
        column_shares=[5, 4],
        name="Maze",
    )
    # 20 trials a second: what happens early is seen, and the rest by dragging the cursor.
    time = rrb.TimePanel(timeline="trial", state="collapsed", play_state="following", fps=20)
    tabs = rrb.Tabs(
        story,
        views.q_grid(goals, frame, 4),
        views.td_grid(goals, frame, 4),
        maze,
        _trials_tab("trial"),
        views.about_tab(),
        active_tab=0 if learns else 3,
        name="twonav",
    )
    return rrb.Blueprint(tabs, *views.panels(time))


FITTING_UNITS = {"m": "metres", "deg": "degrees", "rad": "radians", "": "other"}
"""Last part of a metric's name to the plot it is drawn in."""


def fitting_blueprint(units: list[str]) -> rrb.Blueprint:
    """Lay out the training of a network.

    Args:
        units: Plots that have something to show (values of FITTING_UNITS).
    """
    measured = [views.plot(f"/val/{unit}", f"Validation, {unit}") for unit in units]
    curves = rrb.Grid(
        views.plot("/train/loss", "Loss"),
        *measured,
        views.plot("/train/learning_rate", "Learning rate"),
        views.plot("/train/images_per_s", "Images per second"),
        name="Curves",
    )
    log = views.log(["batch", "epoch"])
    time = rrb.TimePanel(timeline="batch", state="collapsed", play_state="following")
    return rrb.Blueprint(
        rrb.Tabs(rrb.Vertical(curves, log, row_shares=[4, 1], name="Curves"), views.about_tab(), active_tab=0),
        *views.panels(time),
    )
