"""Where frames are taken: the paper's cells at every degree, and random poses anywhere the robot fits.

N poses (x_m, y_m, theta_rad) in the map frame; P points; R, C rows and columns of the 5 cm map.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import (
    FRAME_SPACING_M,
    ROBOT_CIRCUMSCRIBED_M,
    ROBOT_FOOTPRINT_M,
    ROBOT_INSCRIBED_M,
)
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame

BoolGrid = NDArray[np.bool_]
FloatArray = NDArray[np.float64]

DEGREES = 360
TRAIN, VALIDATION, TEST = 0, 1, 2
"""Labels of the paper's split."""

_SECTION = np.array([TRAIN] * 5 + [VALIDATION] * 2 + [TEST] * 3, dtype=np.uint8)
_PROPOSALS = 4096


def clearance_m(occupied: BoolGrid, frame: GridFrame) -> FloatArray:
    """Return the distance from every pixel's centre to the nearest occupied pixel or map border [R, C], metres."""
    from scipy.ndimage import distance_transform_edt

    walled = np.pad(occupied, 1, constant_values=True)
    pixels = distance_transform_edt(~walled)[1:-1, 1:-1]
    return np.asarray(np.maximum(pixels - 0.5, 0.0) * frame.resolution_m)


def reachable_floor(occupied: BoolGrid, frame: GridFrame, seeds: Sequence[Pose]) -> BoolGrid:
    """Return the pixels [R, C] where the axle may be and which are connected to where the robot starts.

    Args:
        occupied: [R, C] pixels that hold an obstacle.
        frame: Where the map lies.
        seeds: Poses the robot can be at, for example the scene's starts.

    Raises:
        TwonavError: The robot fits at none of the seeds.
    """
    from scipy.ndimage import label

    regions, _ = label(clearance_m(occupied, frame) >= ROBOT_INSCRIBED_M)
    wanted = {int(regions[frame.cell_at(seed.x_m, seed.y_m)]) for seed in seeds} - {0}
    if not wanted:
        raise TwonavError("the robot fits at none of the scene's starts: move them away from the obstacles")
    return np.asarray(np.isin(regions, list(wanted)))


def cell_centres(occupied: BoolGrid, frame: GridFrame, seeds: Sequence[Pose]) -> FloatArray:
    """Return the centres [K, 2] of the 25 cm cells where the robot fits at any heading and can go (§4.1)."""
    fits = clearance_m(occupied, frame) >= ROBOT_CIRCUMSCRIBED_M
    fits &= reachable_floor(occupied, frame, seeds)
    xs_m, ys_m = frame.coarser(FRAME_SPACING_M).centres()
    x_m, y_m = (axis.ravel() for axis in np.meshgrid(xs_m, ys_m))
    good = _looked_up(fits, frame, x_m, y_m)
    return np.stack([x_m[good], y_m[good]], axis=1)


