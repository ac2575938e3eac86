"""A scene with its map and its maze: the robot's own map where there is one, else the geometry's, made once."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.mapping import floor as floor_module
from twonav_cli.mapping import known_maps
from twonav_cli.mapping.floor import geometry_map, read_floor
from twonav_cli.mapping.known_maps import save_known_map
from twonav_cli.mapping.occupancy import OCCUPIED, OccupancyMap
from twonav_cli.scene.catalog import read_scene

ROOM = """
<mujoco model="room">
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="right" type="box" size="0.05 1.6 0.5" pos="2.05 0 0.5"/>
    <geom name="left" type="box" size="0.05 1.6 0.5" pos="-2.05 0 0.5"/>
    <geom name="up" type="box" size="2.1 0.05 0.5" pos="0 1.55 0.5"/>
    <geom name="down" type="box" size="2.1 0.05 0.5" pos="0 -1.55 0.5"/>
    <geom name="stool" type="box" size="0.1 0.1 0.3" pos="{stool_x} -0.6 0.3"/>
    <site name="goal/east" pos="1.4 0.2 0"/>
    <site name="start/west" pos="-1.4 0.2 0"/>
  </worldbody>
  <custom><numeric name="twonav.map" data="-2.4 -1.6 2.4 1.6"/></custom>
</mujoco>
"""


@pytest.fixture
def runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path / "runs"))
    return tmp_path / "runs"


@pytest.fixture
def room(tmp_path: Path) -> Path:
    path = tmp_path / "room.xml"
    path.write_text(ROOM.format(stool_x=0.2))
    return path


@pytest.mark.usefixtures("runs")
def test_the_stool_is_in_the_map_and_blocks_its_cell_of_the_maze(room: Path) -> None:
    floor = read_floor(str(room))
    at = floor.map.frame.cell_at(0.2, -0.6)
    assert floor.map.occupied[at]
    assert floor.maze.blocked[floor.maze_frame.cell_at(0.2, -0.6)]
    assert floor.maze.goals == {"east": floor.maze_frame.cell_at(1.4, 0.2)}
    assert floor.start_cells() == [floor.maze_frame.cell_at(-1.4, 0.2)]


def test_the_map_of_ones_own_scene_is_made_once(room: Path, runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = read_floor(str(room))
    assert sorted(path.name for path in (runs / "room" / "map-geometry").iterdir()) == [
        "card.json",
        "map.pgm",
        "map.yaml",
    ]
    monkeypatch.setattr(floor_module, "make_map", lambda scene, folder: pytest.fail("the map was made again"))
    assert np.array_equal(read_floor(str(room)).map.pixels, first.map.pixels)


def test_a_scene_that_has_changed_gets_a_new_map(room: Path, runs: Path) -> None:
    before = read_floor(str(room))
    room.write_text(ROOM.format(stool_x=0.8))
    after = read_floor(str(room))
    assert after.map.occupied[after.map.frame.cell_at(0.8, -0.6)]
    assert not after.map.occupied[after.map.frame.cell_at(0.2, -0.6)]
    assert after.map.digest != before.map.digest
    assert json.loads((runs / "room" / "map-geometry" / "card.json").read_text())["map_digest"] == after.map.digest


@pytest.mark.parametrize("damaged", ["map.pgm", "map.yaml", "card.json"])
@pytest.mark.parametrize("how", ["flipped", "truncated", "missing"])
def test_a_damaged_map_is_made_again(room: Path, runs: Path, damaged: str, how: str) -> None:
    first = read_floor(str(room))
    path = runs / "room" / "map-geometry" / damaged
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 0xFF
    if how == "missing":
        path.unlink()
    else:
        path.write_bytes(content if how == "flipped" else content[: len(content) // 2])
    again = read_floor(str(room))
    assert np.array_equal(again.map.pixels, first.map.pixels)
    assert again.map.frame == first.map.frame


@pytest.mark.usefixtures("runs")
def test_the_shipped_map_is_that_of_the_shipped_scene(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(floor_module, "make_map", lambda scene, folder: pytest.fail("the shipped map does not fit"))
    floor = read_floor("apartment")
    assert floor.maze_frame.shape == (24, 47)
    assert floor.map.frame.shape == (192, 376)


def test_a_map_that_cannot_be_kept_is_one_line(room: Path, runs: Path) -> None:
    runs.write_text("a file where the folder should be")
    with pytest.raises(TwonavError, match="cannot write"):
        read_floor(str(room))


# The map that the robot made


def surveyed(path: Path, folder: Path, mark: tuple[float, float] = (0.9, 0.9)) -> OccupancyMap:
    """Put a survey's map into a folder: the geometry's with one pixel more, so that the two differ."""
    scene = read_scene(str(path))
    pixels = geometry_map(scene).pixels.copy()
    pixels[scene.map_frame.cell_at(*mark)] = OCCUPIED
    occupancy = OccupancyMap(scene.map_frame, pixels)
    save_known_map(scene, occupancy, folder, {"source": "survey", "command": "test", "seed": 0, "metrics": {}})
    return occupancy


@pytest.fixture
def shipped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the folder of the shipped checkpoints, which is empty."""
    monkeypatch.setattr(known_maps, "checkpoints_dir", lambda: tmp_path / "shipped")
    return tmp_path / "shipped"


