"""One action, control period by control period: what the driver carries, and what it commands next (§3.1.3).

An action goes through phases: it follows a leg to the target, brakes, goes back to where it began if it was blocked,
and brakes again. Whoever drives the robot asks for one command after the other: the physics of 3D, or the compiled loop
of 2D. N corners of the outline, h x w cells of the window.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from twonav_cli.compiled import compiled
from twonav_cli.config import DriveConfig
from twonav_cli.geometry import Pose, Twist
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.costmap import (
    FROM_BEAM,
    SUBDIVISION,
    Window,
    lay_window,
    new_window,
    see_scan,
    standing_outline,
    window_pixels,
)
from twonav_cli.navigation.distance import fill_distances
from twonav_cli.navigation.dwa import (
    Choices,
    Leg,
    Planner,
    command_of,
    new_choices,
    overlap_at,
    plan_period,
    planner_for,
)
from twonav_cli.navigation.dwa_costs import DwaWeights
from twonav_cli.navigation.footprint import FloatArray, WindowGrid, touches
from twonav_cli.navigation.outcomes import BLOCKED, REACHED, TIMED_OUT

STILL_MPS = 0.03
"""Slower than this the robot stands (ours)."""

STILL_RADPS = 0.1
"""Turning slower than this the robot stands (ours)."""

FACING_RAD = 0.5
"""Within this angle of the direction of travel the range finder sees what is ahead (ours)."""

TURN_FIRST_RAD = 0.35
"""A differential base that is off by more turns on the spot before it drives (ours)."""

AIM_M = 0.12
"""Nearer than this to the target the direction to it says nothing any more (ours)."""

NEAR_ENOUGH_M = 0.12
"""A robot that stands this near and can get no nearer has reached the cell: its own cell ends at 0.2 m (ours)."""

ROOM_SHORT_M = 0.1
"""Room for the footprint this far before the target is room enough to go on (ours)."""

PROGRESS_M = 0.005
PROGRESS_RAD = 0.05
"""What counts as getting on: nearer, or turned further towards the direction of travel (ours)."""

IDLE_PERIODS = 2
"""Periods in a row in which standing still was the best choice, after which an action is blocked (ours)."""

RETURN_S = 1.2
"""Time a blocked robot has to go back to where it started (ours)."""

RETURN_BEYOND_M = 0.02
"""A blocked robot nearer than this to where it started stays (ours)."""

BRAKE_PERIODS = 10
"""Periods after which braking is given up; a body that obeys needs four (ours)."""

UNPARKING = DwaWeights(target=0.2, heading=0.3, clearance=0.3, path=0.1)
"""Weights of a differential base that has no room to turn on the spot: away from the wall, and round (ours)."""

UNPARKING_M = 0.12
"""How far from where it started the robot may look for room to turn: it must stay in its cell (ours)."""

FOLLOW, BRAKE, GO_BACK, STAND, DONE = range(5)
"""Phases of an action."""

OUTCOMES = (REACHED, BLOCKED, TIMED_OUT)
HAS_REACHED, IS_BLOCKED, HAS_TIMED_OUT = range(3)
"""Outcomes as the compiled loop names them: indices into OUTCOMES."""

OPEN = -1
"""The outcome of a leg that is still driven."""

NOTHING_PLANNED = -2
"""The chosen candidate of a period in which the robot only brakes."""

DRIVE = np.dtype(
    [
        ("phase", np.int64), ("outcome", np.int64), ("periods", np.int64), ("idle_periods", np.int64),
        ("allowed_overlap", np.int64), ("best", np.int64), ("count", np.int64),
        ("left_m", np.float64), ("error_rad", np.float64), ("since_s", np.float64),
        ("begin_x_m", np.float64), ("begin_y_m", np.float64),
        ("start_x_m", np.float64), ("start_y_m", np.float64),
        ("target_x_m", np.float64), ("target_y_m", np.float64), ("heading_rad", np.float64),
        ("grid_x_m", np.float64), ("grid_y_m", np.float64), ("cell_m", np.float64),
    ]
)  # fmt: skip
"""What one action carries from period to period:

phase and outcome; periods of this phase, and how many of the last were idle; outline points that may lie on marks, -1
before the first look; the chosen candidate and how many there were; how near the target and the heading the robot has
come, and when it last got on; where the action began; the present leg; where the window lies.
"""

DriveState = NDArray[Any]
"""[1] of DRIVE."""


class Limits(NamedTuple):
    """What DriveConfig says about time and place."""

    tick_s: float
    timeout_s: float
    blocked_after_s: float
    position_tolerance_m: float
    range_cut_m: float


class Setup(NamedTuple):
    """What stays the same from action to action: the base, the map and the robot's outline."""

    planner: Planner
    unparking: Planner
    limits: Limits
    occupied: NDArray[np.bool_]
    map_grid: WindowGrid
    body: FloatArray
    """[N, 2] corners within which nothing can be: the robot stands there."""


class Board(NamedTuple):
    """What is written while driving: the window, what is weighed, and distances to what beams have hit [h, w]."""

    window: Window
    choices: Choices
    seen: NDArray[np.uint8]
    seen_m: FloatArray


def setup_for(config: DriveConfig, base: str, occupied: NDArray[np.bool_], map_frame: GridFrame) -> Setup:
    """Return how a base drives on a map [rows, cols]."""
    limits = Limits(
        config.tick_s, config.timeout_s, config.blocked_after_s, config.position_tolerance_m, config.range_cut_m
    )
    return Setup(
        planner_for(config, base),
        planner_for(config, base, UNPARKING),
        limits,
        np.ascontiguousarray(occupied, dtype=np.bool_),
        WindowGrid(map_frame.x_min_m, map_frame.y_min_m, map_frame.resolution_m),
        standing_outline(),
    )


def new_board(setup: Setup) -> Board:
    """Return what a drive writes into."""
    side = window_pixels(setup.map_grid.resolution_m) * SUBDIVISION
    seen_m = np.zeros((side, side), dtype=np.float64)
    return Board(new_window(side), new_choices(setup.planner.omni), np.zeros((side, side), dtype=np.uint8), seen_m)


def new_drive() -> DriveState:
    """Return the state of an action."""
    return np.zeros(1, dtype=DRIVE)


@compiled
def stands(forward_mps: float, left_mps: float, turn_radps: float) -> bool:
    """Whether a twist is as good as none."""
    return math.hypot(forward_mps, left_mps) <= STILL_MPS and abs(turn_radps) <= STILL_RADPS


@compiled
def _begin_leg(drive: Any, x_m: float, y_m: float, target_x_m: float, target_y_m: float, heading_rad: float) -> None:
    drive.start_x_m, drive.start_y_m = x_m, y_m
    drive.target_x_m, drive.target_y_m, drive.heading_rad = target_x_m, target_y_m, heading_rad
    drive.left_m, drive.error_rad, drive.since_s = np.inf, np.inf, 0.0
    drive.periods = drive.idle_periods = 0


@compiled
def begin_drive(
    setup: Setup, board: Board, drives: DriveState, believed: Pose, target_x_m: float, target_y_m: float
) -> None:
    """Begin an action: from where the robot believes to be to a neighbouring cell's centre (map frame, metres)."""
    drive = drives[0]
    grid = lay_window(board.window, setup.occupied, setup.map_grid, setup.body, believed, target_x_m, target_y_m)
    drive.grid_x_m, drive.grid_y_m, drive.cell_m = grid.x_min_m, grid.y_min_m, grid.resolution_m
    heading = math.atan2(target_y_m - believed[1], target_x_m - believed[0])
    _begin_leg(drive, believed[0], believed[1], target_x_m, target_y_m, heading)
    drive.begin_x_m, drive.begin_y_m = believed[0], believed[1]
    drive.phase, drive.outcome, drive.allowed_overlap = FOLLOW, OPEN, -1
    drive.best, drive.count = NOTHING_PLANNED, 0


@compiled
def _leg_of(drive: Any) -> Leg:
    return Leg(drive.start_x_m, drive.start_y_m, drive.target_x_m, drive.target_y_m, drive.heading_rad)


@compiled
def _grid_of(drive: Any) -> WindowGrid:
    return WindowGrid(drive.grid_x_m, drive.grid_y_m, drive.cell_m)