def grid_poses(centres: FloatArray, degree_step: int = 1) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return the poses on the cells' centres (§4.1), and the (cell, degree) of each.

    Args:
        centres: [K, 2] metres.
        degree_step: 1 takes every degree (the paper); n takes every n-th, shifted from cell to cell (ours).

    Returns:
        Poses [N, 3] and the index of their cell and degree [N, 2].
    """
    cells, degrees = np.meshgrid(np.arange(len(centres)), np.arange(DEGREES), indexing="ij")
    taken = (degrees + cells) % degree_step == 0
    pairs = np.stack([cells[taken], degrees[taken]], axis=1)
    theta_rad = (np.deg2rad(pairs[:, 1]) + np.pi) % (2 * np.pi) - np.pi
    return np.column_stack([centres[pairs[:, 0]], theta_rad]), pairs


def paper_split(cell_count: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """Return the label [K, 360] of every image: of ten in 10 degrees 5 train, 2 validate, 3 test (§4.1)."""
    sections = np.broadcast_to(_SECTION, (cell_count, DEGREES // len(_SECTION), len(_SECTION)))
    return np.asarray(rng.permuted(sections, axis=2).reshape(cell_count, DEGREES))


def held_out_cells(count: int, share: float, rng: np.random.Generator) -> BoolGrid:
    """Return which of the cells [count] are kept out of every training: a share of them, at least one (ours)."""
    held = np.zeros(count, dtype=bool)
    held[rng.permutation(count)[: max(1, round(share * count))]] = True
    return held


def in_cells(poses: FloatArray, centres: FloatArray) -> BoolGrid:
    """Return which poses [N, 3] lie in one of the 25 cm cells with centres [K, 2]."""
    if not len(centres):
        return np.zeros(len(poses), dtype=bool)
    found = np.zeros(len(poses), dtype=bool)
    for x_m, y_m in centres:
        found |= (np.abs(poses[:, 0] - x_m) <= FRAME_SPACING_M / 2) & (np.abs(poses[:, 1] - y_m) <= FRAME_SPACING_M / 2)
    return found


def footprint_points(spacing_m: float = 0.025) -> FloatArray:
    """Return points [P, 2] that cover the robot's outline and what is inside it, robot frame."""
    outline = np.array(ROBOT_FOOTPRINT_M)
    following = np.roll(outline, -1, axis=0)
    steps = np.arange(0.0, 1.0, 0.05)[:, None, None]
    border = (outline + steps * (following - outline)).reshape(-1, 2)
    low, high = outline.min(axis=0), outline.max(axis=0)
    xs, ys = (np.arange(a, b, spacing_m) for a, b in zip(low, high, strict=True))
    inner = np.stack([axis.ravel() for axis in np.meshgrid(xs, ys)], axis=1)
    edges, offsets = following - outline, inner[:, None] - outline
    sides = edges[:, 1] * offsets[..., 0] - edges[:, 0] * offsets[..., 1]
    return np.concatenate([border, inner[_all_of_one_sign(sides)]])


def fits(occupied: BoolGrid, frame: GridFrame, poses: FloatArray) -> BoolGrid:
    """Return whether the footprint polygon touches no occupied pixel, for poses [N, 3]."""
    points = footprint_points()
    cos, sin = np.cos(poses[:, 2:3]), np.sin(poses[:, 2:3])
    x_m = poses[:, 0:1] + cos * points[:, 0] - sin * points[:, 1]
    y_m = poses[:, 1:2] + sin * points[:, 0] + cos * points[:, 1]
    return np.asarray(_looked_up(~occupied, frame, x_m, y_m).all(axis=1))


def random_poses(
    occupied: BoolGrid, frame: GridFrame, seeds: Sequence[Pose], count: int, rng: np.random.Generator
) -> FloatArray:
    """Return poses [count, 3] drawn uniformly from those at which the footprint fits and that can be reached (ours).

    Raises:
        TwonavError: The robot fits at none of the seeds.
    """
    rows, cols = np.nonzero(reachable_floor(occupied, frame, seeds))
    xs_m, ys_m = frame.centres()
    kept: list[FloatArray] = []
    while sum(map(len, kept)) < count:
        picked = rng.integers(len(rows), size=_PROPOSALS)
        shift_m = rng.uniform(-0.5, 0.5, size=(2, _PROPOSALS)) * frame.resolution_m
        theta_rad = rng.uniform(-np.pi, np.pi, size=_PROPOSALS)
        x_m, y_m = xs_m[cols[picked]] + shift_m[0], ys_m[rows[picked]] + shift_m[1]
        poses = np.column_stack([x_m, y_m, theta_rad])
        kept.append(poses[fits(occupied, frame, poses)])
    return np.concatenate(kept)[:count] if kept else np.zeros((0, 3))


def _all_of_one_sign(sides: FloatArray) -> BoolGrid:
    return np.asarray((sides >= 0).all(axis=1) | (sides <= 0).all(axis=1))


def _looked_up(grid: BoolGrid, frame: GridFrame, x_m: FloatArray, y_m: FloatArray) -> BoolGrid:
    """Return the grid's value at many points of any shape; False outside."""
    rows, cols, inside = frame.cells_at(x_m, y_m)
    return np.asarray(inside & grid[rows, cols])
