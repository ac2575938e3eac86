"""Taking the frames: renders every pose of a plan into memory-mapped files, and goes on after a kill.

A data set is a folder: `frames.npy` uint8 [N, 84, 84, 3], `poses.npy` float32 [N, 3] (where the robot stood),
`kinds.npy` and `splits.npy` uint8 [N], `meta.json` (what it shows), `progress.json` (how many frames are there). Where
the robot itself found out where it stood, `labels.npy` float32 [N, 3] holds that, not a number where it did not; else
the poses are the labels.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import IMAGE_PX
from twonav_cli.dataset.plan import FramePlan
from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.geometry import Pose

FORMAT = 1
FRAMES_FILE, POSES_FILE, KINDS_FILE, SPLITS_FILE = "frames.npy", "poses.npy", "kinds.npy", "splits.npy"
LABELS_FILE = "labels.npy"
META_FILE, PROGRESS_FILE = "meta.json", "progress.json"
MAPPER, SIMULATOR = "mapper", "simulator"
"""Who says where the frames were taken."""

IMAGE_SHAPE = (IMAGE_PX, IMAGE_PX, 3)

Render = Callable[[Pose], NDArray[np.uint8]]
Label = Callable[[int, Pose], Pose | None]
Progress = Callable[[int, int], None]
Frames = np.memmap[Any, np.dtype[np.uint8]]
Labels = np.memmap[Any, np.dtype[np.float32]]

_CHUNK = 500
"""Frames between two marks of progress: about half a second of rendering is lost by a kill."""


@dataclass(frozen=True)
class Provenance:
    """What the frames show, so that they are never mixed with those of something else."""

    scene: str
    scene_digest: str
    seed: int
    render: dict[str, Any] = field(default_factory=dict)
    """Settings of the camera; training and running must use the same."""
    labels: str = SIMULATOR
    """Who says where the frames were taken: MAPPER or SIMULATOR."""
    map_digest: str | None = None
    """Of the map that the labels are from."""


def collect(
    render: Render,
    plan: FramePlan,
    folder: Path,
    provenance: Provenance,
    progress: Progress | None = None,
    should_stop: Callable[[], bool] | None = None,
    label: Label | None = None,
) -> Path:
    """Render, and label, what is missing of a data set (§4.1; the robot is placed, not driven: ours).

    Args:
        render: Places the robot at a pose and returns what its camera sees, uint8 [84, 84, 3] RGB.
        plan: Which frames.
        folder: Where the data set is or will be.
        provenance: Scene, seed and render settings.
        progress: Told (frames there, frames wanted) every few hundred frames.
        should_stop: Asked every few hundred frames; True ends early, and the next call goes on from there.
        label: Called right after `render` with the frame's number and pose; returns where the robot finds itself.

    Returns:
        The folder.

    Raises:
        TwonavError: The folder holds another data set or cannot be written, or the camera's image has a wrong shape.
    """
    try:
        frames, done = _opened(plan, folder, provenance)
        labels = _opened_labels(folder, len(plan.poses)) if label is not None else None
        total = len(plan.poses)
        while done < total and not (should_stop and should_stop()):
            end = min(done + _CHUNK, total)
            for index in range(done, end):
                pose = Pose(*(float(value) for value in plan.poses[index]))
                image = render(pose)
                if image.shape != IMAGE_SHAPE or image.dtype != np.uint8:
                    raise TwonavError(f"the camera gave {image.dtype} {image.shape}, not uint8 {IMAGE_SHAPE}")
                frames[index] = image
                if label is not None and labels is not None:
                    labels[index] = label(index, pose) or (np.nan, np.nan, np.nan)
            frames.flush()
            if labels is not None:
                labels.flush()
            done = end
            _write_progress(folder, done)
            if progress:
                progress(done, total)
    except OSError as error:
        raise TwonavError(f"cannot write frames to {folder}: {error.strerror or error}") from error
    return folder


def frames_done(folder: Path) -> int:
    """Return how many frames a folder holds; 0 where there is no data set."""
    try:
        return int(json.loads((folder / PROGRESS_FILE).read_text())["done"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0


def _opened(plan: FramePlan, folder: Path, provenance: Provenance) -> tuple[Frames, int]:
    """Return the writable frames [N, 84, 84, 3] of a new or continued data set, and how many are there."""
    meta = {"format": FORMAT, "frames": len(plan.poses), "plan": plan.digest, **asdict(provenance)}
    path = folder / META_FILE
    if path.exists() and (folder / FRAMES_FILE).exists():
        if _with_defaults(_read_json(path)) != json.loads(json.dumps(meta)):
            raise TwonavError(f"{folder} holds frames of another scene, map, plan or seed: delete it, or name another")
        frames = np.lib.format.open_memmap(folder / FRAMES_FILE, mode="r+")
        if frames.shape != (len(plan.poses), *IMAGE_SHAPE):
            raise TwonavError(f"{folder / FRAMES_FILE} has the wrong size: delete {folder} and collect again")
        return frames, min(frames_done(folder), len(plan.poses))
    folder.mkdir(parents=True, exist_ok=True)
    _write_progress(folder, 0)
    for name, array in ((POSES_FILE, plan.poses), (KINDS_FILE, plan.kinds), (SPLITS_FILE, plan.splits)):
        content = BytesIO()
        np.save(content, array, allow_pickle=False)
        write_whole(folder / name, content.getvalue())
    frames = np.lib.format.open_memmap(
        folder / FRAMES_FILE, mode="w+", dtype=np.uint8, shape=(len(plan.poses), *IMAGE_SHAPE)
    )
    write_whole(path, json.dumps(meta, indent=2) + "\n")
    return frames, 0


def _opened_labels(folder: Path, count: int) -> Labels:
    """Return the writable labels [N, 3] of a data set.

    Raises:
        TwonavError: Some of the frames that are there have none.
    """
    path = folder / LABELS_FILE
    if path.exists():
        labels = np.lib.format.open_memmap(path, mode="r+")
        if labels.shape == (count, 3) and labels.dtype == np.float32:
            return labels
    if path.exists() or frames_done(folder):
        raise TwonavError(f"{path} is missing or damaged: delete {folder} and collect again")
    labels = np.lib.format.open_memmap(path, mode="w+", dtype=np.float32, shape=(count, 3))
    labels[:] = np.nan
    return labels


def _with_defaults(meta: Any) -> Any:
    """Return what a data set says of itself; one that was made before there were labels has the simulator's."""
    return {"labels": SIMULATOR, "map_digest": None, **meta} if isinstance(meta, dict) else meta


def _write_progress(folder: Path, done: int) -> None:
    write_whole(folder / PROGRESS_FILE, json.dumps({"done": done}) + "\n")


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text())
    except ValueError:
        return None
