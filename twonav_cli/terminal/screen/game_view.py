"""The numbers of the game as rich text: Q-values, poses, goals, log, and the two lines at the bottom."""

from __future__ import annotations

import math
from textwrap import wrap

import numpy as np
from rich.text import Text

from twonav_cli.events import confidence_of, other_places
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.maze import Action
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.floor_plan import Plan, goal_key, plan_of_map, plan_of_maze
from twonav_cli.terminal.screen.game import GameState, headline, pose_error, tally
from twonav_cli.terminal.screen.keys import Controls
from twonav_cli.terminal.screen.palette import hexadecimal, viridis
from twonav_cli.terminal.screen.plan_drawing import Marks

ARROWS = "↑↓←→"
EIGHTHS = " ▏▎▍▌▋▊▉█"
LEVELS = "▁▂▃▄▅▆▇█"
QUIET = hexadecimal(palette.QUIET)
TRUE = hexadecimal(palette.TRUE)
ESTIMATE = hexadecimal(palette.ESTIMATE)
GOAL = hexadecimal(palette.CURRENT_GOAL)
ALARM = hexadecimal(palette.ALARM)
OTHER = hexadecimal(palette.OTHER)
UNSURE = 0.5
"""Confidence below which it stands out (ours)."""

POSE_ROWS = 6
"""Lines about the poses without the other places; where there is less room, cell and action go first."""

LOST_M = 0.45
"""Error from which the robot counts as lost (Fox, Burgard, Thrun 1999)."""


def plan_of_game(state: GameState) -> Plan | None:
    """Return the floor plan of the run: its map, else its maze, None before there is one."""
    run, frame = state.run, state.maze_frame
    if run is None or run.maze is None or frame is None:
        return None
    if run.occupied is None or run.map_frame is None:
        return plan_of_maze(run.maze, frame)
    goals = {name: frame.centre_of(cell) for name, cell in run.maze.goals.items()}
    return plan_of_map(run.occupied, run.map_frame, goals, {}, frame)


def marks_of_game(state: GameState, heat: bool = True) -> Marks:
    """Return what moves on the plan, with or without the heat of the belief."""
    goal = state.goal_index
    shown = goal is not None and state.greedy is not None and state.values is not None
    return Marks(
        goal=state.goal,
        pose_true=state.pose_true,
        pose_estimate=state.pose_estimate,
        trail=state.trail,
        scan_m=state.scan_m,
        arrows=state.greedy[goal] if shown and state.greedy is not None else None,
        values=state.values[goal] if shown and state.values is not None else None,
        belief=state.belief if heat else None,
        others=tuple((float(x_m), float(y_m)) for _, x_m, y_m in other_places(state.belief, state.filtered)),
    )


def q_text(state: GameState, cols: int) -> Text:
    """Return the four Q-values as labelled bars: the best one is marked ◀, the one taken is bold."""
    if state.q_values is None:
        return Text("no action yet", style=QUIET)
    q = state.q_values
    bar_cols = max(cols - 18, 3)
    low, high = min(float(q.min()), 0.0), max(float(q.max()), 1e-9)
    lines = []
    for action in Action:
        share = (float(q[action]) - low) / (high - low)
        best = q[action] == q.max()
        label = "bold" if action == state.action else QUIET
        colour = hexadecimal(tuple(int(c) for c in viridis(np.array([share]))[0]))  # type: ignore[arg-type]  # 3 long
        line = Text.assemble((f"{ARROWS[action]} {action.name.lower():<5} ", label))
        line.append(bar(share, bar_cols), colour)
        line.append(f"{q[action]:7.2f}", "bold" if best else QUIET)
        line.append(" ◀" if best else "  ", GOAL)
        lines.append(line)
    return Text("\n").join(lines)


def values_text(state: GameState, cols: int) -> Text:
    """Return the Q-values of the four actions, and below them the TD error."""
    return Text("\n").join([q_text(state, cols), td_text(state, cols)])


def bar(share: float, cols: int) -> str:
    """Return a bar of `cols` characters, filled to a share in eighths of a character."""
    eighths = round(min(max(share, 0.0), 1.0) * cols * 8)
    full, rest = divmod(eighths, 8)
    return ("█" * full + (EIGHTHS[rest] if rest else "")).ljust(cols)[:cols]


def td_text(state: GameState, cols: int) -> Text:
    """Return the TD error of the last step, and a line of the latest ones, each as high as its logarithm."""
    if state.td_error is None:
        return Text("TD error  -", style=QUIET)
    text = Text.assemble(("TD error ", QUIET), (f"{state.td_error:.3g} ", "bold"))
    room = max(cols - len(text), 0)
    heights = np.log10(np.array(state.td_history[-room:] if room else ()) + 1e-6)
    for height in np.clip((heights + 6) / 10, 0, 0.999):
        text.append(LEVELS[int(height * len(LEVELS))], TRUE)
    return text


def pose_text(state: GameState, rows: int = POSE_ROWS + 2) -> Text:
    """Return both poses, the error between them, how sure the robot is, where else it could be, and both cells."""
    lines = [
        Text.assemble(("true   ", TRUE), _pose(state.pose_true)),
        Text.assemble(("belief ", ESTIMATE), _pose(state.pose_estimate)),
    ]
    error = pose_error(state)
    if error is not None:
        lost = error[0] >= LOST_M
        style = f"bold {ALARM}" if lost else "bold"
        away = f"{error[0]:.2f} m" if lost else f"{error[0] * 100:.1f} cm"
        sentence = f"{away}, {math.degrees(error[1]):.{0 if lost else 1}f}°"
        lines.append(Text.assemble(("error  ", QUIET), (sentence + " lost" * lost, style)))
    lines += _doubts(state, at_most=max(rows - POSE_ROWS, 1))
    lines.append(Text.assemble(("cell   ", QUIET), _cells(state.cell_true, state.cell_believed)))
    outcome = state.action_outcome + ("" if state.action_greedy else ", exploring")
    lines.append(Text.assemble(("action ", QUIET), outcome or "-"))
    return Text("\n").join(lines[:rows])


