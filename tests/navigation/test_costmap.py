import math

import numpy as np
import pytest
from kinematic_body import KinematicBody

from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.navigation.costmap import FROM_BEAM, FROM_MAP, CostMap

FRAME = GridFrame(-1.0, -0.5, 0.05, 80, 80)
POSE = Pose(1.0, 1.5, 0.0)
FAR = np.full(180, 8.0)


def wall(x_m: float) -> np.ndarray:
    """Return a map [80, 80] with one wall of two pixels from top to bottom."""
    occupied = np.zeros(FRAME.shape, dtype=bool)
    col = FRAME.cell_at(x_m, 0.0).col
    occupied[:, col : col + 2] = True
    return occupied


def window_around(occupied: np.ndarray, pose: Pose = POSE) -> CostMap:
    window = CostMap(occupied, FRAME)
    window.begin(pose, (pose.x_m + 0.4, pose.y_m))
    return window


def mark_at(window: CostMap, x_m: float, y_m: float) -> int:
    rows, cols = window.marks.shape
    grid = window.grid
    fine = GridFrame(grid.x_min_m, grid.y_min_m, grid.resolution_m, rows, cols)
    return int(window.marks[fine.cell_at(x_m, y_m)])


@pytest.mark.parametrize("shift_m", [0.0, 0.013, -0.021])
def test_the_window_lies_on_the_pixels_of_the_map(shift_m):
    window = window_around(wall(1.4), Pose(1.0 + shift_m, 1.5 - shift_m, 0.3))
    offset = (window.frame.x_min_m - FRAME.x_min_m) / 0.05
    assert offset == pytest.approx(round(offset))
    assert mark_at(window, 1.401, 1.5) == FROM_MAP
    assert mark_at(window, 1.499, 1.5) == FROM_MAP
    assert mark_at(window, 1.399, 1.5) == 0
    assert mark_at(window, 1.501, 1.5) == 0


def test_a_hit_marks_what_the_map_does_not_have_and_far_hits_mark_nothing():
    window = window_around(np.zeros(FRAME.shape, dtype=bool))
    scan = FAR.copy()
    scan[90], scan[10] = 0.4, 0.6
    window.add_scan(POSE, scan, 0.5)
    assert mark_at(window, 1.43, 1.505) == FROM_BEAM
    assert int((window.marks > 0).sum()) == 1
    assert window.distance_m.min() == 0.0


def test_a_wall_that_is_believed_too_near_is_cleared_where_beams_pass_it():
    true = KinematicBody(wall(1.4), FRAME, POSE)
    believed = Pose(1.08, 1.5, 0.0)
    window = window_around(wall(1.4), believed)
    assert mark_at(window, 1.42, 1.5) == FROM_MAP
    window.add_scan(believed, true.scan(), 0.5)
    assert mark_at(window, 1.42, 1.5) == 0
    assert mark_at(window, 1.49, 1.5) == FROM_BEAM


def test_what_no_beam_hits_at_all_stays_on_the_map():
    window = window_around(wall(1.4))
    window.add_scan(POSE, FAR, 0.5)
    assert mark_at(window, 1.42, 1.5) == FROM_MAP


def test_with_a_true_pose_the_scan_takes_no_map_pixel_away():
    for theta in (0.0, 0.4, math.pi / 2):
        pose = Pose(1.1, 1.5, theta)
        window = window_around(wall(1.4), pose)
        before = window.marks > 0
        window.add_scan(pose, KinematicBody(wall(1.4), FRAME, pose).scan(), 0.5)
        assert ((window.marks > 0) == before).all()


def test_marks_deep_inside_the_standing_robot_are_taken_back():
    window = window_around(wall(0.9))
    assert mark_at(window, 0.95, 1.5) == 0
    assert mark_at(window, 0.95, 1.75) == FROM_MAP


def test_cost_falls_from_one_at_the_obstacle_to_nothing_at_the_inflation_distance():
    window = window_around(wall(1.4))
    window.add_scan(POSE, FAR, 0.5)
    cost = window.inflated(0.19, 0.35)
    assert cost.shape == window.frame.shape
    row = cost[window.frame.cell_at(1.0, 1.5).row]
    assert row[window.frame.cell_at(1.3, 1.5).col] == 1.0
    assert row[window.frame.cell_at(0.98, 1.5).col] == 0.0
    assert 0.0 < row[window.frame.cell_at(1.13, 1.5).col] < 1.0
