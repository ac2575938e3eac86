"""The belief filter on made-up looks: it follows, it is not thrown off, and it finds a robot that was carried off."""

from __future__ import annotations

import math

import numpy as np
import pytest
from made_up_looks import Drive, MadeUpCamera, belief_at, drive, random_pose, sharp

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.geometry import Pose, compose, distance_m, wrap_angles
from twonav_cli.grid import GridFrame
from twonav_cli.localizer.belief_filter import (
    BeliefFilter,
    FilterConfig,
    FreeFloor,
    correct,
    look_likelihood,
    predict,
)
from twonav_cli.localizer.errors_report import pose_errors

CONFIG = FilterConfig()
SILENT = OdometryNoise(0.0, 0.0, 0.0, 0.0, 0.0)
AHEAD = Pose(0.2, 0.0, 0.0)
START = Pose(2.0, 4.0, 0.0)


def new_filter(seed: int = 0, config: FilterConfig = CONFIG, floor: FreeFloor | None = None) -> BeliefFilter:
    return BeliefFilter(config, OdometryNoise(), np.random.default_rng(seed), floor)


def follow(driven: Drive, beliefs: list[Belief], seed: int = 0, config: FilterConfig = CONFIG) -> np.ndarray:
    """Return the filter's poses [N, 3]."""
    following, poses = new_filter(seed, config), []
    for motion, belief in zip(driven.motions, beliefs, strict=True):
        following.predict(motion)
        poses.append(following.correct(belief).pose)
    return np.array(poses)


def straight(frames: int, start: Pose = START) -> list[Pose]:
    """Return poses on a straight way, 0.2 m apart."""
    poses = [start]
    while len(poses) < frames:
        poses.append(compose(poses[-1], AHEAD))
    return poses


def tracked(poses: list[Pose], seed: int = 0) -> BeliefFilter:
    """Return a filter that has seen every pose of a way, the motion to the next one predicted."""
    following = new_filter(seed)
    for pose in poses:
        following.correct(sharp(pose))
        following.predict(AHEAD)
    return following


# Eq. 4


def test_without_noise_every_particle_makes_the_motion_in_its_own_direction() -> None:
    particles = np.array([[1.0, 2.0, 0.0], [1.0, 2.0, math.pi / 2], [0.0, 0.0, 3.0]])
    motion = Pose(0.4, 0.1, 0.5)
    moved = predict(particles, motion, SILENT, np.random.default_rng(0))
    for before, after in zip(particles.tolist(), moved, strict=True):
        assert after == pytest.approx(np.array(compose(Pose(*before), motion)))


def test_headings_stay_wrapped() -> None:
    moved = predict(np.array([[0.0, 0.0, 3.0]]), Pose(0.0, 0.0, 0.5), SILENT, np.random.default_rng(0))
    assert moved[0, 2] == pytest.approx(3.5 - 2 * math.pi)


@pytest.mark.parametrize(
    ("term", "motion", "deviation"),
    [
        ("forward_per_m", Pose(0.25, 0.0, 0.0), (0.05, 0.0, 0.0)),
        ("forward_per_m", Pose(0.0, 0.25, 0.0), (0.0, 0.05, 0.0)),
        ("sideways_per_m", Pose(0.25, 0.0, 0.0), (0.0, 0.05, 0.0)),
        ("turn_per_rad", Pose(0.0, 0.0, -0.25), (0.0, 0.0, 0.05)),
        ("turn_per_m", Pose(0.25, 0.0, 0.0), (0.0, 0.0125 * 0.5, 0.05)),
        ("shift_per_rad", Pose(0.0, 0.0, 0.25), (0.05, 0.05, 0.0)),
    ],
)
def test_the_spread_grows_as_each_term_of_the_odometrys_noise_says(
    term: str, motion: Pose, deviation: tuple[float, float, float]
) -> None:
    noise = OdometryNoise(**{**vars(SILENT), term: 0.1})
    moved = predict(np.zeros((20_000, 3)), motion, noise, np.random.default_rng(1))
    assert moved.std(axis=0) == pytest.approx(deviation, rel=0.03, abs=1e-3)
    assert moved.mean(axis=0) == pytest.approx(motion, abs=2e-3)


