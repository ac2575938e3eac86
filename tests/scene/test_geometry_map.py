import numpy as np
import pytest
from conftest import MakeScene

from twonav_cli.geometry import Pose, points_in_map
from twonav_cli.grid import GridFrame
from twonav_cli.scene.geometry_map import occupied_from_geometry
from twonav_cli.scene.world import World


def centres(frame: GridFrame) -> tuple[np.ndarray, np.ndarray]:
    xs, ys = frame.centres()
    return np.broadcast_to(xs, frame.shape), np.broadcast_to(ys[:, None], frame.shape)


@pytest.mark.parametrize("floor_m", [0.0, 0.3])
def test_walls_on_the_borders_of_pixels_fill_exactly_their_pixels(make_scene: MakeScene, floor_m: float) -> None:
    scene = make_scene(floor_m)
    frame = scene.map_frame
    x_m, y_m = centres(frame)
    sides = (np.abs(x_m) > 2.0) & (np.abs(x_m) < 2.1) & (np.abs(y_m) < 1.6)
    ends = (np.abs(y_m) > 1.5) & (np.abs(y_m) < 1.6) & (np.abs(x_m) < 2.1)
    assert np.array_equal(occupied_from_geometry(scene, frame), sides | ends)


@pytest.mark.parametrize(
    ("bottom_m", "top_m", "stands_in_the_way"),
    [(0.0, 0.03, False), (0.0, 0.04, True), (0.44, 0.6, True), (0.45, 0.6, False)],
)
def test_only_what_is_between_climbable_and_the_robots_height_counts(
    make_scene: MakeScene, bottom_m: float, top_m: float, stands_in_the_way: bool
) -> None:
    middle, half = (bottom_m + top_m) / 2, (top_m - bottom_m) / 2
    scene = make_scene(more=f'<geom type="box" size="0.1 0.1 {half}" pos="0.5 0.5 {middle}"/>')
    cell = scene.map_frame.cell_at(0.51, 0.51)
    assert occupied_from_geometry(scene, scene.map_frame)[cell] == stands_in_the_way


def test_a_round_table_a_turned_box_and_a_mesh_cover_what_they_cover(make_scene: MakeScene) -> None:
    more = (
        '<geom type="cylinder" size="0.3 0.2" pos="-1 0 0.2"/>'
        '<geom type="box" size="0.3 0.1 0.2" pos="0.5 0.5 0.2" euler="0 0 30"/>'
        '<geom type="ellipsoid" size="0.4 0.2 0.3" pos="0.5 -0.7 0.3"/>'
    )
    scene = make_scene(more=more)
    frame = scene.map_frame
    occupied = occupied_from_geometry(scene, frame)
    x_m, y_m = centres(frame)
    inner = (np.abs(x_m) < 1.95) & (np.abs(y_m) < 1.45)
    local = points_in_map(Pose(0.0, 0.0, -np.pi / 6), np.stack([x_m - 0.5, y_m - 0.5], axis=-1).reshape(-1, 2))
    along, across = local.T.reshape(2, *frame.shape)
    depth_m = np.stack(
        [
            0.3 - np.hypot(x_m + 1.0, y_m),
            np.minimum(0.3 - np.abs(along), 0.1 - np.abs(across)),
            0.2 * (1.0 - np.hypot((x_m - 0.5) / 0.4, (y_m + 0.7) / 0.2)),
        ]
    ).max(axis=0)
    assert occupied[inner & (depth_m > 0.002)].all()
    assert not occupied[inner & (depth_m < -0.12)].any()
    assert not occupied[inner & (x_m < 0) & (depth_m < -0.036)].any()


def test_what_cannot_collide_is_not_on_the_map(make_scene: MakeScene) -> None:
    ghost = '<geom type="box" size="0.2 0.2 0.2" pos="0.5 0.5 0.2" contype="0" conaffinity="0"/>'
    half = '<geom type="box" size="0.2 0.2 0.2" pos="-0.5 0.5 0.2" contype="0" conaffinity="8"/>'
    scene = make_scene(more=ghost + half)
    occupied = occupied_from_geometry(scene, scene.map_frame)
    assert not occupied[scene.map_frame.cell_at(0.5, 0.5)]
    assert occupied[scene.map_frame.cell_at(-0.5, 0.5)]


def test_a_map_of_any_size_has_its_own_shape(make_scene: MakeScene) -> None:
    frame = GridFrame(1.5, -1.0, 0.05, 13, 21)
    occupied = occupied_from_geometry(make_scene(), frame)
    x_m, _ = centres(frame)
    assert occupied.shape == (13, 21)
    assert np.array_equal(occupied, (x_m > 2.0) & (x_m < 2.1))


def test_where_the_robot_touches_the_map_is_occupied(make_scene: MakeScene) -> None:
    scene = make_scene(more='<geom type="box" size="0.25 0.25 0.2" pos="0.8 0.6 0.2"/>')
    frame = scene.map_frame
    occupied = occupied_from_geometry(scene, frame)
    world = World(scene)
    x_m, y_m = centres(frame)
    rng = np.random.default_rng(5)
    touched = 0
    for _ in range(200):
        pose = Pose(*rng.uniform((-1.9, -1.4), (1.9, 1.4)), rng.uniform(-3.0, 3.0))
        world.place(pose)
        near = occupied & (np.hypot(x_m - pose.x_m, y_m - pose.y_m) < 0.315 + 0.036)
        touched += bool(world.touching())
        assert near.any() or not world.touching()
    assert touched > 20
