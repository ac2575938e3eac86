import math

import numpy as np
import pytest
from kinematic_body import KinematicBody

from twonav_cli.config import DriveConfig, OdometryNoise
from twonav_cli.events import DriveTrace
from twonav_cli.geometry import Pose, Twist
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.navigation.cell_driver import CellDriver
from twonav_cli.navigation.outcomes import BLOCKED, REACHED, TIMED_OUT

BASES = ["omni", "differential"]
OFFSETS = ((-1, 0), (1, 0), (0, -1), (0, 1))
CELLS = GridFrame(-1.0, -0.5, 0.4, 12, 14)
FRAME = GridFrame(-1.0, -0.5, 0.05, 96, 112)
OPEN = np.zeros(FRAME.shape, dtype=bool)


def wall_with_gap(gap_m: float) -> np.ndarray:
    """Return a map [96, 112] with a wall at x = 1.4 that is open around y = 1.9."""
    occupied = OPEN.copy()
    _, ys = FRAME.centres()
    occupied[np.abs(ys - 1.9) > gap_m / 2, 48:50] = True
    return occupied


def clutter(seed: int) -> np.ndarray:
    """Return a map [96, 112] with a border and a box in every fifth cell."""
    rng = np.random.default_rng(seed)
    occupied = OPEN.copy()
    occupied[:8], occupied[-8:], occupied[:, :8], occupied[:, -8:] = True, True, True, True
    for row, col in np.argwhere(rng.random(CELLS.shape) < 0.2):
        high, wide = rng.integers(1, 9, 2)
        down, along = rng.integers(0, 9 - high), rng.integers(0, 9 - wide)
        occupied[row * 8 + down : row * 8 + down + high, col * 8 + along : col * 8 + along + wide] = True
    return occupied


def off_m(pose: Pose, target: tuple[float, float]) -> float:
    return math.hypot(pose.x_m - target[0], pose.y_m - target[1])


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("heading_rad", [0.0, math.pi / 2, math.pi, -2.0])
@pytest.mark.parametrize("action", range(4))
def test_a_free_cell_is_reached_from_every_heading_and_the_robot_stands(base, heading_rad, action):
    start, target = Pose(1.2, 1.7, heading_rad), CELLS.centre_of(Cell(6 + OFFSETS[action][0], 5 + OFFSETS[action][1]))
    body = KinematicBody(OPEN, FRAME, start)
    outcome, believed = CellDriver(DriveConfig(), base, OPEN, FRAME).drive_to(body, start, target)
    assert outcome == REACHED
    assert believed == pytest.approx(body.pose)
    assert off_m(body.pose, target) <= DriveConfig().position_tolerance_m
    assert body.twist() == pytest.approx(Twist(0.0, 0.0, 0.0), abs=0.1)
    assert body.time_s <= (1.4 if base == "omni" else 2.6)


@pytest.mark.parametrize("base", BASES)
def test_a_robot_that_faces_its_way_needs_about_a_second_and_leaves_the_line_by_less_than_a_pixel(base):
    start = Pose(1.2, 1.7, 0.0)
    body = KinematicBody(OPEN, FRAME, start)
    CellDriver(DriveConfig(), base, OPEN, FRAME).drive_to(body, start, (1.6, 1.7))
    assert body.time_s <= 1.2
    assert max(abs(pose.y_m - 1.7) for pose in body.path) < 0.01


@pytest.mark.parametrize("base", BASES)
def test_a_doorway_of_a_metre_and_ten_is_passed(base):
    occupied = wall_with_gap(1.1)
    driver = CellDriver(DriveConfig(), base, occupied, FRAME)
    believed = Pose(0.6, 1.9, 0.0)
    body = KinematicBody(occupied, FRAME, believed)
    for x_m in (1.0, 1.4, 1.8, 2.2):
        outcome, believed = driver.drive_to(body, believed, (x_m, 1.9))
        assert outcome == REACHED
    assert body.pose.x_m > 2.1
    assert body.touched == 0


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("heading_rad", [0.0, 1.0])
@pytest.mark.parametrize("known", [True, False])
def test_a_wall_blocks_and_the_robot_stays_in_its_cell(base, heading_rad, known):
    occupied = wall_with_gap(0.0)
    start = Pose(1.0, 1.7, heading_rad)
    body = KinematicBody(occupied, FRAME, start)
    driver = CellDriver(DriveConfig(), base, occupied if known else OPEN, FRAME)
    outcome, believed = driver.drive_to(body, start, (1.4, 1.7))
    assert outcome == BLOCKED
    assert off_m(body.pose, start[:2]) < 0.1
    assert believed == pytest.approx(body.pose)
    assert body.touched == 0
    assert body.twist() == pytest.approx(Twist(0.0, 0.0, 0.0), abs=0.1)


