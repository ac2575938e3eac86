import numpy as np
import pytest
from furnished_room import NOISE_M, SENSOR, START, mapped, noisy, odometry_of, ranges_at, readings_of, way

from twonav_cli.geometry import FloatArray, Pose, compose, distance_m, wrap_angle
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.mapping.relocate import MapMatcher

PLACES = [Pose(-1.4, -0.6, 1.0), Pose(1.9, -1.5, 2.5), Pose(1.2, 1.1, -2.0), Pose(-0.9, 1.1, -0.4)]
OFF = [Pose(0.06, -0.05, 0.06), Pose(-0.1, 0.04, -0.1), Pose(0.0, 0.12, 0.15)]


@pytest.fixture(scope="module")
def known() -> tuple[OccupancyMap, FloatArray]:
    """Return a map made by the mapper, and the walls in it."""
    poses = way(110)
    mapper = mapped(readings_of(poses, odometry_of(poses)))
    return mapper.occupancy(), mapper.walls()


def errors(matcher: MapMatcher) -> tuple[list[float], list[float]]:
    """Return metres and radians that matches are off, at every place from every guess."""
    rng = np.random.default_rng(0)
    off_m, off_rad = [], []
    for place in PLACES:
        for off in OFF:
            found = matcher.match(noisy(ranges_at(place), rng), compose(place, off))
            assert found is not None
            off_m.append(distance_m(found, place))
            off_rad.append(abs(wrap_angle(found.theta_rad - place.theta_rad)))
    return off_m, off_rad


def test_a_robot_is_found_within_a_centimetre(known: tuple[OccupancyMap, FloatArray]) -> None:
    map_, walls = known
    off_m, off_rad = errors(MapMatcher(map_, SENSOR, walls))
    assert max(off_m) < 0.01
    assert max(off_rad) < 0.005
    assert NOISE_M < 0.01


def test_pixels_alone_find_it_less_well(known: tuple[OccupancyMap, FloatArray]) -> None:
    map_, walls = known
    off_m, off_rad = errors(MapMatcher(map_, SENSOR))
    assert max(off_m) < 0.04
    assert max(off_rad) < 0.02
    assert np.mean(off_m) > np.mean(errors(MapMatcher(map_, SENSOR, walls))[0])


def test_a_scan_of_another_place_is_not_matched(known: tuple[OccupancyMap, FloatArray]) -> None:
    matcher = MapMatcher(known[0], SENSOR, known[1])
    assert matcher.match(ranges_at(START), Pose(40.0, 3.0, 0.0)) is None
    assert matcher.match(0.37 * ranges_at(START), START) is None
    assert matcher.match(ranges_at(START), START) is not None


@pytest.mark.parametrize("value", [np.nan, np.inf, 0.0, 81.91])
def test_a_scan_of_nothing_is_not_matched(known: tuple[OccupancyMap, FloatArray], value: float) -> None:
    assert MapMatcher(known[0], SENSOR, known[1]).match(np.full(len(SENSOR.angles_rad), value), START) is None


def test_a_map_stays_as_it_is_and_a_scan_is_matched_the_same_twice(known: tuple[OccupancyMap, FloatArray]) -> None:
    map_, walls = known
    digest, points = map_.digest, walls.copy()
    matcher = MapMatcher(map_, SENSOR, walls)
    first = matcher.match(ranges_at(START), START)
    assert first is not None
    assert matcher.match(ranges_at(PLACES[0]), PLACES[0]) is not None
    assert matcher.match(ranges_at(START), START) == first
    assert (map_.digest, walls.tolist()) == (digest, points.tolist())


def test_a_map_with_no_wall_matches_nothing() -> None:
    empty = OccupancyMap.from_occupied(np.zeros((20, 30), dtype=np.bool_), GridFrame(0.0, 0.0, 0.05, 20, 30))
    assert MapMatcher(empty, SENSOR).match(ranges_at(START), START) is None
