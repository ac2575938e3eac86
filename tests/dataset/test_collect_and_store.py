import json
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.dataset import collect as collecting
from twonav_cli.dataset.collect import Provenance, collect, frames_done
from twonav_cli.dataset.plan import GRID, HELD_OUT, RANDOM, FramePlan
from twonav_cli.dataset.poses import TEST, TRAIN, VALIDATION
from twonav_cli.dataset.store import open_store
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose

KITCHEN = Provenance("kitchen", "digest", 3, {"shadows": False})


def _plan(count: int = 10) -> FramePlan:
    poses = np.zeros((count, 3), dtype=np.float32)
    poses[:, 0] = np.arange(count)
    kinds = np.full(count, GRID, dtype=np.uint8)
    splits = np.resize(np.array([TRAIN, TEST, VALIDATION], dtype=np.uint8), count)
    kinds[-2], splits[-2] = RANDOM, TRAIN
    kinds[-1], splits[-1] = HELD_OUT, TEST
    return FramePlan(poses, kinds, splits)


def _picture(pose: Pose) -> np.ndarray:
    return np.full((84, 84, 3), int(pose.x_m), dtype=np.uint8)


def test_what_was_rendered_is_read_back_with_its_pose(tmp_path: Path) -> None:
    store = open_store(collect(_picture, _plan(), tmp_path, KITCHEN), "digest")
    images, poses = store.batch(np.array([7, 2]))
    assert images[:, 40, 40, 1].tolist() == [2, 7]
    assert poses[:, 0].tolist() == [2.0, 7.0]
    assert store.meta["render"] == {"shadows": False}


def test_training_frames_exclude_test_validation_and_held_out_ones(tmp_path: Path) -> None:
    store = open_store(collect(_picture, _plan(), tmp_path, KITCHEN))
    assert store.training().tolist() == [0, 3, 6, 8]
    assert store.paper_test().tolist() == [1, 4, 7]
    assert store.off_grid().tolist() == [9]


def test_a_stopped_collection_goes_on_where_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collecting, "_CHUNK", 4)
    seen: list[float] = []

    def noted(pose: Pose) -> np.ndarray:
        seen.append(pose.x_m)
        return _picture(pose)

    collect(noted, _plan(), tmp_path, KITCHEN, should_stop=lambda: len(seen) >= 4)
    assert frames_done(tmp_path) == 4
    with pytest.raises(TwonavError, match="4 of 10"):
        open_store(tmp_path)
    told: list[tuple[int, int]] = []
    collect(noted, _plan(), tmp_path, KITCHEN, progress=lambda *counts: told.append(counts))
    assert told == [(8, 10), (10, 10)]
    assert seen == list(range(10))
    assert open_store(tmp_path).frames[:, 0, 0, 0].tolist() == list(range(10))


def test_a_finished_collection_renders_nothing_again(tmp_path: Path) -> None:
    collect(_picture, _plan(), tmp_path, KITCHEN)

    def refuse(pose: Pose) -> np.ndarray:
        raise AssertionError(pose)

    assert collect(refuse, _plan(), tmp_path, KITCHEN) == tmp_path


def test_frames_of_another_plan_are_not_mixed(tmp_path: Path) -> None:
    collect(_picture, _plan(), tmp_path, KITCHEN)
    with pytest.raises(TwonavError, match="another scene, map, plan or seed"):
        collect(_picture, _plan(11), tmp_path, KITCHEN)


def test_a_picture_of_another_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="not uint8"):
        collect(lambda pose: np.zeros((60, 80, 3), np.uint8), _plan(), tmp_path, KITCHEN)


def test_a_missing_folder_another_scene_and_damage_are_each_one_line(tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="collect them first"):
        open_store(tmp_path / "nowhere")
    collect(_picture, _plan(), tmp_path, KITCHEN)
    with pytest.raises(TwonavError, match="another scene"):
        open_store(tmp_path, "other")
    frames = tmp_path / "frames.npy"
    frames.write_bytes(frames.read_bytes()[:5000])
    with pytest.raises(TwonavError, match="damaged"):
        open_store(tmp_path)
    (tmp_path / "meta.json").write_text(json.dumps([1]))
    with pytest.raises(TwonavError, match="no frames of this version"):
        open_store(tmp_path)