def test_four_short_motions_spread_as_far_as_a_long_one() -> None:
    noise = OdometryNoise(turn_per_m=0.0)
    short, rng = np.zeros((20_000, 3)), np.random.default_rng(2)
    for _ in range(4):
        short = predict(short, Pose(0.1, 0.0, 0.0), noise, rng)
    long = predict(np.zeros((20_000, 3)), Pose(0.4, 0.0, 0.0), noise, rng)
    assert short[:, :2].std(axis=0) == pytest.approx(long[:, :2].std(axis=0), rel=0.04)


def test_a_robot_that_stands_keeps_its_belief() -> None:
    particles = np.random.default_rng(0).normal(size=(50, 3))
    moved = predict(particles, Pose(0.0, 0.0, 0.0), OdometryNoise(), np.random.default_rng(1))
    assert moved == pytest.approx(particles)


def test_between_looks_the_filter_is_less_sure_with_every_metre() -> None:
    spreads = []
    for metres in (0, 2, 8):
        following = tracked(straight(12))
        for _ in range(5 * metres):
            following.predict(AHEAD)
        here = compose(straight(13)[-1], Pose(0.2 * 5 * metres, 0.0, 0.0))
        spreads.append(following.correct(sharp(here, 1.0, 1.0)).spread_m)
    assert spreads[0] < spreads[1] < spreads[2]


# Eq. 5


def test_a_correction_by_hand() -> None:
    after = correct(np.array([0.5, 0.3, 0.2]), np.array([1.0, 2.0, 4.0]))
    assert after == pytest.approx([0.5 / 1.9, 0.6 / 1.9, 0.8 / 1.9])


def test_a_look_that_says_the_same_everywhere_changes_nothing() -> None:
    weights = np.array([0.7, 0.2, 0.1])
    assert correct(weights, np.full(3, 7.0)) == pytest.approx(weights)


def test_a_place_that_a_look_names_becomes_as_much_likelier_as_the_settings_say() -> None:
    named, other = np.tile([2.0, 3.0, 0.5], (10, 1)), np.tile([6.0, 3.0, 0.5], (30, 1))
    particles, weights = np.concatenate([named, other]), np.full(40, 1 / 40)
    for sigma_m in (0.02, 0.05, 0.3):
        likelihood = look_likelihood(sharp(Pose(2.0, 3.0, 0.5), sigma_m, lost=0.0), particles, weights, CONFIG)
        assert likelihood[:10] == pytest.approx(np.full(10, CONFIG.evidence), rel=1e-3)
        assert likelihood[10:] == pytest.approx(np.full(30, 1.0), abs=0.01)


def test_a_place_needs_its_heading_too() -> None:
    particles, weights = np.array([[2.0, 3.0, 0.5], [2.0, 3.0, 2.0]]), np.full(2, 0.5)
    likelihood = look_likelihood(sharp(Pose(2.0, 3.0, 0.5)), particles, weights, CONFIG)
    assert likelihood[0] > 2.5
    assert likelihood[1] == pytest.approx(1.0, abs=0.05)


def test_a_look_that_is_lost_says_little() -> None:
    particles, weights = np.array([[2.0, 3.0, 0.5], [6.0, 3.0, 0.5]]), np.full(2, 0.5)
    here = Pose(2.0, 3.0, 0.5)
    likelihoods = [look_likelihood(sharp(here, lost=lost), particles, weights, CONFIG)[0] for lost in (0.0, 0.5, 1.0)]
    assert likelihoods == pytest.approx([CONFIG.evidence, 0.5 * (CONFIG.evidence + 1.0), 1.0], rel=0.01)


def test_of_two_places_that_a_look_names_the_likelier_one_gains_more() -> None:
    particles, weights = np.array([[2.0, 3.0, 0.5], [6.0, 3.0, 0.5], [9.0, 1.0, 0.5]]), np.full(3, 1 / 3)
    look = belief_at([(0.75, 2.0, 3.0, 0.05), (0.25, 6.0, 3.0, 0.05)], [(1.0, 0.5, 0.03)])
    first, second, none = look_likelihood(look, particles, weights, CONFIG) - 1.0
    assert first == pytest.approx(3.0 * second, rel=0.01)
    assert second > 20 * none


