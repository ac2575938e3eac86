"""How well the belief filter follows the robot along driven tracks, beside single frames, and how it finds it again.

A robot that was carried off counts as found when the estimate lies within 0.45 m of it and stays there for the next
few frames (Fox, Burgard, Thrun 1999). N frames, T kidnaps.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.belief import Belief
from twonav_cli.config import OdometryNoise
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.localizer.belief_filter import BeliefFilter, FilterConfig, FreeFloor
from twonav_cli.localizer.errors_report import error_metrics, pose_errors
from twonav_cli.rng import stream

if TYPE_CHECKING:
    from twonav_cli.experiments.tracks import Tracks

FOUND_M = 0.45
"""An estimate within this distance of the robot has found it (Fox, Burgard, Thrun 1999)."""

HELD_FRAMES = 3
"""Frames after it for which an estimate must stay there (ours)."""

SOON_FRAMES = 10
"""Frames, the first one after a kidnap included, within which the robot should be found again: 4 s (ours)."""

NEVER = np.inf


def single_poses(beliefs: Sequence[Belief]) -> FloatArray:
    """Return the pose [N, 3] that each look alone names."""
    return np.array([belief.pose for belief in beliefs], dtype=np.float64).reshape(-1, 3)


def filtered_poses(
    tracks: Tracks,
    beliefs: Sequence[Belief],
    config: FilterConfig | None = None,
    noise: OdometryNoise | None = None,
    seed: int = 0,
    floor: FreeFloor | None = None,
) -> FloatArray:
    """Return the filter's pose [N, 3] after each look; it knows nothing at the beginning of a track.

    Args:
        tracks: Motions, and where tracks begin.
        beliefs: [N] what each picture says.
        config: Settings of the filter.
        noise: The odometry's deviations.
        seed: The filter draws from a stream of its own.
        floor: Where the robot can be, if that is known.

    Raises:
        TwonavError: There are not as many beliefs as frames.
    """
    if len(beliefs) != len(tracks.poses):
        raise TwonavError(f"{len(beliefs)} beliefs for {len(tracks.poses)} frames: give one for each frame")
    rng = stream(seed, "belief filter")
    following = BeliefFilter(config or FilterConfig(), noise or OdometryNoise(), rng, floor)
    poses = np.empty((len(beliefs), 3))
    for index, (belief, begins) in enumerate(zip(beliefs, tracks.begins, strict=True)):
        if begins:
            following.forget()
        following.predict(Pose(*tracks.motions[index].tolist()))
        poses[index] = following.correct(belief).pose
    return poses


def tracking_report(tracks: Tracks, single: FloatArray, filtered: FloatArray) -> dict[str, Any]:
    """Return how well poses [N, 3] from single frames and from the filter follow the robot.

    Returns:
        "frames", "undisturbed" (those that are not among the SOON_FRAMES after a kidnap); and "single" and "filtered",
        each with `tracking_figures`.
    """
    return {
        "frames": len(tracks.poses),
        "undisturbed": int(undisturbed(tracks).sum()),
        "single": tracking_figures(tracks, single),
        "filtered": tracking_figures(tracks, filtered),
    }


def tracking_figures(tracks: Tracks, poses: FloatArray) -> dict[str, Any]:
    """Return how well estimated poses [N, 3] follow the robot.

    Returns:
        The errors at undisturbed frames (`error_metrics`); "lost_frames": at how many of these the estimate is not
        where the robot is; "false_resets": how often it leaves the robot though nobody carried that off; and how the
        robot was found again after kidnaps (`kidnap_figures`).
    """
    away_m, _ = pose_errors(poses, tracks.poses)
    calm = undisturbed(tracks)
    return {
        **(error_metrics(poses[calm], tracks.poses[calm]) if calm.any() else {}),
        "lost_frames": int((away_m[calm] > FOUND_M).sum()),
        "false_resets": false_resets(tracks, away_m),
        **kidnap_figures(tracks, away_m),
    }


def undisturbed(tracks: Tracks) -> NDArray[np.bool_]:
    """Return the frames [N] that are not among the SOON_FRAMES from a kidnap on, in its track."""
    calm = np.ones(len(tracks.poses), dtype=np.bool_)
    for first, end in _kidnaps(tracks):
        calm[first : min(end, first + SOON_FRAMES)] = False
    return calm


def false_resets(tracks: Tracks, away_m: FloatArray) -> int:
    """Return how often an estimate, `away_m` [N] from the robot, leaves it at an undisturbed frame."""
    left = (away_m[1:] > FOUND_M) & (away_m[:-1] <= FOUND_M)
    return int((left & undisturbed(tracks)[1:] & ~tracks.begins[1:]).sum())


def frames_to_find(tracks: Tracks, away_m: FloatArray) -> FloatArray:
    """Return after how many looks [T] the robot is found again for each kidnap; 1: by the first look, inf: never.

    A kidnap is left out when the track or the time until the next kidnap is too short to tell.
    """
    counts = []
    for first, end in _kidnaps(tracks):
        if end - first < SOON_FRAMES + HELD_FRAMES:
            continue
        near = away_m[first:end] <= FOUND_M
        held = np.lib.stride_tricks.sliding_window_view(near, HELD_FRAMES + 1).all(axis=1)
        counts.append(float(held.argmax()) + 1.0 if held.any() else NEVER)
    return np.array(counts)


def kidnap_figures(tracks: Tracks, away_m: FloatArray) -> dict[str, Any]:
    """Return how the robot was found again after kidnaps, by an estimate that was `away_m` [N] from it.

    Returns:
        "kidnaps", "found_soon" (share found within SOON_FRAMES looks), "found" (share found at all), "looks_median" and
        "looks_mean" (of those found), and "false_finds": how often an estimate came near and left again before it held.
        The shares and looks are None where there is none.
    """
    counts = frames_to_find(tracks, away_m)
    found = counts[np.isfinite(counts)]
    return {
        "kidnaps": len(counts),
        "found_soon": float((counts <= SOON_FRAMES).mean()) if len(counts) else None,
        "found": len(found) / len(counts) if len(counts) else None,
        "looks_median": float(np.median(counts)) if len(found) > len(counts) / 2 else None,
        "looks_mean": float(found.mean()) if len(found) else None,
        "false_finds": _false_finds(tracks, away_m),
    }


def _false_finds(tracks: Tracks, away_m: FloatArray) -> int:
    """Count the times after a kidnap that an estimate came near and left before it had held."""
    left = 0
    for first, end in _kidnaps(tracks):
        near = away_m[first:end] <= FOUND_M
        edges = np.diff(np.concatenate([[False], near]).astype(np.int8))
        comes, leaves = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
        held = leaves - comes[: len(leaves)] > HELD_FRAMES
        left += int(np.argmax(held)) if held.any() else len(leaves)
    return left


def _kidnaps(tracks: Tracks) -> list[tuple[int, int]]:
    """Return the first frame after each kidnap, and the frame at which the time after it ends."""
    ends = np.flatnonzero(tracks.kidnapped | tracks.begins)
    after = np.append(ends[1:], len(tracks.poses))
    return [(int(f), int(e)) for f, e in zip(ends, after, strict=True) if tracks.kidnapped[f]]