@pytest.mark.parametrize("base", BASES)
def test_a_hundred_random_actions_in_clutter_touch_nothing_and_bumps_stay_in_their_cell(base):
    rng = np.random.default_rng(11)
    occupied = clutter(1)
    blocked = occupied.reshape(12, 8, 14, 8).any(axis=(1, 3))
    driver, outcomes = CellDriver(DriveConfig(), base, occupied, FRAME), []
    cell = Cell(8, 5)
    assert not blocked[cell]
    pose = Pose(*CELLS.centre_of(cell), 0.0)
    body = KinematicBody(occupied, FRAME, pose)
    assert not body.touches(pose)
    for _ in range(100):
        d_row, d_col = OFFSETS[rng.integers(4)]
        target = Cell(cell.row + d_row, cell.col + d_col)
        outcome, pose = driver.drive_to(body, pose, CELLS.centre_of(target))
        now = CELLS.cell_at(pose.x_m, pose.y_m)
        assert now == (target if outcome == REACHED else cell)
        outcomes.append((bool(blocked[target]), outcome))
        cell = now
    assert body.touched == 0
    assert (True, REACHED) not in outcomes
    assert (True, BLOCKED) in outcomes
    free = [outcome for was_blocked, outcome in outcomes if not was_blocked]
    assert free.count(REACHED) >= (0.95 if base == "omni" else 0.5) * len(free)


@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("direction_rad", np.arange(8) * math.pi / 4)
def test_a_wrong_believed_pose_is_no_obstacle_in_a_doorway(base, direction_rad):
    occupied = wall_with_gap(1.1)
    true = Pose(1.0, 1.9, 0.0)
    turn_rad = math.radians(2) if direction_rad > 3 else -math.radians(2)
    believed = Pose(1.0 + 0.06 * math.cos(direction_rad), 1.9 + 0.06 * math.sin(direction_rad), turn_rad)
    body = KinematicBody(occupied, FRAME, true)
    outcome, _ = CellDriver(DriveConfig(), base, occupied, FRAME).drive_to(body, believed, (1.4, 1.9))
    assert outcome == REACHED
    assert off_m(body.pose, (1.4, 1.9)) <= 0.06 + DriveConfig().position_tolerance_m + 0.02
    assert body.touched == 0


def test_the_believed_pose_follows_odometry_and_not_the_truth():
    start = Pose(1.2, 1.7, 0.0)
    body = KinematicBody(OPEN, FRAME, start, OdometryNoise(forward_per_m=0.2), seed=3)
    outcome, believed = CellDriver(DriveConfig(), "omni", OPEN, FRAME).drive_to(body, start, (1.6, 1.7))
    assert outcome == REACHED
    assert off_m(believed, (1.6, 1.7)) <= 0.05
    assert off_m(believed, body.pose[:2]) > 0.01


@pytest.mark.parametrize("base", BASES)
def test_tracing_shows_what_was_weighed_and_changes_nothing(base):
    occupied = wall_with_gap(1.1)
    paths, traces = [], []
    for trace in (False, True):
        body = KinematicBody(occupied, FRAME, Pose(1.0, 1.9, 0.7))
        driver = CellDriver(DriveConfig(), base, occupied, FRAME)
        driver.drive_to(body, body.pose, (1.4, 1.9), lambda *tick: traces.append(tick[2]), trace)
        paths.append(body.path)
    assert paths[0] == paths[1]
    shown = [trace for trace in traces if isinstance(trace, DriveTrace)]
    assert 1 <= len(shown) <= len(traces) / 4
    for trace in shown:
        assert 10 < len(trace.candidates) <= 60
        assert trace.candidates.shape == (len(trace.costs), DriveConfig().rollout_poses, 2)
        assert trace.costs[trace.best] == trace.costs.min()
        assert trace.cost_map.shape == trace.cost_frame.shape
        assert trace.cost_map.max() == 1.0


def test_an_action_that_takes_too_long_is_timed_out_and_the_robot_stands():
    start = Pose(1.2, 1.7, 0.0)
    body = KinematicBody(OPEN, FRAME, start)
    outcome, _ = CellDriver(DriveConfig(timeout_s=0.4), "omni", OPEN, FRAME).drive_to(body, start, (1.6, 1.7))
    assert outcome == TIMED_OUT
    assert body.twist() == pytest.approx(Twist(0.0, 0.0, 0.0), abs=0.1)