def test_nearer_to_the_named_place_a_particle_gains_more_and_at_its_edge_it_loses() -> None:
    offsets = np.linspace(0.0, 0.3, 31)
    particles = np.column_stack([2.0 + offsets, np.full(31, 3.0), np.full(31, 0.5)])
    likelihood = look_likelihood(sharp(Pose(2.0, 3.0, 0.5)), particles, np.full(31, 1 / 31), CONFIG)
    assert (np.diff(likelihood[:15]) < 0).all()
    assert likelihood[0] > CONFIG.evidence > 1.0 > likelihood[20] > 0.0


def test_no_particle_ever_gets_a_likelihood_of_zero_or_less() -> None:
    rng, camera = np.random.default_rng(0), MadeUpCamera(seed=3, wrong=0.5)
    for _ in range(50):
        pose = random_pose(rng)
        particles = np.array(pose) + 0.2 * rng.standard_normal((300, 3))
        likelihood = look_likelihood(camera.look(pose)[0], particles, rng.dirichlet(np.ones(300)), CONFIG)
        assert likelihood.min() > 0.0


# The filter


def test_the_first_look_places_the_robot() -> None:
    pose = Pose(3.0, 2.0, -3.1)
    found = new_filter().correct(sharp(pose))
    assert distance_m(found.pose, pose) < 0.02
    assert abs(wrap_angles(np.array([found.pose.theta_rad - pose.theta_rad]))[0]) < 0.02
    assert found.probability == pytest.approx(1.0 - CONFIG.doubt, abs=0.02)
    assert len(found.particles) == len(found.weights) >= CONFIG.particles


def test_looks_that_agree_make_it_surer() -> None:
    following = new_filter()
    probabilities = []
    for pose in straight(8):
        probabilities.append(following.correct(sharp(pose)).probability)
        following.predict(AHEAD)
    assert probabilities[0] < probabilities[1] < probabilities[2]
    assert probabilities[-1] > 0.98


def test_it_errs_less_than_single_looks_do_in_the_middle_and_far_less_in_the_tail() -> None:
    driven, camera = drive(1000, seed=1), MadeUpCamera(seed=2)
    looks = [camera.look(pose) for pose in driven.poses]
    true = np.array(driven.poses)
    single_m, single_rad = pose_errors(np.array([belief.pose for belief, _ in looks]), true)
    found_m, found_rad = pose_errors(follow(driven, [belief for belief, _ in looks]), true)
    wrong = np.array([wrong for _, wrong in looks])
    assert wrong.sum() >= 10
    assert single_m[wrong].mean() > 2.0
    assert found_m[wrong].max() < 0.45
    assert np.median(found_m) < 0.85 * np.median(single_m)
    assert np.percentile(found_m, 95) < 0.7 * np.percentile(single_m, 95)
    assert found_m.mean() < 0.3 * single_m.mean()
    assert np.percentile(found_rad, 95) < np.percentile(single_rad, 95)


def test_it_errs_less_than_odometry_alone() -> None:
    driven, camera = drive(500, seed=3), MadeUpCamera(seed=4)
    poses = follow(driven, [camera.look(pose)[0] for pose in driven.poses])
    believed = [driven.poses[0]]
    for motion in driven.motions[1:]:
        believed.append(compose(believed[-1], motion))
    odometry_m = pose_errors(np.array(believed), np.array(driven.poses))[0]
    assert odometry_m[-100:].mean() > 5 * pose_errors(poses, np.array(driven.poses))[0][-100:].mean()


@pytest.mark.parametrize("alike", [False, True], ids=["each another place", "one place that moves along"])
@pytest.mark.parametrize("run", [1, 3, 5])
def test_a_run_of_wrong_looks_that_are_sure_does_not_throw_it_off(run: int, alike: bool) -> None:
    poses = straight(30)
    for seed in range(8):
        rng = np.random.default_rng(seed)
        following, other = tracked(poses[:12], seed), random_pose(rng)
        for pose in poses[12 : 12 + run]:
            found = following.correct(sharp(other))
            assert distance_m(found.pose, pose) < 0.3
            following.predict(AHEAD)
            other = compose(other, AHEAD) if alike else random_pose(rng)
        for pose in poses[12 + run : 16 + run]:
            found = following.correct(sharp(pose))
            assert distance_m(found.pose, pose) < 0.1
            following.predict(AHEAD)
        assert found.probability > 0.8


