"""`twonav train --stage map`, and every command that uses the map it makes."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest

from twonav_cli.checkpoint import read_card
from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole
from twonav_cli.mapping import known_maps, occupancy, trajectory
from twonav_cli.mapping.occupancy import FREE, OccupancyMap, load_map, save_map
from twonav_cli.mapping.survey import Survey
from twonav_cli.mapping.trajectory import read_trajectory
from twonav_cli.terminal import train_map

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line",)

ROOM = """
<mujoco model="room">
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <geom name="right" type="box" size="0.05 1.1 0.5" pos="1.65 0 0.5"/>
    <geom name="left" type="box" size="0.05 1.1 0.5" pos="-1.65 0 0.5"/>
    <geom name="up" type="box" size="1.7 0.05 0.5" pos="0 1.05 0.5"/>
    <geom name="down" type="box" size="1.7 0.05 0.5" pos="0 -1.05 0.5"/>
    <geom name="pillar" type="box" size="0.1 0.1 0.3" pos="0.2 -0.6 0.3"/>
    <site name="goal/east" pos="1.0 0.2 0"/>
    <site name="goal/north" pos="-0.6 0.6 0"/>
    <site name="start/west" pos="-1.0 0.2 0"/>
  </worldbody>
  <custom><numeric name="twonav.map" data="-2.0 -1.2 2.0 1.2"/></custom>
