import numpy as np
import pytest

from twonav_cli.dataset.store import FrameStore
from twonav_cli.localizer.batches import batch_indices, batches


def test_a_pass_shows_every_frame_once_and_the_next_in_another_order() -> None:
    frames = np.arange(100, 160)
    first, second = (np.concatenate(list(batch_indices(start, start + 6, frames, 10, seed=3))) for start in (0, 6))
    assert sorted(first) == sorted(second) == frames.tolist()
    assert first.tolist() != second.tolist()


def test_a_batch_depends_on_its_number_alone() -> None:
    frames = np.arange(100, 165)
    whole = list(batch_indices(0, 20, frames, 10, seed=3))
    assert all(np.array_equal(next(batch_indices(k, k + 1, frames, 10, seed=3)), whole[k]) for k in (0, 5, 6, 19))


@pytest.mark.parametrize(("start", "stop"), [(0, 4), (2, 3), (5, 5)])
def test_every_batch_is_read_once_and_in_its_turn(toy_store: FrameStore, start: int, stop: int) -> None:
    frames = toy_store.training()
    read = list(batches((toy_store, frames), start, stop, 30, seed=3))
    assert len(read) == stop - start
    for (images, labels), indices in zip(read, batch_indices(start, stop, frames, 30, seed=3), strict=True):
        assert np.array_equal(images, toy_store.frames[indices])
        assert np.array_equal(labels, toy_store.labels[indices])


def test_the_parts_of_a_batch_are_from_everywhere(toy_store: FrameStore) -> None:
    frames = toy_store.training()
    first, second = (np.array_split(indices, 2) for indices in batch_indices(0, 2, frames, 60, seed=3))
    middle = np.median(frames)
    assert all(0.2 < (part < middle).mean() < 0.8 for part in (*first, *second))
