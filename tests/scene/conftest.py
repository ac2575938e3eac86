"""A small scene for the tests of this folder."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from twonav_cli.scene.catalog import Scene, read_scene

ROOM = """
<mujoco model="room">
  <option timestep="0.02" gravity="0 0 0" integrator="RK4"/>
  <asset>
    <texture name="checks" type="2d" builtin="checker" rgb1="0.9 0.3 0.2" rgb2="0.2 0.3 0.9" width="64" height="64"/>
    <material name="checks" texture="checks" texrepeat="8 8"/>
  </asset>
  <worldbody>
    <light pos="0 0 2.5" dir="0 0 -1"/>
    <geom name="floor" type="plane" size="0 0 1" pos="0 0 {floor}" material="checks"/>
    <geom name="wall_right" type="box" size="0.05 1.6 0.5" pos="2.05 0 {middle}" rgba="0.2 0.7 0.2 1"/>
    <geom name="wall_left" type="box" size="0.05 1.6 0.5" pos="-2.05 0 {middle}" rgba="0.7 0.2 0.2 1"/>
    <geom name="wall_up" type="box" size="2.1 0.05 0.5" pos="0 1.55 {middle}" material="checks"/>
    <geom name="wall_down" type="box" size="2.1 0.05 0.5" pos="0 -1.55 {middle}" rgba="0.2 0.2 0.7 1"/>
    {more}
    <site name="goal/east" pos="1 0 {floor}" group="4"/>
    <site name="goal/west" pos="-1 0 {floor}" euler="0 0 90" group="4"/>
    <site name="start/middle" pos="0 0 {floor}" group="4"/>
    <site name="room/all" type="box" pos="0 0 {middle}" size="2 1.5 0.5" group="4"/>
  </worldbody>
  <custom><numeric name="twonav.map" data="-2.4 -1.6 2.4 1.6"/></custom>
</mujoco>
"""

MakeScene = Callable[..., Scene]


def room_xml(floor_m: float = 0.0, more: str = "") -> str:
    """Return a room of 4 x 3 m whose inner walls are at x = +-2 and y = +-1.5."""
    return ROOM.format(floor=floor_m, middle=floor_m + 0.5, more=more)


@pytest.fixture
def make_scene(tmp_path: Path) -> MakeScene:
    """Return a function that writes and reads the room, with more things in it if wanted."""

    def make(floor_m: float = 0.0, more: str = "") -> Scene:
        path = tmp_path / "room" / "scene.xml"
        path.parent.mkdir(exist_ok=True)
        path.write_text(room_xml(floor_m, more))
        return read_scene(str(path))

    return make
