import math
from pathlib import Path

import pytest
from conftest import MakeScene, room_xml

from twonav_cli.errors import TwonavError
from twonav_cli.paths import scenes_dir
from twonav_cli.scene.catalog import read_scene, scene_names

SHARED = scenes_dir().parent.parent / "shared" / "data" / "scenes"
FOREIGN = {
    "gizmo_exports/room.xml": ("0.5 0.5 0.2", 0.2),
    "gizmo_exports/workshop.xml": ("0 0 0.3", 0.3),
    "gym_mazes/antmaze_large.xml": ("-18 12 0", 0.0),
    "gym_mazes/pointmaze_large.xml": ("-4.5 3 0", -0.1),
}


def written(folder: Path, text: str) -> str:
    path = folder / "scene.xml"
    path.write_text(text)
    return str(path)


def refused(folder: Path, text: str) -> str:
    with pytest.raises(TwonavError) as caught:
        read_scene(written(folder, text))
    message = str(caught.value)
    assert "\n" not in message
    assert "scene.xml" in message
    return message


def test_a_scene_declares_goals_starts_rooms_and_its_map(make_scene: MakeScene) -> None:
    scene = make_scene()
    assert scene.name == "room"
    assert list(scene.goals) == ["east", "west"]
    assert scene.goals["east"] == pytest.approx((1.0, 0.0, 0.0))
    assert scene.goals["west"] == pytest.approx((-1.0, 0.0, math.pi / 2))
    assert list(scene.starts) == ["middle"]
    assert scene.room_at(0.5, 0.5) == "all"
    assert scene.room_at(2.3, 0.0) is None
    assert scene.map_frame.shape == (64, 96)
    assert (scene.map_frame.x_min_m, scene.map_frame.y_max_m) == pytest.approx((-2.4, 1.6))


@pytest.mark.parametrize("floor_m", [-0.1, 0.0, 0.3])
def test_the_floor_is_found_wherever_it_is(make_scene: MakeScene, floor_m: float) -> None:
    assert make_scene(floor_m).floor_z_m == pytest.approx(floor_m)


def test_a_rug_under_one_goal_is_not_the_floor(make_scene: MakeScene) -> None:
    rug = '<geom type="box" size="0.4 0.4 0.005" pos="1 0 0.005"/>'
    assert make_scene(more=rug).floor_z_m == pytest.approx(0.0)


def test_without_a_declared_map_the_walls_give_its_size(tmp_path: Path) -> None:
    text = room_xml().replace('name="twonav.map"', 'name="other"')
    assert read_scene(written(tmp_path, text)).map_area_m == pytest.approx((-2.4, -1.6, 2.4, 1.6))


def test_without_starts_the_goals_are_starts(tmp_path: Path) -> None:
    scene = read_scene(written(tmp_path, room_xml().replace("start/", "begin/")))
    assert scene.starts == scene.goals


def test_a_folder_and_its_file_are_the_same_scene(tmp_path: Path) -> None:
    path = written(tmp_path, room_xml())
    assert read_scene(str(tmp_path)) == read_scene(path)


def test_the_digest_ignores_line_endings_and_notices_a_changed_file(tmp_path: Path) -> None:
    mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 3 4\nf 2 3 4\n"
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "pyramid.obj").write_text(mesh)
    text = room_xml().replace("<asset>", '<compiler meshdir="meshes"/><asset><mesh file="pyramid.obj"/>')
    first = read_scene(written(tmp_path, text)).digest
    (tmp_path / "scene.xml").write_bytes(text.replace("\n", "\r\n").encode())
    assert read_scene(str(tmp_path)).digest == first
    (tmp_path / "meshes" / "pyramid.obj").write_text(mesh.replace("v 0 0 1", "v 0 0 2"))
    assert read_scene(str(tmp_path)).digest != first