def _doubts(state: GameState, at_most: int) -> list[Text]:
    """Return the confidence as one number, with the filter's spread, and the likeliest other places with weights."""
    confidence = confidence_of(state.belief, state.filtered)
    if confidence is None:
        return []
    spread = f" ±{state.filtered.spread_m * 100:.0f} cm" if state.filtered is not None else ""
    style = f"bold {ALARM}" if confidence < UNSURE else "bold"
    sure = Text.assemble(("sure   ", QUIET), (f"{confidence:.2f}", style), (spread, QUIET))
    others = other_places(state.belief, state.filtered)[:at_most]
    return [sure, *(Text(f"or {w:.2f} at ({x_m:.1f}, {y_m:.1f})", style=OTHER) for w, x_m, y_m in others)]


def _pose(pose: Pose | None) -> str:
    return f"{pose.x_m:5.2f} {pose.y_m:5.2f} m {math.degrees(pose.theta_rad) % 360:3.0f}°" if pose else "-"


def _cells(true: Cell | None, believed: Cell | None) -> Text:
    """Return the true cell, and the believed one when that is wrong."""
    if true is None:
        return Text("-")
    text = Text(f"({true.row}, {true.col})")
    if believed is not None and believed != true:
        text.append(f" ≠({believed.row}, {believed.col})", ALARM)
    return text


def goals_text(state: GameState, cols: int, rows: int) -> Text:
    """Return the goals with their keys and TD errors, in two columns without errors where one is too long."""
    names = state.goal_names
    if not names:
        return Text("no goals yet", style=QUIET)
    columns = 1 if len(names) <= rows else 2
    width = cols // columns
    lines = [Text() for _ in range(math.ceil(len(names) / columns))]
    for at, name in enumerate(names):
        lines[at % len(lines)].append_text(_goal(state, at, name, width, columns == 1))
    return Text("\n").join(lines[:rows])


def _goal(state: GameState, at: int, name: str, width: int, wide: bool) -> Text:
    """Return one goal: key, name, whether it is learned, and its TD error when `wide`."""
    style = f"bold {GOAL}" if name == state.goal else ""
    error = ""
    if wide and state.td_of_goals is not None and at < len(state.td_of_goals):
        error = f"{state.td_of_goals[at]:9.3g}"
    room = width - 4 - len(error)
    mark = "✓" if name in state.learned else " "
    short = name if len(name) <= room else name[: room - 1] + "…"
    key = Text().append(f"{goal_key(at) or '·'} ", style or QUIET)
    return key.append(short.ljust(room), style).append(f"{mark}", GOAL).append(error, QUIET).append(" ")


def log_text(state: GameState, cols: int, rows: int) -> Text:
    """Return the last lines of the log, each wrapped to the width; warnings stand out."""
    colours = {"WARN": ALARM, "ERROR": f"bold {ALARM}"}
    lines = [
        Text(part, style=colours.get(line.level, ""))
        for line in state.log[-rows:]
        for part in wrap(line.text, max(cols, 1), subsequent_indent=" " if cols > 1 else "")
    ]
    return Text("\n").join(lines[-rows:])


def status_text(state: GameState, controls: Controls, title: str, cols: int) -> Text:
    """Return the last line of the screen: the headline at the left; tally, clock and speed at the right."""
    left = Text(f" {headline(state)}", style="bold")
    right = [title, tally(state)] if state.outcomes else [title]
    right.append(f"{state.clock.time_s:.1f} s")
    if controls.speed is not None:
        right.append(f"x{controls.speed:g}" if controls.speed > 0 else "no speed limit")
    if state.ended:
        right.append("ended")
    elif controls.paused:
        right.append("PAUSED")
    while len(right) > 1 and len(left) + len(" · ".join(right)) + 3 > cols:
        right.pop(0)
    end = Text(" · ".join(right) + " ", style="bold" if controls.paused else "")
    gap = max(cols - len(left) - len(end), 1)
    return left.append(" " * gap).append_text(end)


def hint_text(state: GameState, controls: Controls, cols: int) -> Text:
    """Return what the keys do now, as many of them as fit."""
    leave = [("?", "help"), ("q", "leave")]
    pairs = [("g", "goal"), ("1-9", "pick"), ("k", "kidnap"), ("space", "go on" if controls.paused else "pause")]
    pairs += [(".", "step"), ("+ -", "speed"), ("arrows", "drive"), ("b", "belief"), ("tab", "panels")]
    if controls.driving:
        pairs = [("arrows hjkl wasd", "you drive"), ("esc", "hand back"), ("K", "kidnap")]
    elif state.ended:
        pairs = [("tab", "panels")]
    while pairs and sum(len(key) + len(meaning) + 3 for key, meaning in pairs + leave) > cols:
        pairs.pop()
    text = Text(" ")
    for key, meaning in pairs + leave:
        text.append(key, f"bold {TRUE}").append(f" {meaning}  ", QUIET)
    return text


def notice_text(text: str, bad: bool, cols: int) -> Text:
    """Return an answer of the prompt as one line; an error stands out."""
    return Text(f" {text}"[:cols], style=f"bold {ALARM}" if bad else "bold")
