"""Plans and cameras for tests: a frame's picture is as bright as its number."""

from __future__ import annotations

import numpy as np

from twonav_cli.dataset.plan import GRID, HELD_OUT, RANDOM, FramePlan
from twonav_cli.dataset.poses import TEST, TRAIN, VALIDATION


def toy_plan(count: int = 10, chunk: int = 4) -> FramePlan:
    """Return frames at x = 0, 1, 2 ...: on the grid but for the last two, random and held out."""
    poses = np.zeros((count, 3), dtype=np.float32)
    poses[:, 0] = np.arange(count)
    kinds = np.full(count, GRID, dtype=np.uint8)
    splits = np.resize(np.array([TRAIN, TEST, VALIDATION], dtype=np.uint8), count)
    kinds[-2], splits[-2] = RANDOM, TRAIN
    kinds[-1], splits[-1] = HELD_OUT, TEST
    firsts = np.arange(0, count, chunk)
    chunks = np.stack([firsts, np.minimum(firsts + chunk, count)], axis=1)
    return FramePlan(poses, kinds, splits, chunks, tuple(np.zeros((0, 2)) for _ in firsts))


class ToyCamera:
    """Implements `Taker`; with labels a tenth to the right, and nobody knows where frame 2 was taken."""

    def __init__(self, labelled: bool = False, size_px: int = 84) -> None:
        self.labelled = labelled
        self.size_px = size_px
        self.taken: list[int] = []
        self.closed = False

    def __call__(self) -> ToyCamera:
        """Be one's own maker."""
        return self

    def take(self, plan: FramePlan, chunk: int) -> tuple[np.ndarray, np.ndarray | None]:
        self.taken.append(chunk)
        poses = plan.poses[slice(*plan.chunks[chunk])]
        bright = poses[:, 0].astype(np.uint8)[:, None, None, None]
        images = np.broadcast_to(bright, (len(poses), self.size_px, self.size_px, 3)).copy()
        if not self.labelled:
            return images, None
        labels = poses + np.array([0.1, 0.0, 0.0], dtype=np.float32)
        labels[poses[:, 0] == 2] = np.nan
        return images, labels

    def close(self) -> None:
        self.closed = True
