"""Which frames a data set holds, in which order, and what each is for.

There are two: the paper's, on its grid of cells, and ours, at random poses. N frames, V chunks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from twonav_cli.dataset import poses as places
from twonav_cli.dataset.tour import tour
from twonav_cli.files import digest_of
from twonav_cli.geometry import FloatArray, Pose
from twonav_cli.grid import GridFrame
from twonav_cli.rng import stream

GRID, RANDOM, HELD_OUT, HELD_CELL = 0, 1, 2, 3
"""Kinds of frames: on the paper's grid; at random poses to train on; at random poses never trained on; in whole cells
that no training has seen."""

GRID_SET, RANDOM_SET = "grid", "random"
SETS = (GRID_SET, RANDOM_SET)
"""The two data sets of a scene."""

CHUNK = 500
"""Random frames between two marks of progress: a second or two is lost by a kill."""

VALIDATION_SHARE = 0.01
"""Share of the random frames that are for choosing and calibrating, not for learning (ours)."""

HELD_CELL_DEGREES = 10
"""In a cell that is held out, every how many degrees a frame is taken."""


@dataclass(frozen=True)
class PlanConfig:
    """How many frames of each kind."""

    degree_step: int = field(
        default=1, metadata={"help": "On the grid, every how many degrees a frame is taken (§4.1)."}
    )
    random_frames: int = field(default=250_000, metadata={"help": "Frames at random poses to train on (ours)."})
    held_out_frames: int = field(default=4_000, metadata={"help": "Frames at random poses to test on (ours)."})
    held_out_cells: float = field(default=0.02, metadata={"help": "Share of the cells that no training sees (ours)."})


@dataclass(frozen=True)
class FramePlan:
    """Every frame to take.

    Attributes:
        poses: [N, 3] float32, map frame.
        kinds: [N] uint8: GRID, RANDOM, HELD_OUT or HELD_CELL.
        splits: [N] uint8: the paper's label of grid frames; TRAIN or VALIDATION for random ones, else TEST.
        chunks: [V, 2] first frame and the one after the last of each piece of work; none depends on another.
        ways: For each chunk the points [W, 2] on which the robot comes to it; empty where it is set down anew.
    """

    poses: NDArray[np.float32]
    kinds: NDArray[np.uint8]
    splits: NDArray[np.uint8]
    chunks: NDArray[np.int64]
    ways: tuple[FloatArray, ...]

    @property
    def digest(self) -> str:
        """Digest of all poses, kinds, labels and ways in order."""
        ways = np.concatenate([np.zeros((0, 2)), *self.ways]).tobytes()
        return digest_of([part.tobytes() for part in (self.poses, self.kinds, self.splits, self.chunks)] + [ways])


def plan_frames(
    name: str,
    occupied: NDArray[np.bool_],
    frame: GridFrame,
    seeds: Sequence[Pose],
    config: PlanConfig,
    seed: int,
) -> FramePlan:
    """Choose the poses of one of the two data sets.

    Args:
        name: A name of SETS.
        occupied: [R, C] pixels of the map that are not free: what is unknown is left out as well (§4.1).
        frame: Where the map lies.
        seeds: Poses the robot can be at, for example the scene's starts.
        config: How many frames.
        seed: Seed of the run; held-out poses, held-out cells, training poses and the split have streams of their own.

    Raises:
        TwonavError: The robot fits at none of the seeds.
    """
    centres = places.cell_centres(occupied, frame, seeds)
    held = places.held_out_cells(len(centres), config.held_out_cells, stream(seed, "held-out cells"))
    if name == GRID_SET:
        floor = places.reachable_floor(occupied, frame, seeds)
        return _grid_plan(floor, frame, centres[~held], config, seed)
    trained = _outside(centres[held], occupied, frame, seeds, config.random_frames, seed)
    tested = places.random_poses(occupied, frame, seeds, config.held_out_frames, stream(seed, "held out"))
    in_held = places.grid_poses(centres[held], HELD_CELL_DEGREES)[0]
    return _random_plan([trained, tested, in_held])


def _grid_plan(
    floor: NDArray[np.bool_], frame: GridFrame, centres: FloatArray, config: PlanConfig, seed: int
) -> FramePlan:
    """Return the paper's frames: every cell on a tour, turning by one degree from frame to frame (§4.1)."""
    order, ways = tour(floor, frame, centres) if len(centres) else (np.zeros(0, dtype=np.int64), [])
    on_grid, pairs = places.grid_poses(centres[order], config.degree_step)
    labels = places.paper_split(len(centres), stream(seed, "split"))[pairs[:, 0], pairs[:, 1]]
    ends = np.cumsum(np.bincount(pairs[:, 0], minlength=len(centres)))
    chunks = np.stack([np.concatenate([[0], ends[:-1]]), ends], axis=1) if len(ends) else np.zeros((0, 2))
    return FramePlan(
        on_grid.astype(np.float32),
        np.full(len(on_grid), GRID, dtype=np.uint8),
        labels.astype(np.uint8),
        chunks.astype(np.int64),
        tuple(ways),
    )


def _random_plan(parts: list[FloatArray]) -> FramePlan:
    """Return the plan of training, held-out and held-out-cell poses, in this order."""
    counts = [len(part) for part in parts]
    splits = np.repeat(np.array([places.TRAIN, places.TEST, places.TEST], dtype=np.uint8), counts)
    splits[counts[0] - round(VALIDATION_SHARE * counts[0]) : counts[0]] = places.VALIDATION
    firsts = np.arange(0, sum(counts), CHUNK)
    chunks = np.stack([firsts, np.minimum(firsts + CHUNK, sum(counts))], axis=1)
    return FramePlan(
        np.concatenate(parts).astype(np.float32),
        np.repeat(np.array([RANDOM, HELD_OUT, HELD_CELL], dtype=np.uint8), counts),
        splits,
        chunks,
        tuple(np.zeros((0, 2)) for _ in firsts),
    )


def _outside(
    held: FloatArray,
    occupied: NDArray[np.bool_],
    frame: GridFrame,
    seeds: Sequence[Pose],
    count: int,
    seed: int,
) -> FloatArray:
    """Return random poses [count, 3] that lie in none of the cells with centres [K, 2]."""
    rng = stream(seed, "poses")
    kept = np.zeros((0, 3))
    while len(kept) < count:
        drawn = places.random_poses(occupied, frame, seeds, count - len(kept), rng)
        kept = np.concatenate([kept, drawn[~places.in_cells(drawn, held)]])
    return kept
