from collections.abc import Iterator

import numpy as np
import pytest
from walls_seen import RULE, TRUE, Scene, by, corner, line, scene_of

from twonav_cli.geometry import FloatArray
from twonav_cli.mapping.cells import TileStore
from twonav_cli.mapping.look_around import CLIMBS, SEARCH_STEP_RAD, SEARCH_STEPS, Match, found_pose
from twonav_cli.mapping.scan_match import SURE_MATCH

LOOSE = np.diag([0.5**2, 0.5**2, 5.0**2])


def nook() -> Scene:
    """Return walls that look different at every heading."""
    return scene_of(
        [
            line((-30.0, 40.37), (30.37, 40.37)), line((30.37, 39.5), (30.37, -20.0)),
            line((-18.0, 10.0), (-22.0, 31.0)), line((8.0, -31.2), (27.0, -26.0)),
        ]
    )  # fmt: skip


def search(scene: Scene, guesses: list[FloatArray] | Iterator[FloatArray]) -> Match:
    return found_pose(scene.grid, scene.points, scene.normals, guesses, LOOSE, RULE)


def counted(guesses: list[FloatArray], taken: list[int]) -> Iterator[FloatArray]:
    for k, guess in enumerate(guesses):
        taken.append(k)
        yield guess


@pytest.mark.parametrize("turn_rad", [0.0, 0.25, -0.25, 0.45, -0.45])
def test_a_heading_that_is_far_off_is_found(turn_rad: float) -> None:
    match = search(nook(), [TRUE + by(0.8, -0.6, turn_rad)])
    assert match.share > 0.95
    assert match.pose == pytest.approx(TRUE, abs=0.03)
    assert abs(turn_rad) < SEARCH_STEP_RAD * SEARCH_STEPS


def test_a_later_guess_is_tried_where_the_first_does_not_fit() -> None:
    guesses = [TRUE + by(150.0, 0.0, 0.0), TRUE + by(0.0, 90.0, 1.0), TRUE + by(1.0, 1.0, 0.1)]
    taken: list[int] = []
    match = search(nook(), counted(guesses, taken))
    assert taken == [0, 1, 2]
    assert match.pose == pytest.approx(TRUE, abs=0.03)


def test_a_sure_match_ends_the_search() -> None:
    taken: list[int] = []
    match = search(nook(), counted([TRUE + by(0.5, 0.5, 0.01), TRUE, TRUE], taken))
    assert taken == [0]
    assert match.share >= SURE_MATCH


def test_the_guess_and_three_headings_apart_from_each_other_are_climbed_from(monkeypatch: pytest.MonkeyPatch) -> None:
    starts: list[FloatArray] = []

    def lost(*arguments: FloatArray) -> tuple[FloatArray, float, float, FloatArray]:
        starts.append(arguments[3])
        return arguments[3], -1.0, 0.0, LOOSE

    monkeypatch.setattr("twonav_cli.mapping.look_around.best_pose", lost)
    search(nook(), [TRUE + by(0.5, 0.0, 0.2)])
    assert starts[0] == pytest.approx(TRUE + by(0.5, 0.0, 0.2))
    headings = np.array([start[2] for start in starts[1:]])
    assert headings[0] == pytest.approx(TRUE[2], abs=SEARCH_STEP_RAD)  # the likeliest is the true one
    assert len(headings) == CLIMBS
    assert np.diff(np.sort(headings)).min() > 1.5 * SEARCH_STEP_RAD
    assert all(start[:2].tolist() == starts[0][:2].tolist() for start in starts)


def test_the_likeliest_of_matches_that_are_not_sure_is_kept() -> None:
    scene, rng = corner(), np.random.default_rng(0)
    new = rng.uniform(-25, 25, (len(scene.points) // 2, 2))
    half = Scene(scene.store, np.concatenate([scene.points, new]), np.concatenate([scene.normals, np.zeros_like(new)]))
    match = search(half, [TRUE + by(100.0, 0.0, 0.0), TRUE + by(0.8, -0.5, 0.02), TRUE + by(0.0, 100.0, 0.0)])
    assert 0.6 < match.share < SURE_MATCH
    assert match.pose == pytest.approx(TRUE, abs=0.2)


def test_where_nothing_fits_the_share_says_so() -> None:
    scene = nook()
    empty = TileStore(1).map_of(0)
    match = found_pose(empty, scene.points, scene.normals, [TRUE, TRUE + 1.0], LOOSE, RULE)
    assert match.share == 0.0
    assert match.pose.tolist() == TRUE.tolist()


def test_a_scan_without_a_beam_stays_at_the_first_guess() -> None:
    none = np.zeros((0, 2))
    match = found_pose(nook().grid, none, none, [TRUE, TRUE + 1.0], LOOSE, RULE)
    assert match.pose.tolist() == TRUE.tolist()
    assert match.share == 0.0