def test_a_long_run_of_wrong_looks_that_are_unsure_does_not_throw_it_off() -> None:
    def unsure(pose: Pose, rng: np.random.Generator) -> Belief:
        named = [pose, random_pose(rng), random_pose(rng)]
        places = [(share, p.x_m, p.y_m, 0.1) for share, p in zip((0.4, 0.3, 0.3), named, strict=True)]
        headings = [(share, p.theta_rad, 0.06) for share, p in zip((0.4, 0.3, 0.3), named, strict=True)]
        return belief_at(places, headings, lost=0.1)

    poses, other, rng = straight(24), Pose(2.0, 7.5, 0.0), np.random.default_rng(0)
    following = tracked(poses[:12])
    for pose in poses[12:]:
        found = following.correct(unsure(other, rng))
        assert distance_m(found.pose, pose) < 0.45
        following.predict(AHEAD)
        other = compose(other, AHEAD)


def test_a_robot_that_was_carried_off_is_found_within_ten_looks() -> None:
    driven, camera = drive(1000, seed=5, kidnap_every=20), MadeUpCamera(seed=6)
    away_m, _ = pose_errors(follow(driven, [camera.look(p)[0] for p in driven.poses]), np.array(driven.poses))
    kidnaps = np.flatnonzero(driven.kidnapped)
    soon = [bool((away_m[first + 9 : first + 13] < 0.45).all()) for first in kidnaps]
    assert len(soon) >= 45
    assert np.mean(soon) >= 0.95
    assert np.median(away_m[kidnaps]) > 2.0  # it was lost at first


def test_it_names_where_a_carried_off_robot_may_be_before_it_believes_it() -> None:
    poses, elsewhere = straight(12), Pose(11.0, 7.0, 2.0)
    following = tracked(poses)
    for _ in range(4):
        found = following.correct(sharp(elsewhere))
        following.predict(AHEAD)
        elsewhere = compose(elsewhere, AHEAD)
    assert distance_m(found.pose, elsewhere) > 2.0
    named = [Pose(*row[1:]) for row in found.others]
    assert min(distance_m(pose, elsewhere) for pose in named) < 0.3
    assert found.others[:, 0].sum() + found.probability <= 1.0 + 1e-9


def test_a_wrong_first_look_is_soon_forgiven() -> None:
    poses, following = straight(9), new_filter()
    following.correct(sharp(Pose(12.0, 8.0, 1.0)))
    for pose in poses[1:]:
        following.predict(AHEAD)
        found = following.correct(sharp(pose))
    assert distance_m(found.pose, poses[-1]) < 0.1
    assert found.probability > 0.8


def test_of_two_places_that_look_alike_driving_tells_which() -> None:
    def both(pose: Pose, other: Pose) -> Belief:
        at = [(0.55, other.x_m, other.y_m, 0.05), (0.45, pose.x_m, pose.y_m, 0.05)]
        return belief_at(at, [(1.0, pose.theta_rad, 0.03)])

    poses, others = straight(12), straight(12, Pose(2.0, 7.0, 0.0))
    following = new_filter()
    for pose, other in zip(poses[:4], others[:4], strict=True):
        found = following.correct(both(pose, other))
        following.predict(AHEAD)
    assert 0.3 < found.probability < 0.9
    second = Pose(*found.others[0, 1:])
    assert min(distance_m(found.pose, poses[3]), distance_m(second, poses[3])) < 0.1
    assert min(distance_m(found.pose, others[3]), distance_m(second, others[3])) < 0.1
    for pose in poses[4:9]:
        found = following.correct(sharp(pose))
        following.predict(AHEAD)
    assert distance_m(found.pose, poses[8]) < 0.1
    assert found.probability > 0.9


