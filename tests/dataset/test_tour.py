import numpy as np
import pytest

from twonav_cli.dataset.tour import WAYPOINT_M, tour
from twonav_cli.errors import TwonavError
from twonav_cli.grid import GridFrame

FRAME = GridFrame(0.0, 0.0, 0.05, 40, 60)
SPACES = np.arange(0.5, 3.0, 0.5)


@pytest.fixture
def hook() -> np.ndarray:
    """Two halls that meet at the top only."""
    floor = np.ones(FRAME.shape, dtype=bool)
    floor[8:, 28:32] = False
    return floor


def test_every_cell_is_visited_once_and_mostly_a_neighbour_comes_next(hook: np.ndarray) -> None:
    centres = np.array([(x, y) for x in SPACES if abs(x - 1.5) > 0.2 for y in (0.5, 1.0, 1.5)])
    order, ways = tour(hook, FRAME, centres)
    assert sorted(order.tolist()) == list(range(len(centres)))
    lengths = [np.hypot(*np.diff(way, axis=0).T).sum() for way in ways[1:]]
    assert np.median(lengths) == pytest.approx(0.5, abs=0.05)


def test_a_way_goes_round_a_wall_and_its_points_are_near_each_other_and_on_the_floor(hook: np.ndarray) -> None:
    order, ways = tour(hook, FRAME, np.array([[1.0, 0.3], [2.0, 0.3]]))
    assert order.tolist() == [0, 1]
    way = ways[1]
    steps = np.hypot(*np.diff(way, axis=0).T)
    assert steps.sum() > 2.5  # straight through the wall it would be 1 m
    assert steps.max() <= 2 * WAYPOINT_M
    assert all(hook[FRAME.cell_at(x, y)] for x, y in way)


def test_a_cell_that_cannot_be_reached_is_one_line() -> None:
    floor = np.ones(FRAME.shape, dtype=bool)
    floor[:, 30] = False
    with pytest.raises(TwonavError, match="cannot be reached"):
        tour(floor, FRAME, np.array([[1.0, 0.3], [2.0, 0.3]]))
