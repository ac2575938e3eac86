"""Reading a data set: memory-mapped frames with their poses, checked before they are used.

N frames, B batch.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.dataset.collect import (
    FORMAT,
    FRAMES_FILE,
    IMAGE_SHAPE,
    KINDS_FILE,
    LABELS_FILE,
    META_FILE,
    POSES_FILE,
    SIMULATOR,
    SPLITS_FILE,
    chunks_done,
)
from twonav_cli.dataset.plan import GRID, HELD_CELL, HELD_OUT, RANDOM
from twonav_cli.dataset.poses import TEST, TRAIN, VALIDATION
from twonav_cli.errors import TwonavError

Indices = NDArray[np.int64]


@dataclass(frozen=True)
class FrameStore:
    """Frames, where each was taken and what each is for.

    Attributes:
        frames: [N, 84, 84, 3] uint8 RGB, memory-mapped, read only.
        poses: [N, 3] float32, where the robot stood, map frame; only what is measured is measured against them.
        labels: [N, 3] float32, where it is said to have stood: what is learned from; not a number where nobody knew.
        kinds: [N] uint8: GRID, RANDOM, HELD_OUT or HELD_CELL.
        splits: [N] uint8: TRAIN, VALIDATION or TEST.
        meta: Scene, digest, seed and render settings.
    """

    frames: NDArray[np.uint8]
    poses: NDArray[np.float32]
    labels: NDArray[np.float32]
    kinds: NDArray[np.uint8]
    splits: NDArray[np.uint8]
    meta: dict[str, Any]

    def __len__(self) -> int:
        return len(self.poses)

    def training(self) -> Indices:
        """Return the labelled frames to learn from: the paper's training half of the grid, or the random ones."""
        return np.flatnonzero(np.isin(self.kinds, (GRID, RANDOM)) & (self.splits == TRAIN) & self.labelled())

    def labelled(self) -> NDArray[np.bool_]:
        """Return which frames [N] have a label."""
        return np.asarray(np.isfinite(self.labels).all(axis=1))

    def off_grid(self) -> Indices:
        """Return the held-out frames at random poses."""
        return np.flatnonzero(self.kinds == HELD_OUT)

    def held_cells(self) -> Indices:
        """Return the frames in whole cells that no training has seen."""
        return np.flatnonzero(self.kinds == HELD_CELL)

    def validation(self) -> Indices:
        """Return the labelled frames to choose and to calibrate by: of the paper's split (§4.1), or random ones."""
        return np.flatnonzero(np.isin(self.kinds, (GRID, RANDOM)) & (self.splits == VALIDATION) & self.labelled())

    def paper_test(self) -> Indices:
        """Return the test frames of the paper's split: on the grid, beside training frames (§4.1)."""
        return np.flatnonzero((self.kinds == GRID) & (self.splits == TEST))

    def batch(self, indices: Indices) -> tuple[NDArray[np.uint8], NDArray[np.float32]]:
        """Return copies of the images [B, 84, 84, 3] and labels [B, 3] of some frames [B], in the order asked for.

        They are read in the order in which they lie on the disk. Neighbours on the disk are neighbours in the scene: a
        batch in that order would not be mixed, and each half of it would be normalised by another half of the scene.
        """
        order = np.argsort(indices, kind="stable")
        images = np.empty((len(indices), *self.frames.shape[1:]), dtype=self.frames.dtype)
        images[order] = self.frames[indices[order]]
        return images, self.labels[indices]


def open_store(folder: Path, scene_digest: str | None = None) -> FrameStore:
    """Open a finished data set.

    Args:
        folder: Where it is.
        scene_digest: The scene it must show, unless None.

    Raises:
        TwonavError: Missing, half-written, damaged, or of another scene.
    """
    meta = _meta_of(folder)
    count = meta["frames"]
    if scene_digest is not None and meta.get("scene_digest") != scene_digest:
        raise TwonavError(
            f"the frames in {folder} show another scene or another version of it "
            f"({meta.get('scene', 'unknown')}): collect them again for this one"
        )
    done, wanted = len(chunks_done(folder)), meta.get("chunks")
    if done != wanted:
        raise TwonavError(f"only {done} of {wanted} chunks of frames are in {folder}: collect again to go on")
    poses = _array(folder / POSES_FILE, np.float32, (count, 3))
    by_mapper = meta.get("labels", SIMULATOR) != SIMULATOR
    return FrameStore(
        _array(folder / FRAMES_FILE, np.uint8, (count, *IMAGE_SHAPE), mapped=True),
        poses,
        _array(folder / LABELS_FILE, np.float32, (count, 3)) if by_mapper else poses,
        _array(folder / KINDS_FILE, np.uint8, (count,)),
        _array(folder / SPLITS_FILE, np.uint8, (count,)),
        meta,
    )


def _meta_of(folder: Path) -> dict[str, Any]:
    try:
        meta = json.loads((folder / META_FILE).read_text())
    except FileNotFoundError:
        raise TwonavError(f"there are no frames in {folder}: collect them first") from None
    except (OSError, ValueError) as error:
        raise TwonavError(f"{folder / META_FILE} cannot be read: delete {folder} and collect again") from error
    if not isinstance(meta, dict) or meta.get("format") != FORMAT or not isinstance(meta.get("frames"), int):
        raise TwonavError(f"{folder} holds no frames of this version of twonav: delete it and collect again")
    return meta


def _array(path: Path, dtype: Any, shape: tuple[int, ...], mapped: bool = False) -> NDArray[Any]:
    """Return an array of a .npy file; nothing is unpickled."""
    try:
        array = np.load(path, mmap_mode="r" if mapped else None, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise TwonavError(f"{path} is missing or damaged: delete {path.parent} and collect again") from error
    if array.dtype != dtype or array.shape != shape:
        raise TwonavError(f"{path} has the wrong size: delete {path.parent} and collect again")
    return np.asarray(array) if not mapped else array
