"""Where a frame was taken, as the robot itself finds it."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.dataset import collect as collecting
from twonav_cli.dataset.collect import LABELS_FILE, MAPPER, Provenance, collect
from twonav_cli.dataset.labels import MapLabels
from twonav_cli.dataset.plan import GRID, HELD_OUT, FramePlan
from twonav_cli.dataset.poses import TEST, TRAIN
from twonav_cli.dataset.store import open_store
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, distance_m, wrap_angle
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.world import World

SIMULATED = Provenance("toy", "digest", 3)
OF_MAPPER = replace(SIMULATED, labels=MAPPER, map_digest="m" * 16)


def plan(count: int = 6) -> FramePlan:
    poses = np.zeros((count, 3), dtype=np.float32)
    poses[:, 0] = np.arange(count)
    kinds, splits = np.full(count, GRID, dtype=np.uint8), np.full(count, TRAIN, dtype=np.uint8)
    kinds[-1], splits[-1] = HELD_OUT, TEST
    return FramePlan(poses, kinds, splits)


def picture(pose: Pose) -> np.ndarray:
    return np.full((84, 84, 3), int(pose.x_m), dtype=np.uint8)


def moved(index: int, pose: Pose) -> Pose | None:
    """Return the pose a tenth to the right; nobody knows where frame 2 was taken."""
    return None if index == 2 else Pose(pose.x_m + 0.1, pose.y_m, pose.theta_rad)


def test_labels_are_learned_from_and_poses_are_measured_against(tmp_path: Path) -> None:
    store = open_store(collect(picture, plan(), tmp_path, OF_MAPPER, label=moved))
    assert store.poses[:, 0].tolist() == [0, 1, 2, 3, 4, 5]
    assert np.isnan(store.labels[2]).all()
    assert store.labels[[0, 1, 3, 4, 5], 0] == pytest.approx([0.1, 1.1, 3.1, 4.1, 5.1])
    assert store.batch(np.array([4, 1]))[1][:, 0] == pytest.approx([1.1, 4.1])
    assert (store.meta["labels"], store.meta["map_digest"]) == ("mapper", "m" * 16)


def test_what_has_no_label_is_not_learned_from(tmp_path: Path) -> None:
    store = open_store(collect(picture, plan(), tmp_path, OF_MAPPER, label=moved))
    assert store.training().tolist() == [0, 1, 3, 4]
    assert store.off_grid().tolist() == [5]


def test_the_simulators_labels_are_the_poses_and_take_no_file(tmp_path: Path) -> None:
    store = open_store(collect(picture, plan(), tmp_path, SIMULATED))
    assert store.meta["labels"] == "simulator"
    assert np.array_equal(store.labels, store.poses)
    assert not (tmp_path / LABELS_FILE).exists()


def test_frames_from_before_there_were_labels_are_read_and_gone_on_with(tmp_path: Path) -> None:
    collect(picture, plan(), tmp_path, SIMULATED)
    path = tmp_path / "meta.json"
    meta = json.loads(path.read_text())
    del meta["labels"], meta["map_digest"]
    path.write_text(json.dumps(meta))
    assert np.array_equal(open_store(tmp_path).labels, open_store(tmp_path).poses)
    assert collect(picture, plan(), tmp_path, SIMULATED) == tmp_path
    with pytest.raises(TwonavError, match="another scene, map, plan or seed"):
        collect(picture, plan(), tmp_path, OF_MAPPER, label=moved)


def test_a_stopped_collection_goes_on_with_the_labels_it_has(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(collecting, "_CHUNK", 2)
    asked: list[int] = []

    def noted(index: int, pose: Pose) -> Pose | None:
        asked.append(index)
        return moved(index, pose)

    collect(picture, plan(), tmp_path, OF_MAPPER, should_stop=lambda: len(asked) >= 4, label=noted)
    assert asked == [0, 1, 2, 3]
    collect(picture, plan(), tmp_path, OF_MAPPER, label=noted)
    assert asked == [0, 1, 2, 3, 4, 5]
    assert np.isfinite(open_store(tmp_path).labels).all(axis=1).tolist() == [True, True, False, True, True, True]


@pytest.mark.parametrize("how", ["missing", "truncated"])
def test_damaged_labels_are_one_line(tmp_path: Path, how: str) -> None:
    collect(picture, plan(), tmp_path, OF_MAPPER, label=moved)
    path = tmp_path / LABELS_FILE
    content = path.read_bytes()
    path.unlink()
    if how == "truncated":
        path.write_bytes(content[:90])
    with pytest.raises(TwonavError, match=r"labels\.npy is missing or damaged"):
        open_store(tmp_path)
    if how == "missing":
        with pytest.raises(TwonavError, match=r"labels\.npy is missing or damaged"):
            collect(picture, plan(), tmp_path, OF_MAPPER, label=moved)


# The robot in a scene


@pytest.fixture(scope="module")
def floor(tmp_path_factory: pytest.TempPathFactory) -> Floor:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TWONAV_RUNS", str(tmp_path_factory.mktemp("runs")))
        return read_floor("kitchen", "geometry")


def test_the_robot_finds_itself_on_its_map_to_a_few_centimetres_from_a_guess_that_is_worse(floor: Floor) -> None:
    world = World(floor.scene)
    label = MapLabels(floor, RangeFinder(world), seed=1)
    away_m, turned_rad = [], []
    for index, pose in enumerate([*floor.scene.starts.values(), *floor.scene.goals.values()]):
        world.place(pose)
        found = label(index, pose)
        assert found is not None
        away_m.append(distance_m(found, pose))
        turned_rad.append(abs(wrap_angle(found.theta_rad - pose.theta_rad)))
    # The geometry's map has pixels only: a survey's, with the points on its walls, is twice as exact.
    assert 1e-3 < np.mean(away_m) < 0.04
    assert max(away_m) < 0.1
    assert np.mean(turned_rad) < 0.02


def test_a_frames_label_depends_on_its_number_alone_and_not_on_those_before(floor: Floor) -> None:
    world = World(floor.scene)
    pose = next(iter(floor.scene.starts.values()))
    world.place(pose)
    one, other = (MapLabels(floor, RangeFinder(world), seed=2) for _ in range(2))
    for index in range(3):
        one(index, pose)
    assert one(3, pose) == other(3, pose)
    assert one(3, pose) != one(4, pose)


def test_a_scan_of_another_place_gets_no_label(floor: Floor) -> None:
    world = World(floor.scene)
    world.place(Pose(1.0, 0.7, 0.5))
    label = MapLabels(floor, RangeFinder(world), seed=3)
    assert label(0, Pose(5.7, 4.1, -2.2)) is None
    assert label(1, Pose(30.0, 30.0, 0.0)) is None
