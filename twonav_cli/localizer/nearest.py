"""The row beside every localizer: the pose of the most alike training frame, without any learning (ours).

N training frames, Q pictures to place, D = 432 numbers of a thumbnail.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import IMAGE_PX
from twonav_cli.dataset.store import FrameStore, Indices

THUMBNAIL_PX = 12
_PORTION = 2000


def thumbnails(store: FrameStore, indices: Indices) -> NDArray[np.float32]:
    """Return frames as 12 x 12 means of blocks, flattened [len(indices), D]."""
    block = IMAGE_PX // THUMBNAIL_PX
    parts = []
    for start in range(0, len(indices), _PORTION):
        images = store.frames[indices[start : start + _PORTION]]
        blocks = images.reshape(len(images), THUMBNAIL_PX, block, THUMBNAIL_PX, block, 3)
        rows = blocks.sum(axis=2, dtype=np.uint16)
        parts.append(rows.sum(axis=3, dtype=np.float32).reshape(len(images), -1) / block**2)
    return np.concatenate(parts)


def nearest_poses(
    store: FrameStore, training: Indices, queries: Indices, queried: FrameStore | None = None
) -> NDArray[np.float32]:
    """Return the labels [Q, 3] of the training frames whose thumbnails differ least, by squared difference.

    Args:
        store: Holds the training frames.
        training: Which frames are known.
        queries: Which frames are to be placed.
        queried: Holds the frames to place; None if they are in the same store.
    """
    best = np.full(len(queries), np.inf, dtype=np.float32)
    chosen = np.zeros(len(queries), dtype=np.int64)
    wanted = thumbnails(store if queried is None else queried, queries)
    for start in range(0, len(training), _PORTION):
        part = training[start : start + _PORTION]
        known = thumbnails(store, part)
        # |a - b|^2 without |a|^2, which is the same for every candidate.
        difference = np.square(known).sum(axis=1) - 2.0 * wanted @ known.T
        nearest = difference.argmin(axis=1)
        value = difference[np.arange(len(queries)), nearest]
        better = value < best
        best[better], chosen[better] = value[better], part[nearest[better]]
    return store.labels[chosen]
