"""Made-up frames, errors and reports of localizers: what the tests of their tables, pictures and printing use."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

from twonav_cli.dataset.plan import GRID, HELD_CELL, HELD_OUT, RANDOM
from twonav_cli.dataset.poses import TEST, TRAIN, VALIDATION
from twonav_cli.dataset.store import FrameStore
from twonav_cli.experiments.localizer_tables.error_map import ErrorMapReport, error_map, error_map_report
from twonav_cli.experiments.localizer_tables.report import (
    BELIEF,
    HELD_CELLS,
    NEAREST,
    OFF_GRID,
    PAPER_SPLIT,
    Figures,
    LocalizerReport,
    belief_row,
    nearest_row,
    table_report,
    trained_row,
)
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.paths import runs_dir

ROWS, COLS, HEADINGS = 3, 4, 10
FIRST_M = (0.625, 0.875)
"""Centre of the lowest cell on the left."""

FRAME = GridFrame(0.0, 0.0, 0.05, 40, 60)


def made_up_floor(scene: str) -> Any:
    """Return a room of 3 x 2 m with a wall around it, in place of a scene's floor."""
    occupied = np.ones(FRAME.shape, dtype=bool)
    occupied[1:-1, 1:-1] = False
    return SimpleNamespace(
        scene=SimpleNamespace(name=scene, digest=f"digest of {scene}", starts={}),
        map=OccupancyMap.from_occupied(occupied, FRAME),
        map_source="geometry",
        outdated=None,
    )


def cell_poses() -> np.ndarray:
    """Return ten headings at the centre of each of twelve cells, cell by cell [120, 3]."""
    xs, ys = FIRST_M[0] + 0.25 * np.arange(COLS), FIRST_M[1] + 0.25 * np.arange(ROWS)
    headings = np.linspace(-3.0, 3.0, HEADINGS)
    return np.array([(x, y, theta) for y in ys for x in xs for theta in headings], dtype=np.float32)


def grid_store(scene: str) -> FrameStore:
    """Return frames of the paper's kind; of ten of a cell 5 train, 2 validate, 3 test."""
    poses = cell_poses()
    splits = np.resize(np.array([TRAIN] * 5 + [VALIDATION] * 2 + [TEST] * 3, dtype=np.uint8), len(poses))
    return _store(scene, poses, np.full(len(poses), GRID, dtype=np.uint8), splits)


def random_store(scene: str) -> FrameStore:
    """Return 30 random frames to train on, 20 that are held out and 10 in held-out cells."""
    poses = np.random.default_rng(1).uniform((0.5, 0.5, -3.0), (2.5, 1.5, 3.0), size=(60, 3)).astype(np.float32)
    kinds = np.repeat(np.array([RANDOM, HELD_OUT, HELD_CELL], dtype=np.uint8), (30, 20, 10))
    return _store(scene, poses, kinds, np.where(kinds == RANDOM, TRAIN, TEST).astype(np.uint8))


def _store(scene: str, poses: np.ndarray, kinds: np.ndarray, splits: np.ndarray) -> FrameStore:
    noise = np.random.default_rng(0).integers(0, 40, size=(len(poses), 84, 84, 3))
    shade = np.column_stack([80 * poses[:, 0], 100 * poses[:, 1], 30 * (poses[:, 2] + 3.2)]).clip(0, 215)
    frames = (noise + shade[:, None, None, :]).astype(np.uint8)
    meta = {"scene": scene, "scene_digest": f"digest of {scene}", "seed": 0, "frames": len(poses), "plan": scene}
    meta["map_digest"] = made_up_floor(scene).map.digest
    return FrameStore(frames, poses, poses, kinds, splits, meta)


def made_up_errors(mean_m: float, mean_deg: float) -> Figures:
    """Return `error_metrics` whose figures are multiples of the means."""
    factors = {"mean": 1.0, "std": 1.5, "median": 0.6, "p95": 3.0, "p99": 7.0}
    position = {f"pos_{name}_m": mean_m * factor for name, factor in factors.items()}
    angle = {f"ang_{name}_deg": mean_deg * factor for name, factor in factors.items()}
    return {"n": 100, **position, **angle, "within_5cm_5deg": 0.5, "within_25cm_2deg": 0.4}


def made_up_card(mean_m: float, images: int = 600_000) -> dict[str, Any]:
    """Return the card of a network that errs so much on the split, twice as much off it, thrice in held-out cells."""
    factors = {PAPER_SPLIT: 1.0, OFF_GRID: 2.0, HELD_CELLS: 3.0}
    metrics = {name: made_up_errors(factor * mean_m, factor * 40 * mean_m) for name, factor in factors.items()}
    return {
        "metrics": {**metrics, "labels": {"by": "simulator"}},
        "settings": {"images": images, "pretraining_images": 0, "training_frames": 12_000},
        "training": {
            "seconds": 1234.5, "pictures_per_s": 486.0, "device": "NVIDIA H100 80GB HBM3", "precision": "bfloat16",
            "parameters": 1_000_000,
        },
    }  # fmt: skip


def scenes_of(request: LocalizerRequest, notes: tuple[str, ...] = ()) -> Figures:
    counts = {"training": 12_000, PAPER_SPLIT: 7_200, OFF_GRID: 4_000, HELD_CELLS: 72, "labels": "mapper"}
    return {scene: {"map": "survey", "frames": counts, "notes": list(notes)} for scene in request.rows()}


def made_up_report(table: str, missing: tuple[str, ...] = (), notes: tuple[str, ...] = ()) -> LocalizerReport:
    """Return Table 3 or 4; each network errs by a hundredth more than the one before, those that are missing not."""
    request, rows = LocalizerRequest(table), []
    for scene, networks in request.rows().items():
        for number, network in enumerate(networks, start=1):
            card = None if network in missing else made_up_card(0.05 + 0.01 * number)
            rows.append(trained_row(scene, network, card, runs_dir() / network))
        errors = made_up_card(0.03)["metrics"]
        rows.append(belief_row(scene, errors, made_up_card(0.03, 800_000), runs_dir() / BELIEF))
        rows.append(nearest_row(scene, made_up_card(0.04)["metrics"]))
    return table_report(request, rows, scenes_of(request, notes))


def made_up_maps(missing: tuple[str, ...] = ()) -> ErrorMapReport:
    """Return Fig. 7 with maps in which the error grows from cell to cell, the more the worse the network."""
    request, maps, poses = LocalizerRequest("fig7"), [], cell_poses()
    names = [name for name in ("sda-3x4000", "inception-9", BELIEF, NEAREST) if name not in missing]
    for factor, name in zip((1.0, 0.3, 0.1, 0.5), names, strict=False):
        errors_m = factor * (0.1 + 0.01 * (np.arange(len(poses)) // HEADINGS))
        maps.append(error_map("apartment", name, errors_m, poses, None))
    return error_map_report(request, "apartment", maps, list(missing), scenes_of(request))