@compiled
def _look(setup: Setup, board: Board, drive: Any, believed: Pose, scan_m: FloatArray) -> None:
    """Update the cost map by a scan [180], and note how far the robot seems to stand in something."""
    grid = _grid_of(drive)
    see_scan(board.window, grid, believed, scan_m, setup.limits.range_cut_m)
    overlap = overlap_at(board.window.distance_m, grid, setup.planner.robot, believed)
    before = drive.allowed_overlap
    # Once free or freer, never deeper again: a creeping robot would otherwise raise its own allowance.
    drive.allowed_overlap = overlap if before <= 0 else min(before, overlap)
    if overlap > 0:
        drive.allowed_overlap = max(drive.allowed_overlap, 1)


@compiled
def _measure(drive: Any, believed: Pose, time_s: float) -> tuple[float, float]:
    """Aim, note whether the robot got on; return how far the target (m) and the wanted heading (rad) are."""
    dx, dy = drive.target_x_m - believed[0], drive.target_y_m - believed[1]
    left_m = math.hypot(dx, dy)
    # Very near the target the direction to it means nothing.
    if drive.phase == FOLLOW and left_m >= AIM_M:
        drive.heading_rad = math.atan2(dy, dx)
    error_rad = abs((drive.heading_rad - believed[2] + math.pi) % (2.0 * math.pi) - math.pi)
    if left_m < drive.left_m - PROGRESS_M or error_rad < drive.error_rad - PROGRESS_RAD:
        drive.since_s = time_s
    drive.left_m, drive.error_rad = min(drive.left_m, left_m), min(drive.error_rad, error_rad)
    return left_m, error_rad


@compiled
def _plan(
    setup: Setup, board: Board, drive: Any, believed: Pose, twist: Twist, error_rad: float, prune: bool
) -> tuple[float, float, float]:
    """Plan one period and return the twist; a differential base that cannot turn on the spot may try arcs."""
    leg, grid, distance_m = _leg_of(drive), _grid_of(drive), board.window.distance_m
    allowed, choices = max(drive.allowed_overlap, 0), board.choices
    spot = not setup.planner.omni and drive.phase == FOLLOW and error_rad > TURN_FIRST_RAD
    best, count = plan_period(setup.planner, distance_m, grid, believed, twist, leg, allowed, spot, prune, choices)
    command = command_of(setup.planner, believed, choices.candidates[best]) if best >= 0 else (0.0, 0.0, 0.0)
    away_m = math.hypot(believed[0] - drive.start_x_m, believed[1] - drive.start_y_m)
    if spot and stands(command[0], command[1], command[2]) and away_m < UNPARKING_M:
        best, count = plan_period(
            setup.unparking, distance_m, grid, believed, twist, leg, allowed, False, prune, choices
        )
        command = command_of(setup.planner, believed, choices.candidates[best]) if best >= 0 else (0.0, 0.0, 0.0)
    drive.best, drive.count = best, count
    return command


@compiled
def _has_no_room(setup: Setup, drive: Any, distance_m: FloatArray) -> bool:
    """Whether the footprint touches marks just before the target, wherever across the way it stands."""
    grid, robot = _grid_of(drive), setup.planner.robot
    heading = math.atan2(drive.target_y_m - drive.start_y_m, drive.target_x_m - drive.start_x_m)
    cos, sin = math.cos(heading), math.sin(heading)
    for aside_m in (0.0, 0.5 * NEAR_ENOUGH_M, -0.5 * NEAR_ENOUGH_M):
        x = drive.target_x_m - cos * ROOM_SHORT_M - sin * aside_m
        y = drive.target_y_m - sin * ROOM_SHORT_M + cos * aside_m
        if not touches(distance_m, grid, robot, x, y, cos, sin):
            return False
    return True


@compiled
def _seen_to_be_full(setup: Setup, board: Board, drive: Any) -> bool:
    """Whether the range finder itself has seen that there is no room at the target."""
    # What beams have marked is some of what is marked: the cheap question first.
    if not _has_no_room(setup, drive, board.window.distance_m):
        return False
    marks, seen = board.window.marks.reshape(-1), board.seen.reshape(-1)
    for i in range(marks.shape[0]):
        seen[i] = marks[i] == FROM_BEAM
    fill_distances(board.seen, drive.cell_m, board.seen_m)
    return _has_no_room(setup, drive, board.seen_m)


