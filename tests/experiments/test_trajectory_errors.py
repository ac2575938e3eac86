import math
import warnings

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.trajectory_errors import (
    NEAR_M,
    STAMP_TOLERANCE_S,
    aligned_errors,
    relation_errors,
    relative_poses,
)
from twonav_cli.geometry import Pose, compose, relative_pose

FIRST_S = 1134864629.9


def drive(count: int = 30) -> np.ndarray:
    """Return a trajectory [N, 4] on an arc, 0.25 m apart."""
    poses = [Pose(-1.0, 2.0, 3.0)]
    for _ in range(count - 1):
        poses.append(compose(poses[-1], Pose(0.25, 0.0, 0.1)))
    return np.column_stack([FIRST_S + 0.5 * np.arange(count), np.array(poses)])


def moved(trajectory: np.ndarray, by: Pose) -> np.ndarray:
    """Return the same way in another frame."""
    poses = [compose(by, Pose(*pose)) for pose in trajectory[:, 1:].tolist()]
    return np.column_stack([trajectory[:, 0], np.array(poses)])


def relations_of(trajectory: np.ndarray, step: int = 3) -> np.ndarray:
    """Return what is true of every pair of poses some steps apart [K, 5]."""
    first, second = trajectory[:-step], trajectory[step:]
    pairs = zip(first[:, 1:].tolist(), second[:, 1:].tolist(), strict=True)
    seen = np.array([relative_pose(Pose(*a), Pose(*b)) for a, b in pairs])
    return np.column_stack([first[:, 0], second[:, 0], seen])


def test_relative_poses_are_those_of_the_geometry() -> None:
    a, b = drive()[:-5, 1:], drive()[5:, 1:]
    for row, origin, target in zip(relative_poses(a, b), a.tolist(), b.tolist(), strict=True):
        assert row == pytest.approx(np.array(relative_pose(Pose(*origin), Pose(*target))))


def test_a_trajectory_has_no_error_beside_itself() -> None:
    errors = aligned_errors(drive(), drive())
    assert errors[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-7)
    assert errors.used == 30
    assert relation_errors(drive(), relations_of(drive()))[:2] == pytest.approx((0.0, 0.0), abs=1e-7)


def test_another_frame_changes_no_error() -> None:
    other = moved(drive(), Pose(40.0, -7.0, 2.5))
    assert aligned_errors(other, drive())[:3] == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)
    assert relation_errors(other, relations_of(drive()))[:2] == pytest.approx((0.0, 0.0), abs=1e-6)


def test_one_pose_that_is_shifted_counts_in_its_two_relations() -> None:
    wrong = drive()
    heading = wrong[10, 3]
    wrong[10, 1:3] += 0.6 * np.array([math.cos(heading), math.sin(heading)])
    errors = relation_errors(wrong, relations_of(drive()))
    assert errors.used == 27
    assert errors.translation_m == pytest.approx(2 * 0.6 / 27)
    assert errors.rotation_deg == pytest.approx(0.0, abs=1e-6)


def test_one_heading_that_is_wrong_turns_what_is_seen_from_it() -> None:
    wrong = drive()
    wrong[10, 3] += 0.2
    relations = relations_of(drive())
    errors = relation_errors(wrong, relations)
    assert errors.rotation_deg == pytest.approx(2 * math.degrees(0.2) / 27)
    away_m = math.hypot(*relations[10, 2:4])  # the pose three steps on, seen from the turned one
    assert errors.translation_m == pytest.approx(2 * math.sin(0.1) * away_m / 27)


def test_the_sign_of_an_error_does_not_matter() -> None:
    left, right = drive(), drive()
    left[10, 3] += 0.3
    right[10, 3] -= 0.3
    a, b = (relation_errors(trajectory, relations_of(drive())) for trajectory in (left, right))
    assert a.rotation_deg == pytest.approx(b.rotation_deg)
    assert a.rotation_deg > 0