def test_the_pose_is_in_a_cluster_and_not_between_two() -> None:
    look = belief_at([(0.55, 2.0, 3.0, 0.05), (0.45, 6.0, 3.0, 0.05)], [(1.0, 0.5, 0.03)])
    found = new_filter().correct(look)
    assert distance_m(found.pose, Pose(2.0, 3.0, 0.0)) < 0.05
    assert found.spread_m < 0.2
    assert found.probability == pytest.approx(0.55 * 0.9, abs=0.06)
    assert found.others[0] == pytest.approx([0.45 * 0.9, 6.0, 3.0, 0.5], abs=0.06)


def test_a_robot_that_stands_learns_little_from_the_same_wrong_look_again_and_again() -> None:
    def looks_until_thrown_off(motion: Pose) -> int:
        following = tracked(straight(12))
        other = Pose(11.0, 8.0, 0.0)
        for count in range(1, 60):
            if distance_m(following.correct(sharp(other)).pose, other) < 0.3:
                return count
            following.predict(motion)
            other = compose(other, motion)
        return 60

    assert 6 <= looks_until_thrown_off(AHEAD) <= 8
    assert looks_until_thrown_off(Pose(0.0, 0.0, 0.0)) > 12


def test_forgetting_makes_the_next_look_the_first() -> None:
    following = tracked(straight(12))
    following.forget()
    elsewhere = Pose(11.0, 8.0, 2.0)
    assert distance_m(following.correct(sharp(elsewhere)).pose, elsewhere) < 0.05


def test_motion_before_the_first_look_does_not_matter() -> None:
    following, pose = new_filter(), Pose(3.0, 2.0, 1.0)
    following.predict(AHEAD)
    assert distance_m(following.correct(sharp(pose)).pose, pose) < 0.05


def test_where_the_robot_cannot_be_it_is_less_likely() -> None:
    free = np.zeros((9, 14), dtype=np.bool_)
    free[:, 7:] = True  # x from 7 m on
    floor = FreeFloor(free, GridFrame(0.0, 0.0, 1.0, 9, 14))
    look = belief_at([(0.7, 2.0, 3.0, 0.1), (0.3, 10.0, 3.0, 0.1)], [(1.0, 0.5, 0.03)])
    assert new_filter().correct(look).pose.x_m == pytest.approx(2.0, abs=0.1)
    assert new_filter(floor=floor).correct(look).pose.x_m == pytest.approx(10.0, abs=0.1)


def test_the_free_floor_has_the_top_row_at_the_largest_y_and_ends_at_its_border() -> None:
    free = np.array([[True, False], [False, False]])
    floor = FreeFloor(free, GridFrame(-1.0, 0.0, 1.0, 2, 2))
    poses = np.array([[-0.5, 1.5, 0.0], [-0.5, 0.5, 0.0], [0.5, 1.5, 0.0], [-0.5, 2.5, 0.0], [-1.5, 1.5, 0.0]])
    assert floor.holds(poses).tolist() == [True, False, False, False, False]


def test_the_weights_and_what_is_elsewhere_add_up_to_one() -> None:
    following, camera = new_filter(), MadeUpCamera(seed=7)
    for pose in straight(30):
        found = following.correct(camera.look(pose)[0])
        assert 0.0 < found.weights.sum() < 1.0
        assert found.probability <= found.weights.sum() + 1e-9
        assert CONFIG.particles <= len(found.weights) < 2 * CONFIG.particles
        following.predict(AHEAD)


def test_the_same_stream_gives_the_same_poses_and_another_one_does_not() -> None:
    driven, camera = drive(40, seed=8), MadeUpCamera(seed=9)
    beliefs = [camera.look(pose)[0] for pose in driven.poses]
    assert (follow(driven, beliefs, 1) == follow(driven, beliefs, 1)).all()
    assert (follow(driven, beliefs, 1) != follow(driven, beliefs, 2)).any()


def test_a_first_look_that_names_no_place_still_gives_a_pose() -> None:
    following = BeliefFilter(FilterConfig(), OdometryNoise(), np.random.default_rng(0))
    found = following.correct(belief_at([(1.0, 2.0, 1.0, 50.0)], [(1.0, 0.0, 0.5)], 1.0))
    assert np.isfinite(found.pose).all()
    assert 0.0 < found.probability <= 1.0
