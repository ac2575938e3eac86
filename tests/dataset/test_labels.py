"""Where a frame was taken, as the robot itself finds it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from toy_frames import ToyCamera, toy_plan

from twonav_cli.dataset.collect import LABELS_FILE, MAPPER, Provenance, collect
from twonav_cli.dataset.labels import MapLabels, TourLabels
from twonav_cli.dataset.poses import TRAIN
from twonav_cli.dataset.store import open_store
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, distance_m, wrap_angle
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.scene.laser import RangeFinder
from twonav_cli.scene.world import World

SIMULATED = Provenance("toy", "digest", 3)
OF_MAPPER = replace(SIMULATED, labels=MAPPER, map_digest="m" * 16)


def test_labels_are_learned_from_and_poses_are_measured_against(tmp_path: Path) -> None:
    store = open_store(collect(ToyCamera(labelled=True), toy_plan(6), tmp_path, OF_MAPPER))
    assert store.poses[:, 0].tolist() == [0, 1, 2, 3, 4, 5]
    assert np.isnan(store.labels[2]).all()
    assert store.labels[[0, 1, 3, 4, 5], 0] == pytest.approx([0.1, 1.1, 3.1, 4.1, 5.1])
    assert store.batch(np.array([4, 1]))[1][:, 0] == pytest.approx([4.1, 1.1])
    assert (store.meta["labels"], store.meta["map_digest"]) == ("mapper", "m" * 16)


def test_what_has_no_label_is_not_learned_from(tmp_path: Path) -> None:
    plan = toy_plan(9)
    plan.splits[:] = TRAIN
    store = open_store(collect(ToyCamera(labelled=True), plan, tmp_path, OF_MAPPER))
    assert store.training().tolist() == [0, 1, 3, 4, 5, 6, 7]


def test_the_simulators_labels_are_the_poses_and_take_no_file(tmp_path: Path) -> None:
    store = open_store(collect(ToyCamera(), toy_plan(), tmp_path, SIMULATED))
    assert store.meta["labels"] == "simulator"
    assert np.array_equal(store.labels, store.poses)
    assert not (tmp_path / LABELS_FILE).exists()


def test_labels_by_another_are_not_mixed(tmp_path: Path) -> None:
    collect(ToyCamera(), toy_plan(), tmp_path, SIMULATED)
    with pytest.raises(TwonavError, match="another scene, map, plan or seed"):
        collect(ToyCamera(labelled=True), toy_plan(), tmp_path, OF_MAPPER)


def test_a_stopped_collection_goes_on_with_the_labels_it_has(tmp_path: Path) -> None:
    collect(ToyCamera(labelled=True), toy_plan(), tmp_path, OF_MAPPER, should_stop=lambda: True)
    collect(ToyCamera(labelled=True), toy_plan(), tmp_path, OF_MAPPER)
    known = open_store(tmp_path).labelled()
    assert np.flatnonzero(~known).tolist() == [2]


@pytest.mark.parametrize("how", ["missing", "truncated"])
def test_damaged_labels_are_one_line(tmp_path: Path, how: str) -> None:
    camera = ToyCamera(labelled=True)
    collect(camera, toy_plan(), tmp_path, OF_MAPPER)
    path = tmp_path / LABELS_FILE
    content = path.read_bytes()
    path.unlink()
    if how == "truncated":
        path.write_bytes(content[:90])
    with pytest.raises(TwonavError, match=r"labels\.npy is missing or damaged"):
        open_store(tmp_path)
    with pytest.raises(TwonavError, match=r"labels\.npy is missing or damaged"):
        collect(camera, toy_plan(), tmp_path, OF_MAPPER)


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
        found = label.set_down(index, pose)
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
        one.set_down(index, pose)
    assert one.set_down(3, pose) == other.set_down(3, pose)
    assert one.set_down(3, pose) != one.set_down(4, pose)


def test_a_scan_of_another_place_gets_no_label(floor: Floor) -> None:
    world = World(floor.scene)
    world.place(Pose(1.0, 0.7, 0.5))
    label = MapLabels(floor, RangeFinder(world), seed=3)
    assert label.set_down(0, Pose(5.7, 4.1, -2.2)) is None
    assert label.set_down(1, Pose(30.0, 30.0, 0.0)) is None


def test_on_a_tour_every_frame_is_labelled_from_the_one_before(floor: Floor) -> None:
    world = World(floor.scene)
    labels = MapLabels(floor, RangeFinder(world), seed=4)
    way = np.array([[1.0, 0.7], [1.2, 0.7], [1.4, 0.8]])
    label = TourLabels(labels, world.place, 0, way)
    assert world.pose()[:2] == pytest.approx((1.4, 0.8), abs=1e-6)
    for index, degrees in enumerate(range(0, 90, 10)):
        pose = Pose(1.4, 0.8, np.deg2rad(degrees))
        world.place(pose)
        found = label(index, pose)
        assert found is not None
        assert distance_m(found, pose) < 0.1
        assert abs(wrap_angle(found.theta_rad - pose.theta_rad)) < 0.05


def test_where_no_scan_fits_a_tour_keeps_odometry_and_gives_no_label(floor: Floor) -> None:
    world = World(floor.scene)
    labels = MapLabels(floor, RangeFinder(world), seed=5)
    world.place(Pose(1.0, 0.7, 0.5))
    elsewhere = Pose(30.0, 30.0, 0.0)
    believed, seen = labels.on_the_way(3, elsewhere, Pose(0.0, 0.0, 0.0), Pose(0.5, 0.0, 0.1))
    assert not seen
    assert believed == pytest.approx((30.5, 30.0, 0.1), abs=0.1)
    assert believed != pytest.approx((30.5, 30.0, 0.1), abs=1e-6)  # odometry errs
