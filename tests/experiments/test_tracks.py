"""Driven tracks in the kitchen: what is recorded fits together, and odometry knows nothing of being carried off."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from twonav_cli.dataset.poses import fits
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.tracks import CARRIED_AT_LEAST_M, LOOK_EVERY_TICKS, Tracks, drive_tracks
from twonav_cli.geometry import Pose, relative_pose
from twonav_cli.mapping.floor import Floor, read_floor

FRAMES, KIDNAP_EVERY = 45, 15


@pytest.fixture(scope="module")
def floor(tmp_path_factory: pytest.TempPathFactory) -> Floor:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TWONAV_RUNS", str(tmp_path_factory.mktemp("runs")))
        return read_floor("kitchen")


@pytest.fixture(scope="module")
def tracks(floor: Floor) -> Tracks:
    return drive_tracks(floor, seed=3, frames=FRAMES, kidnap_every=KIDNAP_EVERY)


def true_motions(tracks: Tracks) -> np.ndarray:
    """Return how the robot came from each frame to the next [N - 1, 3], in its frame then."""
    poses = [Pose(*pose) for pose in tracks.poses.tolist()]
    return np.array([relative_pose(a, b) for a, b in pairwise(poses)])


def test_there_are_as_many_frames_as_asked_for_and_every_column_has_them(tracks: Tracks) -> None:
    assert tracks.images.shape == (FRAMES, 84, 84, 3)
    assert tracks.images.dtype == np.uint8
    assert tracks.poses.shape == tracks.motions.shape == (FRAMES, 3)
    assert len(tracks.track) == len(tracks.kidnapped) == FRAMES


def test_pictures_differ_from_frame_to_frame(tracks: Tracks) -> None:
    away = np.abs(np.diff(tracks.images.astype(int), axis=0)).mean(axis=(1, 2, 3))
    assert np.median(away) > 2


def test_odometry_reports_nearly_the_true_motion_where_nobody_carried_the_robot(tracks: Tracks) -> None:
    driven = ~(tracks.kidnapped | tracks.begins)[1:]
    error = tracks.motions[1:][driven] - true_motions(tracks)[driven]
    assert 0.001 < np.abs(error[:, 0]).mean() < 0.02
    assert np.abs(error).max() < 0.15
    assert (error != 0).any(axis=1).mean() > 0.8


def test_the_robot_drives_and_looks_often(tracks: Tracks) -> None:
    driven_m = np.hypot(*tracks.motions[1:, :2].T)
    assert driven_m.max() < 0.65 * LOOK_EVERY_TICKS * 0.1 + 0.05
    assert driven_m.sum() > 2.0


def test_the_robot_is_carried_off_as_often_as_asked_for(tracks: Tracks) -> None:
    carried = np.flatnonzero(tracks.kidnapped)
    assert len(carried) == 2
    assert (np.diff(np.concatenate([[0], carried])) >= KIDNAP_EVERY).all()
    assert not tracks.begins[carried].any()


def test_odometry_reports_nothing_of_being_carried_off(tracks: Tracks) -> None:
    for index in np.flatnonzero(tracks.kidnapped):
        away_m = np.hypot(*(tracks.poses[index, :2] - tracks.poses[index - 1, :2]))
        assert away_m > CARRIED_AT_LEAST_M - 0.3  # since the frame before it drove a little, too
        assert np.hypot(*tracks.motions[index, :2]) < 0.3


def test_at_the_first_frame_of_a_track_nothing_has_moved(tracks: Tracks) -> None:
    assert tracks.begins[0]
    assert (tracks.motions[tracks.begins] == 0).all()


def test_the_robot_stands_only_where_it_fits(tracks: Tracks, floor: Floor) -> None:
    assert fits(floor.map.occupied, floor.map.frame, tracks.poses).mean() > 0.95


def test_the_same_seed_gives_the_same_tracks_and_another_one_does_not(tracks: Tracks, floor: Floor) -> None:
    again = drive_tracks(floor, seed=3, frames=12, kidnap_every=KIDNAP_EVERY)
    other = drive_tracks(floor, seed=4, frames=12)
    for name in ("images", "poses", "motions", "track", "kidnapped"):
        assert (getattr(again, name) == getattr(tracks, name)[:12]).all()
    assert (other.poses != again.poses).any()
    assert not other.kidnapped.any()


def test_progress_is_told_frame_by_frame(floor: Floor) -> None:
    told: list[tuple[int, int]] = []
    drive_tracks(floor, seed=5, frames=3, progress=lambda done, wanted: told.append((done, wanted)))
    assert told == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize(("frames", "kidnap_every"), [(0, 0), (5, -1)])
def test_asking_for_nothing_is_an_error(floor: Floor, frames: int, kidnap_every: int) -> None:
    with pytest.raises(TwonavError, match="positive number"):
        drive_tracks(floor, 0, frames, kidnap_every)
