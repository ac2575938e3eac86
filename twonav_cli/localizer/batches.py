"""The frames of each batch, read from the disk while the one before is learned from.

B batch, N frames.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from twonav_cli.dataset.store import FrameStore, Indices
from twonav_cli.rng import stream

Selection = tuple[FrameStore, Indices]
"""Some frames of a store."""

Batch = tuple[NDArray[np.uint8], NDArray[np.float32]]
"""Images [B, 84, 84, 3] and labels [B, 3]."""


def pass_order(round_: int, frames: Indices, seed: int) -> Indices:
    """Return the frames [N] in the order in which a pass over them shows them."""
    return np.asarray(stream(seed, "batches", round_).permutation(frames))


def batch_indices(start: int, stop: int, frames: Indices, batch: int, seed: int) -> Iterator[Indices]:
    """Yield the frames [B] of the batches from `start` on; a batch's number alone fixes them."""
    per_pass = len(frames) // batch
    order, shown = frames, -1
    for step in range(start, stop):
        if step // per_pass != shown:
            shown = step // per_pass
            order = pass_order(shown, frames, seed)
        first = (step % per_pass) * batch
        yield order[first : first + batch]


def batches(selection: Selection, start: int, stop: int, batch: int, seed: int) -> Generator[Batch]:
    """Yield the batches from `start` on, each read while the one before is in use."""
    store, frames = selection
    with ThreadPoolExecutor(1) as reader:
        waiting = None
        for indices in batch_indices(start, stop, frames, batch, seed):
            following = reader.submit(store.batch, indices)
            if waiting is not None:
                yield waiting.result()
            waiting = following
        if waiting is not None:
            yield waiting.result()