def test_the_position_error_is_that_of_the_best_turn_and_shift() -> None:
    reference = np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [2.0, 0.0, 1.0, 0.0], [3.0, 0.0, -1.0, 0.0]])
    stretched = reference.copy()
    stretched[:, 1:3] *= 1.1
    turned = moved(stretched, Pose(3.0, 4.0, -2.0))
    assert aligned_errors(turned, reference).position_rms_m == pytest.approx(0.1)


def test_no_turn_and_shift_does_better_than_the_alignment() -> None:
    rng = np.random.default_rng(0)
    noisy = drive()
    noisy[:, 1:3] += 0.1 * rng.standard_normal((30, 2))
    found = aligned_errors(moved(noisy, Pose(1.0, 2.0, 0.8)), drive()).position_rms_m
    for by in (Pose(0.0, 0.0, 0.0), Pose(0.02, 0.0, 0.0), Pose(0.0, 0.0, 0.02), Pose(-0.02, 0.03, -0.02)):
        off_m = moved(noisy, by)[:, 1:3] - drive()[:, 1:3]
        assert found <= math.sqrt((off_m**2).sum(axis=1).mean())
    assert found > 0.05


def test_only_pairs_near_each_other_are_compared() -> None:
    reference = np.column_stack([np.arange(4.0), [0.0, 1.5, 10.0, 11.5], np.zeros(4), np.zeros(4)])
    wrong = reference.copy()
    wrong[1, 1] += 0.2
    wrong[2:, 1] += 5.0  # the two halves are wrong beside each other, but more than NEAR_M apart
    errors = aligned_errors(wrong, reference)
    assert 1.5 < NEAR_M < 8.5
    assert errors.pairs_m == pytest.approx(0.1)  # 0.2 in one pair, 0 in the other
    assert errors.pairs_deg == pytest.approx(0.0, abs=1e-6)


def test_stamps_are_paired_by_the_nearest_within_the_tolerance() -> None:
    shifted = drive()
    shifted[:, 0] += 0.5 * STAMP_TOLERANCE_S
    assert aligned_errors(shifted, drive()).used == 30
    shifted[5:, 0] += 2 * STAMP_TOLERANCE_S
    assert aligned_errors(shifted, drive()).used == 5
    thinned = drive()[np.random.default_rng(0).permutation(30)[:12]]
    errors = aligned_errors(thinned, drive())
    assert errors.used == 12
    assert errors.position_rms_m == pytest.approx(0.0, abs=1e-6)


def test_a_relation_whose_stamp_is_missing_is_left_out() -> None:
    relations = relations_of(drive())
    errors = relation_errors(drive()[:10], relations)
    assert errors.used == 7
    assert errors.translation_m == pytest.approx(0.0, abs=1e-6)
    assert relation_errors(drive()[[4, 7]], relations).used == 1


def test_no_common_stamps_are_an_error() -> None:
    other = drive()
    other[:, 0] += 1000.0
    with pytest.raises(TwonavError, match="same log"):
        relation_errors(other, relations_of(drive()))
    with pytest.raises(TwonavError, match="only 0 stamps"):
        aligned_errors(other, drive())
    with pytest.raises(TwonavError, match="only 2 stamps"):
        aligned_errors(drive()[:2], drive())
    with pytest.raises(TwonavError, match="only 1 stamps"):
        aligned_errors(drive()[:1], drive())


def test_poses_that_are_all_far_apart_leave_the_errors_of_pairs_open_without_a_warning() -> None:
    reference = np.column_stack([np.arange(4.0), 5.0 * np.arange(4.0), np.zeros(4), np.zeros(4)])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        errors = aligned_errors(reference, reference)
    assert errors.position_rms_m == pytest.approx(0.0, abs=1e-9)
    assert math.isnan(errors.pairs_m)
    assert math.isnan(errors.pairs_deg)


def test_an_empty_trajectory_is_an_error_of_the_log() -> None:
    with pytest.raises(TwonavError, match="same log"):
        aligned_errors(np.zeros((0, 4)), drive())
