import numpy as np
import pytest

from twonav_cli.config import ROBOT_CIRCUMSCRIBED_M, ROBOT_FOOTPRINT_M
from twonav_cli.dataset import poses
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame

FRAME = GridFrame(-1.0, 2.0, 0.05, 60, 100)  # x -1 to 4, y 2 to 5
SEEDS = [Pose(0.0, 3.0, 0.0)]


@pytest.fixture
def two_rooms() -> np.ndarray:
    """A wall at x = 2 without a door: the right part cannot be reached."""
    occupied = np.zeros(FRAME.shape, dtype=bool)
    occupied[:, 60] = True
    return occupied


def test_cell_centres_lie_on_the_25_cm_grid_clear_of_obstacles_and_only_where_the_robot_can_go(
    two_rooms: np.ndarray,
) -> None:
    centres = poses.cell_centres(two_rooms, FRAME, SEEDS)
    steps = (centres - (-1.0, 2.0) - 0.125) / 0.25
    assert np.allclose(steps, np.round(steps))
    assert centres[:, 0].max() < 2.0 - ROBOT_CIRCUMSCRIBED_M
    assert centres[:, 0].min() > -1.0 + ROBOT_CIRCUMSCRIBED_M
    assert len(centres) == 10 * 10


def test_every_degree_is_taken_once_at_every_cell() -> None:
    taken, pairs = poses.grid_poses(np.array([[1.0, 2.0], [3.0, 4.0]]))
    assert len(taken) == 720
    assert len(np.unique(pairs, axis=0)) == 720
    assert taken[360 + 90] == pytest.approx((3.0, 4.0, np.pi / 2))


def test_a_degree_step_of_four_takes_a_quarter_and_shifts_from_cell_to_cell() -> None:
    _, pairs = poses.grid_poses(np.zeros((4, 2)), degree_step=4)
    assert len(pairs) == 360
    assert len(np.unique(pairs[:, 1])) == 360


def test_every_section_of_ten_degrees_has_five_two_three() -> None:
    labels = poses.paper_split(7, np.random.default_rng(1)).reshape(7, 36, 10)
    assert ((labels == poses.TRAIN).sum(axis=2) == 5).all()
    assert ((labels == poses.VALIDATION).sum(axis=2) == 2).all()
    assert (labels[0, 0] != labels[0, 1]).any()


def test_random_poses_touch_nothing_and_stay_in_the_reachable_room(two_rooms: np.ndarray) -> None:
    found = poses.random_poses(two_rooms, FRAME, SEEDS, 3000, np.random.default_rng(2))
    assert found.shape == (3000, 3)
    outline = np.array(ROBOT_FOOTPRINT_M)
    corners_x = found[:, :1] + np.cos(found[:, 2:]) * outline[:, 0] - np.sin(found[:, 2:]) * outline[:, 1]
    assert corners_x.max() <= 2.0 + 1e-9
    assert corners_x.min() >= -1.0 - 1e-9
    assert corners_x.max() > 1.95  # as near to the wall as the outline allows at that heading
    assert np.histogram(found[:, 2], 4, (-np.pi, np.pi))[0].min() > 500


def test_a_footprint_over_one_occupied_pixel_does_not_fit_at_the_heading_that_covers_it() -> None:
    occupied = np.zeros(FRAME.shape, dtype=bool)
    occupied[FRAME.cell_at(1.0 - 0.26, 3.0)] = True  # behind the axle, beyond the front's reach
    along = np.array([[1.0, 3.0, 0.0], [1.0, 3.0, np.pi]])
    assert poses.fits(occupied, FRAME, along).tolist() == [False, True]


def test_a_start_inside_a_wall_is_refused() -> None:
    with pytest.raises(TwonavError, match="fits at none"):
        poses.reachable_floor(np.ones(FRAME.shape, dtype=bool), FRAME, SEEDS)


def test_a_share_of_the_cells_is_held_out_and_at_least_one() -> None:
    assert poses.held_out_cells(200, 0.02, np.random.default_rng(1)).sum() == 4
    assert poses.held_out_cells(5, 0.02, np.random.default_rng(1)).sum() == 1


def test_a_pose_lies_in_a_cell_up_to_its_border() -> None:
    found = poses.in_cells(np.array([[1.12, 2.0, 0.0], [1.13, 2.0, 1.0], [0.9, 2.1, 3.0]]), np.array([[1.0, 2.0]]))
    assert found.tolist() == [True, False, True]
    assert not poses.in_cells(np.zeros((2, 3)), np.zeros((0, 2))).any()
