"""The figures of tracks: errors where nobody disturbs, finding after a kidnap, false resets."""

from __future__ import annotations

import math

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.tracking_report import (
    FOUND_M,
    HELD_FRAMES,
    SOON_FRAMES,
    false_resets,
    filtered_poses,
    frames_to_find,
    kidnap_figures,
    single_poses,
    tracking_report,
    undisturbed,
)
from twonav_cli.experiments.tracks import Tracks
from twonav_cli.geometry import Pose, compose
from twonav_cli.grid import GridFrame
from twonav_cli.motion import noisy_motion

FRAME = GridFrame(0.0, 0.0, 1.0, 9, 14)
NEAR, FAR = 0.1, 3.0


def tracks_of(frames: int, kidnaps: tuple[int, ...] = (), begins: tuple[int, ...] = (0,)) -> Tracks:
    """Return tracks of a robot that stands, carried off before some frames."""
    kidnapped, track = np.zeros(frames, dtype=bool), np.zeros(frames, dtype=np.int64)
    kidnapped[list(kidnaps)] = True
    track[list(begins)] = 1
    images = np.zeros((frames, 84, 84, 3), dtype=np.uint8)
    return Tracks(images, np.zeros((frames, 3)), np.zeros((frames, 3)), np.cumsum(track) - 1, kidnapped)


def away_of(pattern: str) -> np.ndarray:
    """Return distances [N] to the robot: n is near, F is far."""
    return np.where(np.array(list(pattern)) == "n", NEAR, FAR)


def belief_in(pose: Pose) -> Belief:
    places, headings = np.array([[1.0, pose.x_m, pose.y_m, 0.05]]), np.array([[1.0, pose.theta_rad, 0.03]])
    return Belief(places, headings, 0.02, 126.0, np.zeros(FRAME.shape, dtype=np.float32), FRAME)


def driven(frames: int, seed: int, kidnap_every: int = 0, track_frames: int = 1000) -> tuple[Tracks, list[Belief]]:
    """Return a drive on circles, and looks that err by 3 cm; every 25th look names another place."""
    rng = np.random.default_rng(seed)
    poses, motions, kidnapped, beliefs = [], [], [], []
    for index in range(frames):
        carried = bool(kidnap_every and index and index % kidnap_every == 0)
        moved = Pose(0.0, 0.0, 0.0) if carried or index % track_frames == 0 else Pose(0.2, 0.0, 0.1)
        anew = carried or index % track_frames == 0
        drawn = Pose(*rng.uniform([3.0, 3.0, -math.pi], [11.0, 6.0, math.pi]).tolist())
        poses.append(drawn if anew else compose(poses[-1], moved))
        motions.append(noisy_motion(moved, OdometryNoise(), rng))
        kidnapped.append(carried)
        seen = Pose(*(np.array(poses[-1]) + [0.03, 0.03, 0.01] * rng.standard_normal(3)).tolist())
        beliefs.append(belief_in(drawn if index % 25 == 24 else seen))
    images = np.zeros((frames, 84, 84, 3), dtype=np.uint8)
    track = np.arange(frames) // track_frames
    return Tracks(images, np.array(poses), np.array(motions), track, np.array(kidnapped)), beliefs


def test_the_frames_after_a_kidnap_are_not_undisturbed() -> None:
    calm = undisturbed(tracks_of(40, kidnaps=(20,)))
    assert np.flatnonzero(~calm).tolist() == list(range(20, 20 + SOON_FRAMES))


def test_what_comes_after_the_end_of_a_track_is_not_disturbed_by_a_kidnap_in_it() -> None:
    calm = undisturbed(tracks_of(40, kidnaps=(20,), begins=(0, 23)))
    assert np.flatnonzero(~calm).tolist() == [20, 21, 22]


@pytest.mark.parametrize(
    ("after", "looks"),
    [
        ("nnnnnnnnnnnnnnn", 1.0),
        ("FFnnnnnnnnnnnnn", 3.0),
        ("FnFFnnnnnnnnnnn", 5.0),
        ("FnnnFnnnnnnnnnn", 6.0),
        ("FFFFFFFFFFFnnnn", 12.0),
        ("FFFFFFFFFFFFnnn", math.inf),
        ("FFFFFFFFFFFFFFF", math.inf),
    ],
)
def test_a_robot_is_found_when_the_estimate_is_near_and_stays_there(after: str, looks: float) -> None:
    assert frames_to_find(tracks_of(25, kidnaps=(10,)), away_of("n" * 10 + after)).tolist() == [looks]


def test_an_estimate_on_the_border_has_found_the_robot() -> None:
    away = np.concatenate([np.full(5, NEAR), np.full(15, FOUND_M)])
    assert frames_to_find(tracks_of(20, kidnaps=(5,)), away).tolist() == [1.0]


def test_a_kidnap_that_is_soon_followed_by_another_one_is_left_out() -> None:
    least = SOON_FRAMES + HELD_FRAMES
    tracks = tracks_of(10 + least - 1 + least, kidnaps=(10, 10 + least - 1))
    assert frames_to_find(tracks, np.full(len(tracks.poses), NEAR)).tolist() == [1.0]


