"""Taking the frames: chunk by chunk into memory-mapped files, on several processors, and on after a kill.

A data set is a folder: `frames.npy` uint8 [N, 84, 84, 3], `poses.npy` float32 [N, 3] (where the robot stood),
`kinds.npy` and `splits.npy` uint8 [N], `meta.json` (what it shows), `progress.json` (which chunks are there). Where
the robot itself found out where it stood, `labels.npy` float32 [N, 3] holds that, not a number where it did not; else
the poses are the labels.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Generator, Iterable
from contextlib import closing, suppress
from dataclasses import asdict, dataclass, field
from functools import cached_property
from io import BytesIO
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import IMAGE_PX
from twonav_cli.dataset.plan import FramePlan
from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.worker_pool import StoppedError, done_in_workers

FORMAT = 2
FRAMES_FILE, POSES_FILE, KINDS_FILE, SPLITS_FILE = "frames.npy", "poses.npy", "kinds.npy", "splits.npy"
LABELS_FILE = "labels.npy"
META_FILE, PROGRESS_FILE = "meta.json", "progress.json"
MAPPER, SIMULATOR = "mapper", "simulator"
"""Who says where the frames were taken."""

IMAGE_SHAPE = (IMAGE_PX, IMAGE_PX, 3)

Progress = Callable[[int, int], None]
Images = NDArray[np.uint8]
Labels = NDArray[np.float32]


class Taker(Protocol):
    """Takes the frames of a chunk: a robot with a camera, or a toy in a test."""

    def take(self, plan: FramePlan, chunk: int) -> tuple[Images, Labels | None]:
        """Return the pictures [n, 84, 84, 3] of a chunk and their labels [n, 3], None where nobody labels."""

    def close(self) -> None:
        """Give back what it holds."""


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
    make_taker: Callable[[], Taker],
    plan: FramePlan,
    folder: Path,
    provenance: Provenance,
    progress: Progress | None = None,
    should_stop: Callable[[], bool] = lambda: False,
    processes: int = 1,
) -> Path:
    """Take what is missing of a data set (§4.1; the robot is moved along the ways, its wheels are not simulated: ours).

    Args:
        make_taker: Makes what takes the frames, once in each process (it must be picklable for more than one).
        plan: Which frames.
        folder: Where the data set is or will be.
        provenance: Scene, seed, render settings, and who labels.
        progress: Told (frames there, frames wanted) after every chunk.
        should_stop: Asked after every chunk at least; True ends early, and the next call goes on from there.
        processes: How many work at a time; the frames are the same whatever this is.

    Returns:
        The folder.

    Raises:
        TwonavError: The folder holds another data set or cannot be written, or the camera's image has a wrong shape.
    """
    try:
        done = _opened(plan, folder, provenance) & set(range(len(plan.chunks)))
        missing = [chunk for chunk in range(len(plan.chunks)) if chunk not in done]
        sizes = np.diff(plan.chunks, axis=1)[:, 0]
        there = int(sizes[sorted(done)].sum())
        if not missing:
            return folder
        with closing(_taken(make_taker, plan, folder, missing, processes, should_stop)) as chunks:
            for chunk in chunks:
                done.add(chunk)
                there += int(sizes[chunk])
                _write_progress(folder, done)
                if progress:
                    progress(there, len(plan.poses))
    except OSError as error:
        raise TwonavError(f"cannot write frames to {folder}: {error.strerror or error}") from error
    return folder


def chunks_done(folder: Path) -> set[int]:
    """Return which chunks a folder holds; none where there is no data set."""
    try:
        content = json.loads((folder / PROGRESS_FILE).read_text())
        return {number for first, end in content["chunks"] for number in range(int(first), int(end))}
    except (OSError, ValueError, KeyError, TypeError):
        return set()


@dataclass(frozen=True)
class _Taking:
    """Takes chunks in a process of its own, with what is made there once."""

    make_taker: Callable[[], Taker]
    plan: FramePlan
    folder: Path

    @cached_property
    def taker(self) -> Taker:
        return self.make_taker()

    def __call__(self, chunk: int) -> None:
        _store(self.taker, self.plan, self.folder, chunk)


def _taken(
    make_taker: Callable[[], Taker],
    plan: FramePlan,
    folder: Path,
    missing: list[int],
    processes: int,
    should_stop: Callable[[], bool],
) -> Generator[int]:
    """Take chunks until asked to stop, and yield the number of each that is on disk.

    Raises:
        TwonavError: A process died.
    """
    with closing(make_taker()) as taker:  # what cannot be made is noticed here and not in every process
        if processes < 2 or len(missing) < 2:
            for chunk in missing:
                _store(taker, plan, folder, chunk)
                yield chunk
                if should_stop():
                    return
            return
    work, remedy = _Taking(make_taker, plan, folder), "the same command goes on from there"
    with suppress(StoppedError):
        for number, _ in done_in_workers(work, missing, processes, should_stop, remedy):
            yield missing[number]


def _store(taker: Taker, plan: FramePlan, folder: Path, chunk: int) -> None:
    """Take the frames of a chunk and write them where they belong."""
    images, labels = taker.take(plan, chunk)
    first, end = (int(number) for number in plan.chunks[chunk])
    if images.shape != (end - first, *IMAGE_SHAPE) or images.dtype != np.uint8:
        raise TwonavError(f"the camera gave {images.dtype} {images.shape[1:]}, not uint8 {IMAGE_SHAPE}")
    frames = np.lib.format.open_memmap(folder / FRAMES_FILE, mode="r+")
    frames[first:end] = images
    frames.flush()
    if labels is not None:
        stored = np.lib.format.open_memmap(folder / LABELS_FILE, mode="r+")
        stored[first:end] = labels
        stored.flush()


def _opened(plan: FramePlan, folder: Path, provenance: Provenance) -> set[int]:
    """Make a new data set, or check one that goes on; return the chunks that are there."""
    meta = {"format": FORMAT, "frames": len(plan.poses), "plan": plan.digest, **asdict(provenance)}
    meta["chunks"] = len(plan.chunks)
    path, shape = folder / META_FILE, (len(plan.poses), *IMAGE_SHAPE)
    by_mapper = provenance.labels == MAPPER
    if path.exists() and (folder / FRAMES_FILE).exists():
        if _read_json(path) != json.loads(json.dumps(meta)):
            raise TwonavError(f"{folder} holds frames of another scene, map, plan or seed: delete it to take them anew")
        _check_array(folder / FRAMES_FILE, shape)
        if by_mapper:
            _check_array(folder / LABELS_FILE, (len(plan.poses), 3))
        return chunks_done(folder)
    folder.mkdir(parents=True, exist_ok=True)
    _check_room(folder, int(np.prod(shape)))
    _write_progress(folder, set())
    for name, array in ((POSES_FILE, plan.poses), (KINDS_FILE, plan.kinds), (SPLITS_FILE, plan.splits)):
        content = BytesIO()
        np.save(content, array, allow_pickle=False)
        write_whole(folder / name, content.getvalue())
    np.lib.format.open_memmap(folder / FRAMES_FILE, mode="w+", dtype=np.uint8, shape=shape)
    if by_mapper:
        labels = np.lib.format.open_memmap(
            folder / LABELS_FILE, mode="w+", dtype=np.float32, shape=(len(plan.poses), 3)
        )
        labels[:] = np.nan
    write_whole(path, json.dumps(meta, indent=2) + "\n")
    return set()


def _check_room(folder: Path, wanted_bytes: int) -> None:
    """Make sure that the frames fit on the disk: a memory-mapped file that does not ends the program without a word.

    Raises:
        TwonavError: They do not.
    """
    free_bytes = shutil.disk_usage(folder).free
    if free_bytes < wanted_bytes:
        raise TwonavError(
            f"the frames need {wanted_bytes / 1e9:.1f} GB and {folder} has {free_bytes / 1e9:.1f} GB left: "
            "make room, or set TWONAV_RUNS to another folder"
        )


def _check_array(path: Path, shape: tuple[int, ...]) -> None:
    """Make sure that a memory-mapped file is there in its whole size.

    Raises:
        TwonavError: It is missing, cut off, or of another shape.
    """
    try:
        found = np.lib.format.open_memmap(path, mode="r").shape
    except (OSError, ValueError, EOFError):
        found = ()
    if found != shape:
        raise TwonavError(f"{path} is missing or damaged: delete {path.parent} and collect again")


def _write_progress(folder: Path, done: Iterable[int]) -> None:
    """Write which chunks are there, as ranges from the first to the one after the last."""
    ranges: list[list[int]] = []
    for number in sorted(done):
        if ranges and ranges[-1][1] == number:
            ranges[-1][1] += 1
        else:
            ranges.append([number, number + 1])
    write_whole(folder / PROGRESS_FILE, json.dumps({"chunks": ranges}) + "\n")


def _read_json(path: Path) -> Any:
    try:
        return json.loads(path.read_text())
    except ValueError:
        return None