def test_a_wrong_name_is_answered_with_the_right_ones() -> None:
    assert scene_names() == ["apartment", "kitchen"]
    with pytest.raises(TwonavError, match="did you mean 'apartment'"):
        read_scene("apartmnt")
    with pytest.raises(TwonavError, match="there is no scene at"):
        read_scene("nowhere/scene.xml")


BROKEN = {
    "cut short": (lambda t: t[:900], "line"),
    "empty": (lambda t: "", "line"),
    "unknown attribute": (lambda t: t.replace('name="floor"', 'name="floor" foo="1"'), "line"),
    "old attribute": (lambda t: t.replace('timestep="0.02"', 'timestep="0.02" collision="all"'), "older MuJoCo"),
    "other root": (lambda t: '<robot name="r"><link name="l"/></robot>', "<robot>"),
    "NaN": (lambda t: t.replace('pos="2.05 0', 'pos="nan 0'), "not a finite number"),
    "huge": (lambda t: t.replace('pos="2.05 0', 'pos="1e30 0'), "not a finite number"),
    "no goals": (lambda t: t.replace("goal/", "target/"), "declares no goal"),
    "nameless goal": (lambda t: t.replace("goal/east", "goal/"), "without a name"),
    "goal outside": (lambda t: t.replace('pos="1 0 0', 'pos="7 0 0'), "outside the map"),
    "round room": (lambda t: t.replace('name="room/all" type="box"', 'name="room/all" type="sphere"'), "not a box"),
    "map of three": (lambda t: t.replace('data="-2.4 -1.6 2.4 1.6"', 'data="0 0 1"'), "needs 4 numbers"),
    "map reversed": (lambda t: t.replace('data="-2.4 -1.6 2.4 1.6"', 'data="2.4 0 -2.4 1"'), "growing"),
    "map too large": (lambda t: t.replace('data="-2.4 -1.6 2.4 1.6"', 'data="-900 0 900 1"'), "at most"),
    "missing mesh": (lambda t: t.replace("<asset>", '<asset><mesh file="no.obj"/>'), "no.obj"),
    "takes itself in": (
        lambda t: t.replace("<asset>", '<asset><model name="m" file="scene.xml"/>'),
        "takes itself in",
    ),
    "too many copies": (
        lambda t: t.replace("<light", '<replicate count="1000000"><site/></replicate><light'),
        "replicates",
    ),
    "too many keyframes": (lambda t: t.replace("<asset>", '<size nkey="2000000000"/><asset>'), "keyframes"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_scene_is_refused_in_one_line_that_names_the_file(tmp_path: Path, case: str) -> None:
    change, expected = BROKEN[case]
    before = room_xml()
    after = change(before)
    assert after != before
    assert expected in refused(tmp_path, after)


def test_a_texture_of_too_many_pixels_is_refused(tmp_path: Path) -> None:
    header = b"\x89PNG\r\n\x1a\n" + bytes([0, 0, 0, 13]) + b"IHDR" + (20000).to_bytes(4, "big") * 2
    (tmp_path / "big.png").write_bytes(header)
    text = room_xml().replace("<asset>", '<asset><texture name="big" type="2d" file="big.png"/>')
    with pytest.raises(TwonavError, match="20000 x 20000"):
        read_scene(written(tmp_path, text))


@pytest.mark.parametrize("name", FOREIGN)
def test_a_scene_somebody_else_wrote_needs_only_a_goal(tmp_path: Path, name: str) -> None:
    if not (SHARED / name).is_file():
        pytest.skip("the scenes of other people are not here")
    position, floor_m = FOREIGN[name]
    text = (SHARED / name).read_text()
    with pytest.raises(TwonavError, match="declares no goal"):
        read_scene(written(tmp_path, text))
    head, tail = text.split("</worldbody>", 1)
    scene = read_scene(written(tmp_path, f'{head}<site name="goal/there" pos="{position}"/></worldbody>{tail}'))
    assert scene.floor_z_m == pytest.approx(floor_m, abs=1e-6)
    assert scene.map_frame.contains(scene.goals["there"].x_m, scene.goals["there"].y_m)