def test_the_figures_of_kidnaps_by_hand() -> None:
    tracks = tracks_of(70, kidnaps=(10, 30, 50))
    away = away_of("n" * 10 + "FFFFFF" + "n" * 14 + "FFnFFFFF" + "n" * 12 + "F" * 12 + "n" * 8)
    assert kidnap_figures(tracks, away) == {
        "kidnaps": 3,
        "found_soon": pytest.approx(2 / 3),
        "found": 1.0,
        "looks_median": 9.0,
        "looks_mean": pytest.approx((7 + 9 + 13) / 3),
        "false_finds": 1,
    }


def test_without_kidnaps_there_are_no_figures_of_them() -> None:
    figures = kidnap_figures(tracks_of(20), np.full(20, NEAR))
    assert (figures["kidnaps"], figures["false_finds"]) == (0, 0)
    assert figures["found_soon"] is figures["found"] is figures["looks_median"] is figures["looks_mean"] is None


def test_the_median_of_looks_is_none_when_most_are_never_found() -> None:
    tracks = tracks_of(60, kidnaps=(10, 30))
    figures = kidnap_figures(tracks, away_of("n" * 10 + "F" * 50))
    assert (figures["found"], figures["looks_median"], figures["looks_mean"]) == (0.0, None, None)


@pytest.mark.parametrize(
    ("pattern", "kidnaps", "resets"),
    [
        ("nnnnnnnnnnnnnnnnnnnn", (), 0),
        ("nnnFFFnnnnFnnnnnnnnn", (), 2),
        ("FFFFFnnnnnnnnnnnnnnn", (), 0),
        ("nnnnnFFFFFFFnnnnnnnn", (5,), 0),
        ("nnFnnFFFFFFFnnnnFnnn", (5,), 2),
    ],
)
def test_a_false_reset_leaves_a_robot_that_nobody_carried_off(
    pattern: str, kidnaps: tuple[int, ...], resets: int
) -> None:
    assert false_resets(tracks_of(20, kidnaps), away_of(pattern)) == resets


def test_the_first_frame_of_a_track_is_no_false_reset() -> None:
    assert false_resets(tracks_of(10, begins=(0, 5)), away_of("nnnnnFFnnn")) == 0


def test_the_report_has_the_errors_of_undisturbed_frames_only() -> None:
    tracks = tracks_of(40, kidnaps=(20,))
    estimated = np.zeros((40, 3))
    estimated[20:25, 0] = 5.0
    estimated[:, 1] = 0.02
    report = tracking_report(tracks, estimated, estimated)
    assert (report["frames"], report["undisturbed"]) == (40, 30)
    assert report["filtered"]["n"] == 30
    assert report["filtered"]["pos_mean_m"] == pytest.approx(0.02)
    assert report["filtered"]["lost_frames"] == report["filtered"]["false_resets"] == 0
    assert report["filtered"]["looks_median"] == 6.0


def test_along_an_undisturbed_track_the_filter_errs_less_than_single_looks() -> None:
    tracks, beliefs = driven(300, seed=1)
    report = tracking_report(tracks, single_poses(beliefs), filtered_poses(tracks, beliefs))
    assert report["single"]["lost_frames"] >= 8
    assert report["filtered"]["lost_frames"] == report["filtered"]["false_resets"] == 0
    assert report["filtered"]["pos_mean_m"] < 0.2 * report["single"]["pos_mean_m"]
    assert report["filtered"]["pos_median_m"] < 0.8 * report["single"]["pos_median_m"]


def test_after_kidnaps_the_filter_finds_the_robot_and_single_looks_have_it_at_once() -> None:
    tracks, beliefs = driven(200, seed=2, kidnap_every=20)
    report = tracking_report(tracks, single_poses(beliefs), filtered_poses(tracks, beliefs))
    assert report["filtered"]["kidnaps"] == report["single"]["kidnaps"] == 9
    assert report["filtered"]["found_soon"] == 1.0
    assert 3 <= report["filtered"]["looks_median"] <= 9
    assert report["single"]["looks_median"] == 1.0


def test_at_the_beginning_of_a_track_the_filter_knows_nothing() -> None:
    tracks, beliefs = driven(60, seed=3, track_frames=20)
    poses = filtered_poses(tracks, beliefs)
    away_m = np.hypot(*(poses - tracks.poses)[:, :2].T)
    assert tracks.begins.sum() == 3
    assert away_m[tracks.begins].max() < 0.2


def test_the_same_seed_gives_the_same_filtered_poses() -> None:
    tracks, beliefs = driven(30, seed=4)
    assert (filtered_poses(tracks, beliefs, seed=1) == filtered_poses(tracks, beliefs, seed=1)).all()
    assert (filtered_poses(tracks, beliefs, seed=1) != filtered_poses(tracks, beliefs, seed=2)).any()


def test_every_frame_needs_a_belief() -> None:
    tracks, beliefs = driven(5, seed=5)
    with pytest.raises(TwonavError, match="4 beliefs for 5 frames"):
        filtered_poses(tracks, beliefs[:4])
