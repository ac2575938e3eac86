"""The paths of all particles as one tree: who came from whom, and where each was at every keyframe."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from twonav_cli.geometry import FloatArray


class PathTree:
    """Poses of P particles at K keyframes, and the particle of the keyframe before that each one goes on from."""

    def __init__(self, particles: int) -> None:
        self._stamps_s: list[float] = []
        self._poses: list[FloatArray] = []
        self._parents: list[NDArray[np.int64]] = []
        self._next_parents = np.arange(particles)

    @property
    def latest_s(self) -> float:
        """Stamp of the latest keyframe."""
        return self._stamps_s[-1] if self._stamps_s else 0.0

    def grow(self, stamp_s: float, poses: FloatArray) -> None:
        """Note where every particle [P, 3] is at a keyframe."""
        self._stamps_s.append(stamp_s)
        self._poses.append(poses.copy())
        self._parents.append(self._next_parents)
        self._next_parents = np.arange(len(poses))

    def draw_again(self, parents: NDArray[np.int64]) -> None:
        """Let particle i go on from particle `parents[i]`."""
        self._next_parents = self._next_parents[parents]

    def path_of(self, particle: int) -> tuple[list[float], FloatArray]:
        """Return the stamps [K] and the poses [K, 3] of the path that a particle of now has come."""
        path = np.zeros((len(self._poses), 3))
        at = int(self._next_parents[particle])
        for k in range(len(self._poses) - 1, -1, -1):
            path[k] = self._poses[k][at]
            at = int(self._parents[k][at])
        return list(self._stamps_s), path