@compiled
def _follow(
    setup: Setup, board: Board, drive: Any, believed: Pose, twist: Twist, scan_m: FloatArray, prune: bool
) -> tuple[int, tuple[float, float, float]]:
    """Drive one period of a leg; return how the leg ended, or OPEN and the twist to command."""
    limits, still = setup.limits, (0.0, 0.0, 0.0)
    time_s = drive.periods * limits.tick_s
    going_back = drive.phase == GO_BACK
    if time_s >= (RETURN_S if going_back else limits.timeout_s):
        return HAS_TIMED_OUT, still
    _look(setup, board, drive, believed, scan_m)
    left_m, error_rad = _measure(drive, believed, time_s)
    command = _plan(setup, board, drive, believed, twist, error_rad, prune)
    stays = stands(command[0], command[1], command[2])
    moving_mps = math.hypot(twist[0], twist[1])
    tolerance_m = RETURN_BEYOND_M if going_back else limits.position_tolerance_m
    slow = moving_mps <= setup.planner.limits.acceleration_mps2 * limits.tick_s
    if left_m <= tolerance_m and slow and (stays or left_m <= 0.4 * tolerance_m or moving_mps <= STILL_MPS):
        return HAS_REACHED, still
    idle = stays and stands(twist[0], twist[1], twist[2])
    drive.idle_periods = drive.idle_periods + 1 if idle else 0
    if drive.idle_periods >= IDLE_PERIODS or time_s - drive.since_s >= limits.blocked_after_s:
        return HAS_REACHED if left_m <= NEAR_ENOUGH_M else IS_BLOCKED, still
    if not going_back and error_rad < FACING_RAD and _seen_to_be_full(setup, board, drive):
        return IS_BLOCKED, still
    return OPEN, command


@compiled
def _slower(setup: Setup, twist: Twist) -> tuple[float, float, float]:
    """Return a twist braked for one period, within the base's limits."""
    limits = setup.planner.limits
    speed = math.hypot(twist[0], twist[1])
    share = max(0.0, 1.0 - limits.acceleration_mps2 * limits.tick_s / max(speed, 1e-9))
    turn = max(0.0, abs(twist[2]) - limits.turn_acceleration_radps2 * limits.tick_s)
    return twist[0] * share, twist[1] * share, math.copysign(turn, twist[2])


@compiled
def next_command(
    setup: Setup, board: Board, drives: DriveState, believed: Pose, twist: Twist, scan_m: FloatArray, prune: bool
) -> tuple[float, float, float]:
    """Return the twist (forward_mps, left_mps, turn_radps) of the next control period; the phase says when all is done.

    Args:
        setup: The base and the map.
        board: Written.
        drives: The action's state [1], changed.
        believed: Where the robot believes to be.
        twist: How it moves now.
        scan_m: [180] what its range finder says now.
        prune: Whether candidates that cannot win may be left unfinished; the command is the same.
    """
    drive = drives[0]
    drive.best = NOTHING_PLANNED
    while drive.phase != DONE:
        if drive.phase == FOLLOW or drive.phase == GO_BACK:
            outcome, command = _follow(setup, board, drive, believed, twist, scan_m, prune)
            if outcome == OPEN:
                drive.periods += 1
                return command
            if drive.phase == FOLLOW:
                drive.outcome = outcome
            drive.phase = BRAKE if drive.phase == FOLLOW else STAND
            drive.periods, drive.best = 0, NOTHING_PLANNED
        elif drive.periods < BRAKE_PERIODS and not stands(twist[0], twist[1], twist[2]):
            drive.periods += 1
            return _slower(setup, twist)
        else:
            _after_braking(drive, believed)
    return 0.0, 0.0, 0.0


@compiled
def _after_braking(drive: Any, believed: Pose) -> None:
    """Go back to where the action began if it was blocked on its way, so that a bump leaves the robot in its cell."""
    away_m = math.hypot(believed[0] - drive.begin_x_m, believed[1] - drive.begin_y_m)
    if drive.phase == BRAKE and drive.outcome == IS_BLOCKED and away_m > RETURN_BEYOND_M:
        _begin_leg(drive, believed[0], believed[1], drive.begin_x_m, drive.begin_y_m, believed[2])
        drive.phase = GO_BACK
    else:
        drive.phase = DONE
