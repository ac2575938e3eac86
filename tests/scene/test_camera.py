import os
from collections.abc import Iterator

import numpy as np
import pytest
from conftest import MakeScene

from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, Twist
from twonav_cli.scene import engine
from twonav_cli.scene.camera import Camera, top_view
from twonav_cli.scene.world import World


@pytest.fixture
def world(make_scene: MakeScene) -> World:
    return World(make_scene())


@pytest.fixture
def camera(world: World) -> Iterator[Camera]:
    camera = Camera(world)
    yield camera
    camera.close()


def main_colour(image: np.ndarray) -> int:
    """Return the strongest channel of the middle of a picture."""
    return int(image[36:48, 36:48].reshape(-1, 3).mean(axis=0).argmax())


def test_the_picture_shows_what_lies_ahead(world: World, camera: Camera) -> None:
    world.place(Pose(1.0, 0.0, 0.0))
    right = camera.image()
    world.place(Pose(-1.0, 0.0, np.pi))
    left = camera.image()
    world.place(Pose(0.0, -0.8, -np.pi / 2))
    down = camera.image()
    assert right.shape == (84, 84, 3)
    assert right.dtype == np.uint8
    assert (main_colour(right), main_colour(left), main_colour(down)) == (1, 0, 2)


def test_row_0_is_the_top_and_column_0_the_left(world: World, camera: Camera) -> None:
    world.place(Pose(0.5, 0.9, 0.0))  # the green wall ahead, the checked wall on the left, the floor below
    image = camera.image().astype(int)
    ahead = image[40:50, 40:60].reshape(-1, 3).mean(axis=0)
    floor = image[-4:].reshape(-1, 3)
    assert ahead.argmax() == 1
    assert (floor.argmax(axis=1) != 1).mean() > 0.9
    assert (image[30:50, :8].reshape(-1, 3).argmax(axis=1) != 1).mean() > 0.9


def test_a_picture_does_not_depend_on_what_was_drawn_before(world: World, camera: Camera) -> None:
    world.place(Pose(0.2, 0.1, 0.7))
    first = camera.image()
    for theta_rad in (0.0, 2.0, 4.0):
        world.place(Pose(-0.5, 0.3, theta_rad))
        camera.image()
    top_view(world, 64)
    world.place(Pose(0.2, 0.1, 0.7))
    assert np.array_equal(camera.image(), first)
    another = Camera(world)
    assert np.array_equal(another.image(), first)
    another.close()


def test_after_a_drive_the_picture_is_taken_from_where_the_robot_is(world: World, camera: Camera) -> None:
    world.place(Pose(-0.5, 0.2, 0.1))
    world.drive(Twist(0.5, 0.1, 0.8), 0.7)
    moving = camera.image()
    world.place(world.pose())
    assert np.abs(camera.image().astype(int) - moving).max() <= 1


def test_leaving_out_what_is_behind_changes_no_pixel(world: World, camera: Camera) -> None:
    whole = Camera(world)
    whole._in_view = lambda: np.ones(world.model.ngeom, dtype=bool)  # type: ignore[method-assign]  # draw it all
    rng = np.random.default_rng(3)
    left_out = 0
    for _ in range(12):
        world.place(Pose(*rng.uniform(-1.0, 1.0, 2), rng.uniform(-3.0, 3.0)))
        left_out += int((~camera._in_view() & ~world.is_robot).sum())
        assert np.array_equal(whole.image(), camera.image())
    assert left_out > 10
    whole.close()


def test_drawing_leaves_the_groups_of_the_scene_as_they_were(world: World, camera: Camera) -> None:
    before = np.array(world.model.geom_group)
    camera.image()
    top_view(world, 64)
    assert np.array_equal(world.model.geom_group, before)


def test_the_view_from_the_top_lies_as_the_map(world: World) -> None:
    world.place(Pose(0.0, 0.0, 0.0))
    view = top_view(world, 320).astype(int)
    assert view.shape == (320, 480, 3)
    assert view[160, 445].argmax() == 1  # wall_right is green
    assert view[160, 35].argmax() == 0  # wall_left is red
    assert view[315, 240].argmax() == 2  # wall_down is blue


def test_a_chosen_renderer_is_respected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MUJOCO_GL", "osmesa")
    assert engine.choose_renderer() == "osmesa"


def test_without_a_screen_egl_comes_before_osmesa(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.setenv(name, "")
    monkeypatch.setattr(engine.sys, "platform", "linux")
    for there, chosen in (({"EGL", "OSMesa"}, "egl"), ({"OSMesa"}, "osmesa")):
        monkeypatch.setenv("MUJOCO_GL", "")
        monkeypatch.setattr(engine, "_loads", there.__contains__)
        assert engine.choose_renderer() == chosen
        assert os.environ["MUJOCO_GL"] == chosen


def test_without_anything_to_draw_with_the_command_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("MUJOCO_GL", "DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.setenv(name, "")
    monkeypatch.setattr(engine.sys, "platform", "linux")
    monkeypatch.setattr(engine, "_loads", lambda library: False)
    with pytest.raises(TwonavError, match="apt-get install -y --no-install-recommends libegl1"):
        engine.choose_renderer()


def test_the_set_up_installs_what_the_error_names() -> None:
    from pathlib import Path

    from twonav_cli.scene.engine import RENDERER_PACKAGES

    assert f'packages="{RENDERER_PACKAGES}"' in (Path(__file__).parents[2] / "install_renderer.sh").read_text()
