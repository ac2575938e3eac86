import numpy as np
import pytest
from whole_map import WholeMap

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.carve import carve_scan
from twonav_cli.mapping.cell_units import CellUnits
from twonav_cli.mapping.cells import TileStore
from twonav_cli.mapping.occupancy import FREE, OCCUPIED, UNKNOWN
from twonav_cli.mapping.tile_picture import drawn, wall_points

RESOLUTION_M = 0.05
UNITS = CellUnits(RESOLUTION_M, (0.02, -0.01))
BEGIN, HIT = Pose(-1.2, -0.44, 0.0), (-0.94, -0.31)
"""Where a beam begins and ends, metres: both coordinates below the corner."""


def seen_once() -> TileStore:
    """Return the map of one beam that goes to the right and up."""
    store = TileStore(2)
    end = (np.array(HIT) - BEGIN[:2]) / RESOLUTION_M
    carve_scan(store, 1, UNITS.of_pose(BEGIN), end[None])
    return store


def test_the_centres_of_the_picture_are_where_the_beam_was() -> None:
    map_ = drawn(seen_once(), 1, UNITS, None)
    xs_m, ys_m = map_.frame.centres()
    rows, cols = np.nonzero(map_.occupied)
    assert len(rows) == 1
    assert (xs_m[cols[0]], ys_m[rows[0]]) == pytest.approx(HIT, abs=RESOLUTION_M / 2)
    began = map_.frame.cell_at(BEGIN.x_m, BEGIN.y_m)
    assert map_.free[began]
    assert (xs_m[began.col], ys_m[began.row]) == pytest.approx(BEGIN[:2], abs=RESOLUTION_M / 2)
    assert map_.pixels[0, 0] == UNKNOWN


def test_row_0_is_the_top_and_the_frame_ends_where_nothing_was_seen() -> None:
    map_ = drawn(seen_once(), 1, UNITS, None)
    assert map_.frame.shape == (4, 6)
    # Cells of the beam: columns -25 to -20, rows -9 to -6 from the corner.
    assert (map_.frame.x_min_m, map_.frame.y_min_m) == pytest.approx((0.02 - 25 * 0.05, -0.01 - 9 * 0.05))
    assert map_.pixels[0, 5] == OCCUPIED
    assert map_.pixels[3, 0] == FREE
    for row in range(4):
        assert (map_.pixels[row] != UNKNOWN).any()
    for col in range(6):
        assert (map_.pixels[:, col] != UNKNOWN).any()


def test_the_frame_asked_for_shows_the_same_cells() -> None:
    store = seen_once()
    own = drawn(store, 1, UNITS, None)
    frame = GridFrame(own.frame.x_min_m - 0.15, own.frame.y_min_m - 0.10, RESOLUTION_M, 11, 14)
    wide = drawn(store, 1, UNITS, frame)
    assert wide.frame == frame
    assert np.array_equal(wide.pixels[5:9, 3:9], own.pixels)
    assert (wide.pixels != UNKNOWN).sum() == (own.pixels != UNKNOWN).sum()


def test_a_frame_may_cut_the_map_or_miss_it() -> None:
    store = seen_once()
    own = drawn(store, 1, UNITS, None)
    frame = GridFrame(own.frame.x_min_m + 0.10, own.frame.y_min_m + 0.05, RESOLUTION_M, 2, 3)
    assert np.array_equal(drawn(store, 1, UNITS, frame).pixels, own.pixels[1:3, 2:5])
    for x_min_m, y_min_m in ((500.02, -0.01), (-499.98, -0.01), (0.02, 499.99), (0.02, -500.01)):
        far = drawn(store, 1, UNITS, GridFrame(x_min_m, y_min_m, RESOLUTION_M, 3, 4))
        assert (far.pixels == UNKNOWN).all()
        assert far.pixels.shape == (3, 4)


@pytest.mark.parametrize(
    "frame",
    [
        GridFrame(0.03, -0.01, RESOLUTION_M, 10, 10),
        GridFrame(0.02, 0.0, RESOLUTION_M, 10, 10),
        GridFrame(0.02, -0.01, 0.1, 10, 10),
    ],
)
def test_a_frame_that_does_not_lie_on_the_cells_is_refused(frame: GridFrame) -> None:
    with pytest.raises(TwonavError, match="do not lie on the frame") as caught:
        drawn(seen_once(), 1, UNITS, frame)
    assert "\n" not in str(caught.value)


def test_a_map_without_a_beam_is_one_unknown_pixel() -> None:
    map_ = drawn(seen_once(), 0, UNITS, None)
    assert map_.pixels.tolist() == [[UNKNOWN]]
    assert wall_points(seen_once(), 0, UNITS).shape == (0, 2)


def test_pixels_are_the_sign_of_the_log_odds_and_walls_the_means_of_the_hits() -> None:
    store, rng = TileStore(1), np.random.default_rng(0)
    for _ in range(6):
        angles = np.linspace(-3, 3, 200)
        ranges = rng.choice([20.0, 45.0], 200)
        sensor = np.array([*rng.uniform(-4, 4, 2), rng.uniform(-3, 3)])
        carve_scan(store, 0, sensor, np.stack([ranges * np.cos(angles), ranges * np.sin(angles)], axis=1))
    map_, cells = drawn(store, 0, UNITS, None), WholeMap(store)
    walls = {(row, col) for row, col in cells.wall_cells()}
    seen = set()
    for x_m, y_m in wall_points(store, 0, UNITS).tolist():
        x, y, _ = UNITS.of_pose(Pose(x_m, y_m, 0.0))
        cell = int(np.floor(y)), int(np.floor(x))
        seen.add(cell)
        assert cells.mean(*cell) == pytest.approx((x, y), abs=1e-6)
        assert map_.occupied[map_.frame.cell_at(x_m, y_m)]
    assert seen == walls
    assert map_.occupied.sum() == len(walls) > 50
    assert map_.free.sum() == (cells.visits > 0).sum() - len(walls)


def test_a_cell_of_the_picture_is_the_cell_of_the_store() -> None:
    store = TileStore(1)
    for x, y in ((-33.0, 17.0), (40.0, -65.0), (0.0, 0.0), (31.0, 32.0)):
        carve_scan(store, 0, np.array([x + 0.5, y + 0.5, 0.0]), np.zeros((1, 2)))
    map_ = drawn(store, 0, UNITS, None)
    for x, y in ((-33.0, 17.0), (40.0, -65.0), (0.0, 0.0), (31.0, 32.0)):
        centre = UNITS.pose(np.array([x + 0.5, y + 0.5, 0.0]))
        cell = map_.frame.cell_at(centre.x_m, centre.y_m)
        assert map_.occupied[cell]
        assert map_.frame.centre_of(Cell(*cell)) == pytest.approx(centre[:2])
    assert map_.occupied.sum() == 4
    assert map_.pixels.shape == (98, 74)
