"""How far a survey's map and way are from the simulator's truth."""

from __future__ import annotations

import math

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.map_errors import connected_floor, map_agreement, maze_differences, paired, pose_errors
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN, OccupancyMap
from twonav_cli.mapping.scan import StampedPose

FRAME = GridFrame(0.0, 0.0, 0.05, 32, 32)
START = Pose(0.5, 0.5, 0.0)


def walled(block: bool = True) -> OccupancyMap:
    """Return a room of 1.3 m with a block of 0.4 m in its upper right, walls 3 pixels thick, all of it known."""
    pixels = np.full(FRAME.shape, OCCUPIED, dtype=np.uint8)
    pixels[3:29, 3:29] = FREE
    if block:
        pixels[8:16, 16:24] = OCCUPIED
    return OccupancyMap(FRAME, pixels)


def as_seen(truth: OccupancyMap, right: int = 0) -> OccupancyMap:
    """Return what a robot sees of it: surfaces of one pixel, nothing behind, everything moved some pixels."""
    free = truth.free
    grown = np.zeros_like(free)
    for down in (-1, 0, 1):
        for aside in (-1, 0, 1):
            grown |= np.roll(free, (down, aside), axis=(0, 1))
    pixels = np.where(free, FREE, np.where(grown, OCCUPIED, UNKNOWN)).astype(np.uint8)
    return OccupancyMap(FRAME, np.roll(pixels, right, axis=1))


def test_the_errors_of_poses_are_distances_and_angles_in_the_map_frame() -> None:
    truth = [StampedPose(0.1 * k, Pose(float(k), 0.0, math.pi - 0.01)) for k in range(4)]
    believed = [
        StampedPose(0.1, Pose(1.3, 0.4, math.pi - 0.01)),
        StampedPose(0.1 * 3, Pose(3.0, -0.1, -math.pi + 0.03)),  # over the border of the angles
    ]
    found = pose_errors(*paired(believed, truth))
    assert found["pose_mean_m"] == pytest.approx(0.3)
    assert found["pose_worst_m"] == pytest.approx(0.5)
    assert found["pose_mean_deg"] == pytest.approx(math.degrees(0.02))


def test_a_pose_without_a_truth_is_not_compared_with_another_one() -> None:
    with pytest.raises(TwonavError, match=r"no true pose .* 0\.500 s"):
        paired([StampedPose(0.5, START)], [StampedPose(0.4, START)])


def test_surfaces_alone_agree_fully_and_what_is_inside_is_counted_by_itself() -> None:
    found = map_agreement(as_seen(walled()), walled(), START)
    assert found["agreeing"] == 1.0
    inside_of_walls, inside_of_block = 32 * 32 - 28 * 28, 6 * 6
    assert found["hidden_cells"] == inside_of_walls + inside_of_block


def test_one_pixel_aside_still_agrees_but_two_do_not() -> None:
    assert map_agreement(as_seen(walled(), right=1), walled(), START)["walls_found"] == 1.0
    two = map_agreement(as_seen(walled(), right=2), walled(), START)
    assert two["walls_found"] < 0.9
    assert two["walls_right"] < 1.0  # the left surface lies two pixels inside the room


def test_what_one_map_alone_holds_counts_against_it() -> None:
    overlooked = map_agreement(as_seen(walled(block=False)), walled(), START)
    assert overlooked["walls_found"] < 0.85
    assert overlooked["walls_right"] == 1.0
    assert overlooked["floor_right"] < 0.98  # floor where the block stands
    phantom = map_agreement(as_seen(walled()), walled(block=False), START)
    assert phantom["walls_found"] == 1.0
    assert phantom["walls_right"] < 0.85
    assert 0.9 < phantom["agreeing"] < 1.0


def test_floor_that_was_not_seen_counts_as_not_found() -> None:
    ours = as_seen(walled())
    pixels = ours.pixels.copy()
    pixels[20:26, 6:26] = UNKNOWN
    found = map_agreement(OccupancyMap(FRAME, pixels), walled(), START)
    missing = 4 * 18  # of 6 x 20 cells those that have no seen floor within one cell
    assert found["floor_found"] == pytest.approx(1 - missing / int(walled().free.sum()))


def test_closed_off_floor_is_not_asked_for() -> None:
    truth = walled()
    pixels = truth.pixels.copy()
    pixels[12, 20] = FREE
    truth = OccupancyMap(FRAME, pixels)
    assert map_agreement(as_seen(walled()), truth, START)["agreeing"] == 1.0
    assert not connected_floor(truth, START)[12, 20]


def test_a_start_in_a_wall_and_maps_of_two_frames_are_refused() -> None:
    with pytest.raises(TwonavError, match="not on free floor"):
        map_agreement(walled(), walled(), Pose(0.01, 0.01, 0.0))
    moved = OccupancyMap(GridFrame(1.0, 0.0, 0.05, 32, 32), walled().pixels)
    with pytest.raises(TwonavError, match="same frame"):
        map_agreement(walled(), moved, START)


def test_cells_of_the_maze_that_differ_are_named() -> None:
    truth = OccupancyMap(FRAME, np.full(FRAME.shape, FREE, dtype=np.uint8))
    pixels = truth.pixels.copy()
    pixels[0, 8] = UNKNOWN  # row 0, column 1 of the maze
    pixels[31, 31] = OCCUPIED  # row 3, column 3
    ours = OccupancyMap(FRAME, pixels)
    assert maze_differences(ours, truth, START) == {"blocked_by_us": [[0, 1], [3, 3]], "freed_by_us": []}
    assert maze_differences(truth, ours, START) == {"blocked_by_us": [], "freed_by_us": [[0, 1], [3, 3]]}
    assert maze_differences(ours, ours, START) == {"blocked_by_us": [], "freed_by_us": []}
