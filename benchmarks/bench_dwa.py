"""Plans per second of the compiled dynamic window against plain NumPy doing the same plan, and against PythonRobotics.

    python benchmarks/bench_dwa.py [folder of a checkout of PythonRobotics]

The sides take turns in one process and are timed by its CPU time. PythonRobotics gets as many velocities and poses, and
the window's marks as its obstacles; it knows no cost map.
"""

from __future__ import annotations

import importlib.util
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import DriveConfig
from twonav_cli.geometry import Pose, Twist
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.costmap import CostMap
from twonav_cli.navigation.dwa import DynamicWindow, Leg, Planner
from twonav_cli.navigation.dwa_costs import DwaWeights
from twonav_cli.navigation.velocity_window import DIFFERENTIAL_SAMPLES

FRAME = GridFrame(0.0, 0.0, 0.05, 60, 60)
POSE = Pose(1.05, 1.5, 0.2)
LEG = Leg(1.0, 1.5, 1.4, 1.5, 0.0)
TWIST = Twist(0.3, 0.0, 0.2)
CONFIG = DriveConfig()
ROUNDS = 7


def doorway() -> CostMap:
    """Return the window in front of a doorway of 1.1 m."""
    occupied = np.zeros(FRAME.shape, dtype=np.bool_)
    occupied[:19, 28:30] = occupied[41:, 28:30] = True
    window = CostMap(occupied, FRAME)
    window.begin(POSE, (LEG.target_x_m, LEG.target_y_m))
    window.add_scan(POSE, np.full(180, 8.0), CONFIG.range_cut_m)
    return window