</mujoco>
"""
SURVEY = ["train", "--stage", "map", "--no-record"]


@pytest.fixture
def room(tmp_path: Path) -> Path:
    path = tmp_path / "room.xml"
    path.write_text(ROOM)
    return path


def test_the_robot_makes_a_map_and_every_stage_after_it_uses_it(twonav: Twonav, runs: Path, room: Path) -> None:
    before = twonav("scenes", "show", room, "--map")
    assert f"twonav train --stage map --scene {room}" in before.err
    assert "made by: the simulator" in before.out
    ended = twonav(*SURVEY, "--scene", room, "--json")
    found = ended.only_object()
    assert (ended.code, found["outcome"]) == (0, "surveyed")
    assert found["pose_worst_m"] < 0.1
    assert found["agreeing"] > 0.97
    folder = runs / "room" / "map"
    card = read_card(folder)
    own = load_map(folder / "map.yaml")
    assert (card["kind"], card["source"], card["map_digest"]) == ("map", "survey", own.digest)
    assert card["metrics"] == {key: found[key] for key in card["metrics"]}
    assert len(read_trajectory(folder / "track.txt")) == found["keyframes"]

    shown = twonav("scenes", "show", room, "--map")
    assert (shown.err, "made by: the robot" in shown.out) == ("", True)
    trained = twonav("train", "--stage", "maze", "--no-record", "--scene", room)
    assert trained.code == 0, trained.err
    assert read_card(runs / "room" / "maze")["map_digest"] == own.digest
    judged = twonav("evaluate", "--stage", "maze", "--scene", room, "--json").only_object()
    assert judged["success_rate"] == 1.0
    assert "made on another map" in twonav("evaluate", "--stage", "maze", "--scene", room, "--map-from", "geometry").err


def test_a_chain_on_the_geometrys_map_is_found_beside_a_survey(twonav: Twonav, runs: Path, room: Path) -> None:
    asked = ["--scene", room, "--map-from", "geometry"]
    assert twonav("train", "--stage", "maze", "--no-record", *asked).code == 0
    assert twonav(*SURVEY, "--scene", room, "--quick", "--out", runs / "room" / "map").code == 0
    card = read_card(runs / "room" / "maze")
    assert card["command"].endswith("--map-from geometry")
    assert twonav("evaluate", "--stage", "maze", *asked, "--json").only_object()["success_rate"] == 1.0
    played = twonav("play", "--stage", "maze", "--goal", "east", "--plain", "--no-record", *asked)
    assert (played.code, played.err) == (0, "")


def test_without_a_survey_one_line_says_how_the_robot_makes_its_own_map(twonav: Twonav, room: Path) -> None:
    ended = twonav("train", "--stage", "maze", "--no-record", "--scene", room)
    assert ended.code == 0
    lines = [line for line in ended.err.splitlines() if "twonav train --stage map --scene" in line]
    assert len(lines) == 1
    quiet = twonav("evaluate", "--stage", "maze", "--scene", room, "--json", "--map-from", "geometry")
    assert "--stage map" not in quiet.err
    assert "--stage map" in twonav("play", "--stage", "maze", "--goal", "east", "--plain", "--scene", room).err


@pytest.mark.parametrize(
    "command",
    [
        ["train", "--stage", "maze", "--no-record"],
        ["evaluate", "--stage", "maze"],
        ["play", "--stage", "maze", "--goal", "east", "--plain"],
        ["reproduce", "table7"],
    ],
)
def test_a_survey_that_is_not_there_is_one_line_everywhere(twonav: Twonav, room: Path, command: list[str]) -> None:
    said = twonav(*command, "--scene", room, "--map-from", "survey").complaint
    assert f"let it make the map with `twonav train --stage map --scene {room}`" in said
    assert "did you mean 'survey'" in twonav(*command, "--scene", room, "--map-from", "servey").complaint


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--resume"], "--resume is not for --stage map: leave it out"),
        (["--map-from", "geometry"], "--map-from is not for --stage map"),
        (["--images", "100"], "--images is for --stage localizer only"),
        (["--learner", "multi"], "--learner is for --stage maze only"),
        (["--base", "wheels"], "unknown base 'wheels'.*omni, differential"),
    ],
)
def test_what_a_survey_cannot_do_is_one_line(
    twonav: Twonav, runs: Path, room: Path, arguments: list[str], said: str
) -> None:
    assert re.search(said, twonav(*SURVEY, "--scene", room, *arguments).complaint)
    assert not (runs / "room" / "map").exists()


def test_a_start_in_the_furniture_is_said_before_the_robot_drives(twonav: Twonav, runs: Path, room: Path) -> None:
    room.write_text(ROOM.replace('pos="-1.0 0.2 0"', 'pos="0.2 -0.6 0"'))
    assert "not on free floor" in twonav(*SURVEY, "--scene", room).complaint
    assert not (runs / "room" / "map" / "card.json").exists()


def test_an_interrupted_survey_writes_nothing(
    twonav: Twonav, runs: Path, room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = Survey.run
    monkeypatch.setattr(Survey, "run", lambda survey, should_stop: run(survey, lambda: True))
    ended = twonav(*SURVEY, "--scene", room)
    assert ended.code == 130
    assert "no map was written" in ended.err
    assert not (runs / "room" / "map" / "card.json").exists()


def test_a_survey_that_runs_out_of_time_keeps_what_it_has_and_fails(
    twonav: Twonav, runs: Path, room: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(train_map, "SurveyConfig", lambda: train_map.QUICK.__class__(time_limit_s=5.0))
    ended = twonav(*SURVEY, "--scene", room)
    assert ended.code == 1
    assert "out of time before everything was seen" in ended.err
    assert read_card(runs / "room" / "map")["metrics"]["simulated_s"] >= 5.0


def test_the_same_seed_gives_the_same_map(twonav: Twonav, room: Path, tmp_path: Path) -> None:
    digests = []
    for seed in (1, 1, 2):
        out = tmp_path / f"map{len(digests)}"
        assert twonav(*SURVEY, "--quick", "--scene", room, "--seed", seed, "--out", out).code == 0
        digests.append(read_card(out)["map_digest"])
    assert digests[0] == digests[1]
    assert digests[0] != digests[2]


def test_a_recording_of_a_survey_can_be_read_back(twonav: Twonav, room: Path, tmp_path: Path) -> None:
    path = tmp_path / "survey.rrd"
    ended = twonav("train", "--stage", "map", "--quick", "--scene", room, "--record", path)
    assert ended.code == 0
    assert f"recording: {path}" in ended.err
    report = json.loads(twonav("inspect", path, "--json").out)
    assert report["stage"] == "map"


@pytest.mark.parametrize("last", ["track.txt", "walls.npy", "map.pgm", "map.yaml"])
def test_a_stop_while_writing_never_leaves_a_new_file_under_an_old_card(
    twonav: Twonav, room: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, last: str
) -> None:
    folder = tmp_path / "made"
    for name in ("card.json", "track.txt", "walls.npy", "map.pgm", "map.yaml"):
        folder.mkdir(exist_ok=True)
        (folder / name).write_text('{"kind": "map", "scene": "room"}')

    def stopping(path: Path, content: bytes | str) -> Path:
        written = write_whole(path, content)
        if path.parent == folder and path.name == last:
            raise TwonavError("stopped here")
        return written

    for module in (occupancy, trajectory, known_maps):
        monkeypatch.setattr(module, "write_whole", stopping)
    assert "stopped here" in twonav(*SURVEY, "--quick", "--scene", room, "--out", folder).complaint
    assert not (folder / "card.json").exists()
    assert (folder / "map.yaml").exists() == (last == "map.yaml")


# Looking at a map


def some_map(path: Path) -> Path:
    from twonav_cli.grid import GridFrame

    pixels = np.full((32, 48), FREE, dtype=np.uint8)
    pixels[8, 8:40] = 0
    return save_map(OccupancyMap(GridFrame(-1.0, 2.0, 0.05, 32, 48), pixels), path)


def test_any_map_can_be_drawn_with_the_maze_that_is_made_from_it(twonav: Twonav, tmp_path: Path) -> None:
    path = some_map(tmp_path / "somewhere" / "map.yaml")
    for arguments in ([path], [path, "--map"]):
        ended = twonav("scenes", "show", *arguments)
        assert ended.code == 0
        assert "maze: 6 x 4 cells of 0.4 m, 20 free" in ended.out
        assert "#" in ended.out
    assert "--map-from is for scenes" in twonav("scenes", "show", path, "--map-from", "survey").complaint


def test_a_map_that_cannot_be_drawn_is_one_line(twonav: Twonav, tmp_path: Path) -> None:
    assert "there is no map at" in twonav("scenes", "show", tmp_path / "nowhere.yaml").complaint
    path = some_map(tmp_path / "map.yaml")
    path.with_suffix(".pgm").unlink()
    assert "picture" in twonav("scenes", "show", path).complaint
    path = some_map(tmp_path / "map.yaml")
    picture = path.with_suffix(".pgm")
    picture.write_bytes(picture.read_bytes().replace(b"\xfe", b"\x00"))
    assert "has no free pixel" in twonav("scenes", "show", path).complaint


@pytest.mark.parametrize("card", [None, {"kind": "map", "log": "robot.clf"}])
def test_a_map_that_is_no_scenes_is_not_written_over(
    twonav: Twonav, tmp_path: Path, card: dict[str, str] | None
) -> None:
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "map.pgm").write_bytes(b"P5 1 1 255 x")
    if card:
        (tmp_path / "other" / "card.json").write_text(json.dumps(card))
    ended = twonav("train", "--stage", "map", "--scene", "kitchen", "--no-record", "--out", tmp_path / "other")
    assert ended.code == 1
    assert "something else" in ended.err
    assert (tmp_path / "other" / "map.pgm").read_bytes() == b"P5 1 1 255 x"
