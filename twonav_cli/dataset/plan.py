"""Which frames a data set holds, in which order, and what each is for.

N frames.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twonav_cli.dataset import poses as places
from twonav_cli.files import digest_of
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.rng import stream

GRID, RANDOM, HELD_OUT = 0, 1, 2
"""Kinds of frames: on the 25 cm grid, at random poses for training, at random poses never trained on."""


@dataclass(frozen=True)
class PlanConfig:
    """How many frames of each kind."""

    degree_step: int = field(
        default=4, metadata={"help": "On the grid, every how many degrees a frame is taken (§4.1: 1; 4 is ours)."}
    )
    random_frames: int = field(default=70_000, metadata={"help": "Frames at random poses to train on (ours)."})
    held_out_frames: int = field(default=4_000, metadata={"help": "Frames at random poses to test on (ours)."})


@dataclass(frozen=True)
class FramePlan:
    """Every frame to take.

    Attributes:
        poses: [N, 3] float32, map frame.
        kinds: [N] uint8: GRID, RANDOM or HELD_OUT.
        splits: [N] uint8: the paper's label of grid frames; TRAIN for random ones, TEST for held-out ones.
    """

    poses: NDArray[np.float32]
    kinds: NDArray[np.uint8]
    splits: NDArray[np.uint8]

    @property
    def digest(self) -> str:
        """Digest of all poses, kinds and labels in order."""
        return digest_of([self.poses.tobytes(), self.kinds.tobytes(), self.splits.tobytes()])


def plan_frames(
    occupied: NDArray[np.bool_],
    frame: GridFrame,
    seeds: Sequence[Pose],
    config: PlanConfig,
    seed: int,
) -> FramePlan:
    """Choose the poses of a data set.

    Args:
        occupied: [R, C] pixels of the map that are not free: what is unknown is left out as well (§4.1).
        frame: Where the map lies.
        seeds: Poses the robot can be at, for example the scene's starts.
        config: How many frames.
        seed: Seed of the run; held-out poses, training poses and the split have streams of their own.

    Raises:
        TwonavError: The robot fits at none of the seeds.
    """
    centres = places.cell_centres(occupied, frame, seeds)
    on_grid, pairs = places.grid_poses(centres, config.degree_step)
    labels = places.paper_split(len(centres), stream(seed, "split"))[pairs[:, 0], pairs[:, 1]]
    trained = places.random_poses(occupied, frame, seeds, config.random_frames, stream(seed, "poses"))
    tested = places.random_poses(occupied, frame, seeds, config.held_out_frames, stream(seed, "held out"))
    counts = [len(on_grid), len(trained), len(tested)]
    return FramePlan(
        np.concatenate([on_grid, trained, tested]).astype(np.float32),
        np.repeat(np.array([GRID, RANDOM, HELD_OUT], dtype=np.uint8), counts),
        np.concatenate([labels, np.full(len(trained), places.TRAIN), np.full(len(tested), places.TEST)]).astype(
            np.uint8
        ),
    )
