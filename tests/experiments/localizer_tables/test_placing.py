"""Poses of a selection: worked out portion by portion, kept, and worked out again only for something else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from made_up_localizers import grid_store, random_store

from twonav_cli.dataset.store import FrameStore, Indices
from twonav_cli.experiments.localizer_tables.placing import Locator, errors_at, nearest_locator, placed
from twonav_cli.worker_pool import StoppedError

SHIFT_M = 0.25


class Shifted:
    """Gives every frame a pose a quarter of a metre to the right of the true one, and counts."""

    def __init__(self) -> None:
        self.portions: list[int] = []

    def __call__(self, store: FrameStore, frames: Indices) -> np.ndarray:
        self.portions.append(len(frames))
        return store.poses[frames].astype(np.float64) + np.array([SHIFT_M, 0.0, 0.0])


def never() -> bool:
    return False


def test_poses_come_in_portions_in_the_order_of_the_frames(tmp_path: Path) -> None:
    store, place, told = grid_store("kitchen"), Shifted(), []
    frames = store.paper_test()
    poses = placed(Locator("a", place, 10), (store, frames), tmp_path / "poses", never, told.append)
    assert place.portions == [10, 10, 10, 6]
    assert told == [10, 20, 30, 36, 36]
    np.testing.assert_allclose(poses[:, 0], store.poses[frames, 0] + SHIFT_M)
    errors = errors_at(poses, (store, frames))
    assert errors["n"] == 36
    assert errors["pos_mean_m"] == pytest.approx(SHIFT_M)
    assert errors["ang_mean_deg"] == pytest.approx(0.0)


def test_poses_are_kept_for_the_same_locator_and_frames_only(tmp_path: Path) -> None:
    store, place, file = grid_store("kitchen"), Shifted(), tmp_path / "deep" / "poses"
    selection = (store, store.paper_test())
    first = placed(Locator("a", place, 100), selection, file, never)
    again = placed(Locator("a", place, 100), selection, file, never)
    np.testing.assert_array_equal(first, again)
    assert place.portions == [36]
    placed(Locator("b", place, 100), selection, file, never)
    placed(Locator("b", place, 100), (store, store.paper_test()[:30]), file, never)
    other = grid_store("apartment")
    placed(Locator("b", place, 100), (other, other.paper_test()[:30]), file, never)
    assert place.portions == [36, 36, 30, 30]


def test_a_damaged_file_is_written_anew(tmp_path: Path) -> None:
    store, place, file = grid_store("kitchen"), Shifted(), tmp_path / "poses"
    file.write_bytes(b"no safetensors")
    for _ in range(2):
        assert len(placed(Locator("a", place, 100), (store, store.paper_test()), file, never)) == 36
    assert place.portions == [36]


def test_stopping_keeps_nothing_half_done(tmp_path: Path) -> None:
    store, place, file = grid_store("kitchen"), Shifted(), tmp_path / "poses"
    with pytest.raises(StoppedError):
        placed(Locator("a", place, 10), (store, store.paper_test()), file, lambda: len(place.portions) == 2)
    assert place.portions == [10, 10]
    assert not file.exists()


def test_the_most_alike_frame_is_the_training_frame_itself_where_it_is_asked_for(tmp_path: Path) -> None:
    store = grid_store("kitchen")
    training = store.training()
    poses = placed(nearest_locator((store, training)), (store, training), tmp_path / "poses", never)
    np.testing.assert_array_equal(poses, store.labels[training])


def test_the_most_alike_frame_of_another_store_is_near(tmp_path: Path) -> None:
    grid, random = grid_store("kitchen"), random_store("kitchen")
    selection = (random, random.off_grid())
    nearest = placed(nearest_locator((grid, grid.training())), selection, tmp_path / "poses", never)
    far = np.broadcast_to(grid.poses.mean(axis=0), nearest.shape).astype(np.float32)
    assert errors_at(nearest, selection)["pos_mean_m"] < errors_at(far, selection)["pos_mean_m"]