def numpy_costs(planner: Planner, window: CostMap, candidates: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the costs [N] of candidates [N, 3]: the same plan, every outline point [N, T, P] looked up."""
    limits, weights, rollout = planner.limits, DwaWeights(), planner.rollout
    vx, vy, turn = candidates.T
    speed = np.hypot(vx, vy)
    move_s = limits.tick_s + 0.5 * speed / limits.acceleration_mps2
    turn_s = limits.tick_s + 0.5 * np.abs(turn) / limits.turn_acceleration_radps2
    stop_s = np.maximum(move_s, turn_s)
    left_m = np.hypot(LEG.target_x_m - POSE.x_m, LEG.target_y_m - POSE.y_m)
    end_s = np.maximum(stop_s, np.minimum(rollout.horizon_s, left_m / np.maximum(speed, 1e-6)))
    near = max(2, 2 * rollout.poses // 3)
    first = stop_s[:, None] * np.arange(1, near + 1) / (near - 1)
    rest = np.arange(1, rollout.poses - near + 1) / (rollout.poses - near)
    times = np.hstack([first, first[:, -1:] + np.maximum(end_s[:, None] - first[:, -1:], 0.0) * rest])

    def moved(t: NDArray[np.float64], w: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        half = 0.5 * w * t if rollout.curved else np.zeros_like(t)
        chord, cos, sin = t * np.sinc(half / np.pi), np.cos(half), np.sin(half)
        by_x, by_y = (vx[:, None], vy[:, None]) if t.ndim == 2 else (vx, vy)
        return POSE.x_m + (cos * by_x - sin * by_y) * chord, POSE.y_m + (sin * by_x + cos * by_y) * chord

    def distance(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        grid, (rows, cols) = window.grid, window.distance_m.shape
        col = ((x - grid.x_min_m) / grid.resolution_m).astype(np.int64).clip(0, cols - 1)
        row = (rows - 1 - ((y - grid.y_min_m) / grid.resolution_m).astype(np.int64)).clip(0, rows - 1)
        return np.asarray(window.distance_m[row, col])

    x, y = moved(times, turn[:, None])
    theta = POSE.theta_rad + turn[:, None] * times
    cos, sin = np.cos(theta)[..., None], np.sin(theta)[..., None]
    px, py = np.concatenate(planner.robot.rings).T
    touching = (distance(x[..., None] + cos * px - sin * py, y[..., None] + sin * px + cos * py) == 0).any(axis=-1)
    cost = (rollout.inflation_m - distance(x, y)) / (rollout.inflation_m - planner.robot.inscribed_m)
    obstacle = np.where(touching.any(axis=1), 1.0, cost[:, :near].clip(0, 1).max(axis=1))
    obstacle[touching[:, :near].any(axis=1)] = np.inf
    stop_x, stop_y = moved(move_s, turn)
    heading = np.abs((POSE.theta_rad + turn * turn_s - LEG.heading_rad + np.pi) % (2 * np.pi) - np.pi)
    cost = weights.target * np.hypot(LEG.target_x_m - stop_x, LEG.target_y_m - stop_y) + weights.heading * heading
    cost += weights.path * np.abs(stop_y - LEG.start_y_m) + weights.speed * (1 - speed / limits.forward_mps).clip(0)
    return np.asarray(cost + weights.clearance * obstacle)


def seconds_each(work: Callable[[], object], times: int) -> float:
    """Return the CPU seconds of one call."""
    begin = time.process_time()
    for _ in range(times):
        work()
    return (time.process_time() - begin) / times


def python_robotics(folder: Path, window: CostMap) -> dict[str, Callable[[], Any]]:
    """Return what makes one plan with PythonRobotics, for its round robot and its rectangular one."""
    path = folder / "PathPlanning" / "DynamicWindowApproach" / "dynamic_window_approach.py"
    spec = importlib.util.spec_from_file_location("dynamic_window_approach", path)
    assert spec is not None
    assert spec.loader is not None
    theirs = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(theirs)
    rows, cols = np.nonzero(window.marks)
    grid, height = window.grid, window.marks.shape[0]
    xs, ys = grid.x_min_m + (cols + 0.5) * grid.resolution_m, grid.y_min_m + (height - rows - 0.5) * grid.resolution_m
    obstacles, goal = np.column_stack([xs, ys]), np.array([LEG.target_x_m, LEG.target_y_m])
    state = np.array([*POSE, TWIST.forward_mps, TWIST.turn_radps])

    def plan_of(shape: Any) -> Callable[[], Any]:
        config = theirs.Config()
        config.robot_type, config.robot_radius = shape, 0.315
        config.robot_width, config.robot_length = 0.38, 0.5
        config.max_speed, config.max_yaw_rate = CONFIG.max_forward_mps, CONFIG.max_turn_radps
        config.max_accel, config.max_delta_yaw_rate = CONFIG.acceleration_mps2, CONFIG.turn_acceleration_radps2
        speeds, turns = DIFFERENTIAL_SAMPLES
        config.v_resolution = 2 * config.max_accel * config.dt / (speeds - 0.5)
        config.yaw_rate_resolution = 2 * config.max_delta_yaw_rate * config.dt / (turns - 0.5)
        config.predict_time = CONFIG.rollout_poses * config.dt - 1.5 * config.dt
        return lambda: theirs.dwa_control(state.copy(), config, goal, obstacles)

    return {"round": plan_of(theirs.RobotType.circle), "rectangular": plan_of(theirs.RobotType.rectangle)}


def compare_with_python_robotics(folder: Path, window: CostMap) -> None:
    """Print plans per second of ours and theirs, and the ratio."""
    planner = DynamicWindow(CONFIG, "differential")
    for shape, plan in python_robotics(folder, window).items():
        ours, theirs = [], []
        for _ in range(ROUNDS):
            ours.append(seconds_each(lambda: planner.plan(window, POSE, TWIST, LEG), 2000))
            theirs.append(seconds_each(plan, 2))
        fast, slow = float(np.median(ours)), float(np.median(theirs))
        theirs_s = f"PythonRobotics, {shape} robot, {1 / slow:,.1f}"
        print(f"differential, {1 / fast:,.0f} plans/s; {theirs_s}; ratio {slow / fast:,.0f}")


def main() -> None:
    """Print plans per second of both, their ratio, and whether they chose the same."""
    window = doorway()
    for base in ("differential", "omni"):
        planner = DynamicWindow(CONFIG, base)
        plan = planner.plan(window, POSE, TWIST, LEG, whole=True)
        candidates = plan.candidates.copy()
        same = int(np.argmin(numpy_costs(planner.planner, window, candidates))) == plan.best
        ours, theirs = [], []
        for _ in range(ROUNDS):
            ours.append(seconds_each(lambda p=planner: p.plan(window, POSE, TWIST, LEG), 2000))
            theirs.append(seconds_each(lambda p=planner, c=candidates: numpy_costs(p.planner, window, c), 1))
        fast, slow = float(np.median(ours)), float(np.median(theirs))
        print(
            f"{base}: {len(candidates)} velocities x {CONFIG.rollout_poses} poses, {1 / fast:,.0f} plans/s; "
            f"NumPy {1 / slow:,.1f}; ratio {slow / fast:,.0f}; same choice: {same}"
        )
    if len(sys.argv) > 1:
        compare_with_python_robotics(Path(sys.argv[1]), window)


if __name__ == "__main__":
    main()
