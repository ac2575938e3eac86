"""A scene with its map and its maze: the map is made once, and again when it is not the scene's."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.mapping import floor as floor_module
from twonav_cli.mapping.floor import read_floor

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
    assert sorted(path.name for path in (runs / "room" / "map").iterdir()) == ["card.json", "map.pgm", "map.yaml"]
    monkeypatch.setattr(floor_module, "make_map", lambda scene, folder: pytest.fail("the map was made again"))
    assert np.array_equal(read_floor(str(room)).map.pixels, first.map.pixels)


def test_a_scene_that_has_changed_gets_a_new_map(room: Path, runs: Path) -> None:
    before = read_floor(str(room))
    room.write_text(ROOM.format(stool_x=0.8))
    after = read_floor(str(room))
    assert after.map.occupied[after.map.frame.cell_at(0.8, -0.6)]
    assert not after.map.occupied[after.map.frame.cell_at(0.2, -0.6)]
    assert after.map.digest != before.map.digest
    assert json.loads((runs / "room" / "map" / "card.json").read_text())["map_digest"] == after.map.digest


@pytest.mark.parametrize("damaged", ["map.pgm", "map.yaml", "card.json"])
@pytest.mark.parametrize("how", ["flipped", "truncated", "missing"])
def test_a_damaged_map_is_made_again(room: Path, runs: Path, damaged: str, how: str) -> None:
    first = read_floor(str(room))
    path = runs / "room" / "map" / damaged
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