def test_the_robots_own_map_goes_before_the_geometrys(room: Path, runs: Path) -> None:
    assert read_floor(str(room)).map_source == "geometry"
    own = surveyed(room, runs / "room" / "map")
    floor = read_floor(str(room))
    assert (floor.map_source, floor.map.digest) == ("survey", own.digest)
    assert floor.maze.blocked[floor.maze_frame.cell_at(0.9, 0.9)]


def test_either_map_can_be_asked_for(room: Path, runs: Path) -> None:
    geometry = read_floor(str(room), "geometry").map
    own = surveyed(room, runs / "room" / "map")
    assert read_floor(str(room), "geometry").map.digest == geometry.digest
    assert read_floor(str(room), "survey").map.digest == own.digest


def test_a_survey_that_is_not_there_is_answered_with_the_command_that_makes_it(room: Path, runs: Path) -> None:
    with pytest.raises(TwonavError, match=f"`twonav train --stage map --scene {room}`"):
        read_floor(str(room), "survey")
    assert not runs.exists()


@pytest.mark.usefixtures("runs")
def test_an_unknown_source_is_answered_with_the_right_ones(room: Path) -> None:
    with pytest.raises(TwonavError, match=r"did you mean 'survey'.*Known: survey, geometry"):
        read_floor(str(room), "servey")


def test_the_survey_of_a_scene_that_has_changed_does_not_count(room: Path, runs: Path) -> None:
    surveyed(room, runs / "room" / "map")
    room.write_text(ROOM.format(stool_x=0.8))
    assert read_floor(str(room)).map_source == "geometry"
    with pytest.raises(TwonavError, match="has not surveyed room yet, or the scene has changed"):
        read_floor(str(room), "survey")


def test_a_floor_knows_of_the_survey_that_no_longer_fits(room: Path, runs: Path) -> None:
    folder = runs / "room" / "map"
    assert read_floor(str(room)).outdated is None
    surveyed(room, folder)
    assert read_floor(str(room)).outdated is None
    room.write_text(ROOM.format(stool_x=0.8))
    assert read_floor(str(room)).outdated == folder
    assert read_floor(str(room), "geometry").outdated is None
    (folder / "card.json").write_text("[]")
    assert read_floor(str(room)).outdated is None


def test_a_card_without_a_source_is_of_the_geometry(room: Path, runs: Path) -> None:
    surveyed(room, runs / "room" / "map")
    path = runs / "room" / "map" / "card.json"
    card = json.loads(path.read_text())
    del card["source"]
    path.write_text(json.dumps(card))
    assert read_floor(str(room)).map_source == "geometry"
    assert read_floor(str(room)).map.digest == card["map_digest"]


def test_the_shipped_survey_goes_first_in_playing_and_the_own_one_in_training(
    room: Path, runs: Path, shipped: Path, tmp_path: Path
) -> None:
    own = surveyed(room, runs / "room" / "map", (0.9, 0.9))
    theirs = surveyed(room, shipped / "room" / "map", (0.9, -0.9))
    assert read_floor(str(room)).map.digest == theirs.digest
    assert read_floor(str(room), own_first=True).map.digest == own.digest
    named = surveyed(room, tmp_path / "named" / "map", (0.5, 0.9))
    assert read_floor(str(room), chosen=tmp_path / "named").map.digest == named.digest


@pytest.mark.usefixtures("runs")
def test_the_map_beside_named_checkpoints_counts_wherever_it_comes_from(room: Path, shipped: Path) -> None:
    theirs = surveyed(room, shipped / "room" / "map")
    own = floor_module.make_map(read_scene(str(room)), shipped / "named" / "map")
    assert read_floor(str(room)).map.digest == theirs.digest
    assert read_floor(str(room), chosen=shipped / "named").map.digest == own.digest
    assert read_floor(str(room), "survey", chosen=shipped / "named").map.digest == theirs.digest


def test_a_goal_that_the_robots_map_blocks_is_said_to_be_so(room: Path, runs: Path) -> None:
    surveyed(room, runs / "room" / "map", (1.4, 0.2))
    with pytest.raises(TwonavError, match=r"on the map that the robot made, goal 'east' .*--map-from geometry"):
        read_floor(str(room))


@pytest.mark.parametrize("damaged", ["map.pgm", "map.yaml", "card.json"])
def test_a_damaged_survey_is_not_used(room: Path, runs: Path, damaged: str) -> None:
    surveyed(room, runs / "room" / "map")
    path = runs / "room" / "map" / damaged
    content = bytearray(path.read_bytes())
    path.write_bytes(content[: len(content) // 3])
    assert read_floor(str(room)).map_source == "geometry"
