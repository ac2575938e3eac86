"""One action becomes motion: from the believed pose to the centre of the neighbouring cell (§3.1.3).

Within an action the pose is believed by odometry only. A control period: look, update the cost map, plan, drive.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import DriveConfig
from twonav_cli.events import DriveTrace
from twonav_cli.geometry import Pose, Twist, compose, wrap_angle
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.costmap import FROM_BEAM, CostMap
from twonav_cli.navigation.distance import fill_distances
from twonav_cli.navigation.dwa import DynamicWindow, Leg, Plan
from twonav_cli.navigation.dwa_costs import DwaWeights
from twonav_cli.navigation.footprint import touches
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

IDLE_TICKS = 2
"""Periods in a row in which standing still was the best choice, after which an action is blocked (ours)."""

TRACE_EVERY = 10
"""Periods from one trace of what the controller weighed to the next (ours)."""

RETURN_S = 1.2
"""Time a blocked robot has to go back to where it started (ours)."""

RETURN_BEYOND_M = 0.02
"""A blocked robot nearer than this to where it started stays (ours)."""

BRAKE_TICKS = 10
"""Periods after which braking is given up; a body that obeys needs four (ours)."""

TRACED_CANDIDATES = 60
"""Candidates of a period that are recorded, evenly taken (ours)."""

UNPARKING = DwaWeights(target=0.2, heading=0.3, clearance=0.3, path=0.1)
"""Weights of a differential base that has no room to turn on the spot: away from the wall, and round (ours)."""

UNPARKING_M = 0.12
"""How far from where it started the robot may look for room to turn: it must stay in its cell (ours)."""

FloatArray = NDArray[np.float64]
OnTick = Callable[[Pose, FloatArray, DriveTrace | None], None]


class Body(Protocol):
    """What is driven: a simulated robot, or a point in a test."""

    def drive(self, twist: Twist, duration_s: float) -> None:
        """Command a twist for some time."""

    def odometry(self) -> Pose:
        """Return the motion since the last call, in the frame of then, as the wheels report it."""

    def scan(self) -> FloatArray:
        """Return ranges [180] from the right (-90 degrees) to the left (+90), in metres."""

    def twist(self) -> Twist:
        """Return how it moves now."""


@dataclass
class _Progress:
    """How near the target and the heading the robot has come, and when it last got on."""

    left_m: float
    error_rad: float
    since_s: float = 0.0
    idle_ticks: int = 0

    def update(self, left_m: float, error_rad: float, time_s: float) -> None:
        """Note where the robot is now."""
        if left_m < self.left_m - PROGRESS_M or error_rad < self.error_rad - PROGRESS_RAD:
            self.since_s = time_s
        self.left_m, self.error_rad = min(self.left_m, left_m), min(self.error_rad, error_rad)


@dataclass
class _Drive:
    """What one call of `drive_to` carries from period to period."""

    body: Body
    believed: Pose
    on_tick: OnTick | None
    trace: bool
    due: bool = False
    """Whether this period is traced: tracing weighs every candidate to its end, which costs four times as much."""
    allowed_overlap: int | None = None
    """Fewest outline points on marks so far; None before the first period."""


def _stands(twist: Twist) -> bool:
    moving_mps = math.hypot(twist.forward_mps, twist.left_mps)
    return moving_mps <= STILL_MPS and abs(twist.turn_radps) <= STILL_RADPS


class CellDriver:
    """Drives single actions on one map with one base ("omni" or "differential")."""

    def __init__(self, config: DriveConfig, base: str, occupied: NDArray[np.bool_], map_frame: GridFrame) -> None:
        self._config = config
        self._window = CostMap(occupied, map_frame)
        self._planner = DynamicWindow(config, base)
        self._unparking = DynamicWindow(config, base, UNPARKING)
        self._omni = base == "omni"
        self._seen_m = np.zeros_like(self._window.distance_m)

    def drive_to(
        self,
        body: Body,
        believed: Pose,
        target_xy: tuple[float, float],
        on_tick: OnTick | None = None,
        trace: bool = False,
    ) -> tuple[str, Pose]:
        """Drive to a neighbouring cell's centre and stand still there.

        A blocked robot goes back to where it started, so a bump leaves it in its cell.

        Args:
            body: What is driven; motion it has not reported by odometry yet is forgotten.
            believed: Where the robot believes to be now.
            target_xy: Where it is to go, map frame, metres.
            on_tick: Called in every control period before driving: believed pose, scan [180], trace.
            trace: Whether to hand `on_tick` what the controller weighed; it decides the same without.

        Returns:
            "reached", "blocked" or "timed-out", and the believed pose at the end.
        """
        body.odometry()
        drive = _Drive(body, believed, on_tick, trace)
        self._window.begin(believed, target_xy)
        heading = math.atan2(target_xy[1] - believed.y_m, target_xy[0] - believed.x_m)
        leg = Leg(believed.x_m, believed.y_m, *target_xy, heading)
        outcome = self._follow(drive, leg, self._config.timeout_s, going_back=False)
        self._brake(drive)
        away_m = math.hypot(drive.believed.x_m - believed.x_m, drive.believed.y_m - believed.y_m)
        if outcome == BLOCKED and away_m > RETURN_BEYOND_M:
            keep_rad = drive.believed.theta_rad
            back = Leg(drive.believed.x_m, drive.believed.y_m, believed.x_m, believed.y_m, keep_rad)
            self._follow(drive, back, RETURN_S, going_back=True)
            self._brake(drive)
        return outcome, drive.believed

    def _follow(self, drive: _Drive, leg: Leg, limit_s: float, going_back: bool) -> str:
        """Drive one leg until it is reached, blocked or out of time; the robot may still move then."""
        config = self._config
        tolerance_m = RETURN_BEYOND_M if going_back else config.position_tolerance_m
        progress = _Progress(math.inf, math.inf)
        tick = 0
        while tick * config.tick_s < limit_s:
            time_s = tick * config.tick_s
            drive.due = drive.trace and tick % TRACE_EVERY == 0
            scan = self._look(drive)
            left_m = self._left_m(drive.believed, leg)
            leg = leg if going_back else self._aimed(drive.believed, leg, left_m)
            error_rad = abs(wrap_angle(leg.heading_rad - drive.believed.theta_rad))
            progress.update(left_m, error_rad, time_s)
            twist = drive.body.twist()
            plan = self._plan(drive, leg, twist, error_rad, going_back)
            stays = _stands(plan.twist)
            moving_mps = math.hypot(twist.forward_mps, twist.left_mps)
            arrived = left_m <= tolerance_m and moving_mps <= config.acceleration_mps2 * config.tick_s
            if arrived and (stays or left_m <= 0.4 * tolerance_m or moving_mps <= STILL_MPS):
                return REACHED
            progress.idle_ticks = progress.idle_ticks + 1 if stays and _stands(twist) else 0
            if progress.idle_ticks >= IDLE_TICKS or time_s - progress.since_s >= config.blocked_after_s:
                return REACHED if left_m <= NEAR_ENOUGH_M else BLOCKED
            if not going_back and error_rad < FACING_RAD and self._seen_at(leg):
                return BLOCKED
            self._tick(drive, plan.twist, scan, plan)
            tick += 1
        return TIMED_OUT

    def _look(self, drive: _Drive) -> FloatArray:
        """Scan [180], update the cost map, and note how far the robot seems to stand in something."""
        scan = drive.body.scan()
        self._window.add_scan(drive.believed, scan, self._config.range_cut_m)
        overlap = self._planner.overlap_at(self._window, drive.believed)
        before = drive.allowed_overlap
        # Once free or freer, never deeper again: a creeping robot would otherwise raise its own allowance.
        drive.allowed_overlap = overlap if not before else min(before, overlap)
        if overlap > 0:
            drive.allowed_overlap = max(drive.allowed_overlap, 1)
        return scan

    def _left_m(self, believed: Pose, leg: Leg) -> float:
        return math.hypot(leg.target_x_m - believed.x_m, leg.target_y_m - believed.y_m)

    def _aimed(self, believed: Pose, leg: Leg, left_m: float) -> Leg:
        """Return the leg with the heading towards the target, as long as that means something."""
        if left_m < AIM_M:
            return leg
        heading = math.atan2(leg.target_y_m - believed.y_m, leg.target_x_m - believed.x_m)
        return leg._replace(heading_rad=heading)

    def _plan(self, drive: _Drive, leg: Leg, twist: Twist, error_rad: float, going_back: bool) -> Plan:
        """Plan one period; a differential base that cannot turn on the spot may try arcs."""
        allowed = drive.allowed_overlap or 0
        spot = not self._omni and not going_back and error_rad > TURN_FIRST_RAD
        plan = self._planner.plan(self._window, drive.believed, twist, leg, allowed, spot, drive.due)
        away_m = math.hypot(drive.believed.x_m - leg.start_x_m, drive.believed.y_m - leg.start_y_m)
        if spot and _stands(plan.twist) and away_m < UNPARKING_M:
            plan = self._unparking.plan(self._window, drive.believed, twist, leg, allowed, False, drive.due)
        return plan

    def _seen_at(self, leg: Leg) -> bool:
        """Whether the range finder itself has seen that there is no room at the target."""
        window = self._window
        seen = (window.marks == FROM_BEAM).view(np.uint8)
        if not seen.any():
            return False
        fill_distances(seen, window.grid.resolution_m, self._seen_m)
        heading = math.atan2(leg.target_y_m - leg.start_y_m, leg.target_x_m - leg.start_x_m)
        cos, sin = math.cos(heading), math.sin(heading)
        for aside_m in (0.0, 0.5 * NEAR_ENOUGH_M, -0.5 * NEAR_ENOUGH_M):
            x = leg.target_x_m - cos * ROOM_SHORT_M - sin * aside_m
            y = leg.target_y_m - sin * ROOM_SHORT_M + cos * aside_m
            if not touches(self._seen_m, window.grid, self._planner.robot, x, y, cos, sin):
                return False
        return True

    def _brake(self, drive: _Drive) -> None:
        """Bring the body to a stand within its limits."""
        limits = self._planner.limits
        slower_mps = limits.acceleration_mps2 * limits.tick_s
        slower_radps = limits.turn_acceleration_radps2 * limits.tick_s
        for _ in range(BRAKE_TICKS):
            twist = drive.body.twist()
            speed = math.hypot(twist.forward_mps, twist.left_mps)
            if _stands(twist):
                break
            share = max(0.0, 1.0 - slower_mps / max(speed, 1e-9))
            turn = math.copysign(max(0.0, abs(twist.turn_radps) - slower_radps), twist.turn_radps)
            command = Twist(twist.forward_mps * share, twist.left_mps * share, turn)
            self._tick(drive, command, drive.body.scan(), None)

    def _tick(self, drive: _Drive, twist: Twist, scan: FloatArray, plan: Plan | None) -> None:
        """Tell who listens, drive one period, and move the believed pose by odometry."""
        if drive.on_tick is not None:
            trace = self._traced(drive.believed, plan) if drive.due and plan is not None else None
            drive.on_tick(drive.believed, scan, trace)
        drive.body.drive(twist, self._config.tick_s)
        drive.believed = compose(drive.believed, drive.body.odometry())

    def _traced(self, believed: Pose, plan: Plan) -> DriveTrace:
        """Return what the controller weighed in one period, at most TRACED_CANDIDATES of it."""
        stride = -(-len(plan.candidates) // TRACED_CANDIDATES)
        kept = list(range(0, len(plan.candidates), stride))
        if plan.best >= 0:
            kept[plan.best // stride] = plan.best
        return DriveTrace(
            candidates=self._planner.rolled_out(believed, plan.candidates[kept]),
            costs=plan.costs[kept].astype(np.float32),
            best=plan.best // stride if plan.best >= 0 else -1,
            cost_map=self._window.inflated(self._planner.robot.inscribed_m, self._config.inflation_m),
            cost_frame=self._window.frame,
        )
