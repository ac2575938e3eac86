import json
import os
import signal
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from toy_frames import ToyCamera, toy_plan

from twonav_cli.dataset.collect import Provenance, chunks_done, collect
from twonav_cli.dataset.plan import FramePlan
from twonav_cli.dataset.store import open_store
from twonav_cli.errors import TwonavError

KITCHEN = Provenance("kitchen", "digest", 3, {"shadows": False})


def test_what_was_rendered_is_read_back_with_its_pose(tmp_path: Path) -> None:
    camera = ToyCamera()
    store = open_store(collect(camera, toy_plan(), tmp_path, KITCHEN), "digest")
    images, poses = store.batch(np.array([7, 2]))
    assert images[:, 40, 40, 1].tolist() == [7, 2]
    assert poses[:, 0].tolist() == [7.0, 2.0]
    assert store.meta["render"] == {"shadows": False}
    assert camera.closed


def test_training_frames_exclude_test_validation_and_held_out_ones(tmp_path: Path) -> None:
    store = open_store(collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN))
    assert store.training().tolist() == [0, 3, 6, 8]
    assert store.paper_test().tolist() == [1, 4, 7]
    assert store.validation().tolist() == [2, 5]
    assert store.off_grid().tolist() == [9]


def test_a_stopped_collection_goes_on_where_it_was(tmp_path: Path) -> None:
    first, second = ToyCamera(), ToyCamera()
    collect(first, toy_plan(), tmp_path, KITCHEN, should_stop=lambda: len(first.taken) >= 1)
    assert first.closed
    assert chunks_done(tmp_path) == {0}
    with pytest.raises(TwonavError, match="1 of 3 chunks"):
        open_store(tmp_path)
    told: list[tuple[int, int]] = []
    collect(second, toy_plan(), tmp_path, KITCHEN, progress=lambda *counts: told.append(counts))
    assert told == [(8, 10), (10, 10)]
    assert second.taken == [1, 2]
    assert open_store(tmp_path).frames[:, 0, 0, 0].tolist() == list(range(10))


def test_a_stopped_collection_of_several_processes_goes_on_too(tmp_path: Path) -> None:
    told: list[int] = []
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN, lambda done, _: told.append(done), lambda: bool(told), 2)
    assert 0 < len(chunks_done(tmp_path)) < 3
    assert max(told) < 10
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN, lambda done, _: told.append(done), processes=2)
    assert open_store(tmp_path).frames[:, 0, 0, 0].tolist() == list(range(10))


def test_several_processes_take_the_same_frames_as_one(tmp_path: Path) -> None:
    told: list[int] = []
    one = open_store(collect(ToyCamera(), toy_plan(), tmp_path / "one", KITCHEN, processes=1))
    two = open_store(
        collect(ToyCamera(), toy_plan(), tmp_path / "two", KITCHEN, lambda done, _: told.append(done), processes=2)
    )
    assert np.array_equal(one.frames, two.frames)
    assert max(told) == 10


def test_chunks_that_came_out_of_order_are_each_remembered(tmp_path: Path) -> None:
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN)
    (tmp_path / "progress.json").write_text(json.dumps({"chunks": [[0, 1], [2, 3]]}))
    again = ToyCamera()
    collect(again, toy_plan(), tmp_path, KITCHEN)
    assert again.taken == [1]
    assert chunks_done(tmp_path) == {0, 1, 2}


def test_a_finished_collection_makes_no_camera_again(tmp_path: Path) -> None:
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN)

    def refuse() -> ToyCamera:
        raise AssertionError

    assert collect(refuse, toy_plan(), tmp_path, KITCHEN) == tmp_path


def test_frames_of_another_plan_are_not_mixed(tmp_path: Path) -> None:
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN)
    with pytest.raises(TwonavError, match="another scene, map, plan or seed"):
        collect(ToyCamera(), toy_plan(11), tmp_path, KITCHEN)


def test_a_picture_of_another_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="not uint8"):
        collect(ToyCamera(size_px=60), toy_plan(), tmp_path, KITCHEN)


def test_a_collection_over_a_file_that_was_cut_off_is_refused(tmp_path: Path) -> None:
    camera = ToyCamera()
    collect(camera, toy_plan(), tmp_path, KITCHEN, should_stop=lambda: True)
    frames = tmp_path / "frames.npy"
    frames.write_bytes(frames.read_bytes()[:5000])
    with pytest.raises(TwonavError, match="damaged"):
        collect(camera, toy_plan(), tmp_path, KITCHEN)


def test_a_missing_folder_another_scene_and_damage_are_each_one_line(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="collect them first"):
        open_store(tmp_path / "nowhere")
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN)
    with pytest.raises(TwonavError, match="another scene"):
        open_store(tmp_path, "other")
    frames = tmp_path / "frames.npy"
    frames.write_bytes(frames.read_bytes()[:5000])
    with pytest.raises(TwonavError, match="damaged"):
        open_store(tmp_path)
    (tmp_path / "meta.json").write_text(json.dumps([1]))
    with pytest.raises(TwonavError, match="no frames of this version"):
        open_store(tmp_path)


class _Broken(ToyCamera):
    """A camera that cannot be had, or that ends its process while it works."""

    def __init__(self, how: str) -> None:
        super().__init__()
        self.how = how

    def __call__(self) -> ToyCamera:
        if self.how == "no renderer":
            raise TwonavError("no renderer")
        return self

    def take(self, plan: FramePlan, chunk: int) -> tuple[np.ndarray, np.ndarray | None]:
        os.kill(os.getpid(), signal.SIGKILL)
        raise AssertionError


@pytest.mark.parametrize(("how", "said"), [("no renderer", "no renderer"), ("killed", "the same command goes on")])
def test_a_camera_that_fails_in_another_process_ends_the_collection_with_one_line(
    tmp_path: Path, how: str, said: str
) -> None:
    with pytest.raises(TwonavError, match=said):
        collect(_Broken(how), toy_plan(), tmp_path, KITCHEN, processes=2)


def test_frames_that_do_not_fit_on_the_disk_are_refused_before_any_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("shutil.disk_usage", lambda folder: SimpleNamespace(free=100_000))
    with pytest.raises(TwonavError, match=r"need 0\.0 GB and .* has 0\.0 GB left"):
        collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN)
    assert not (tmp_path / "frames.npy").exists()


def test_a_mark_of_progress_that_is_not_in_the_plan_is_ignored(tmp_path: Path) -> None:
    collect(ToyCamera(), toy_plan(), tmp_path, KITCHEN)
    (tmp_path / "progress.json").write_text(json.dumps({"chunks": [[0, 2], [7, 9]]}))
    again = ToyCamera()
    collect(again, toy_plan(), tmp_path, KITCHEN)
    assert again.taken == [2]
