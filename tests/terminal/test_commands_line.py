"""The command line as a user meets it: one line for every mistake, one object for scripts."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from room_texts import ROOM, TWO_GOALS

from twonav_cli.paths import checkpoints_dir

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line", "small_room")

GOAL_IN_WALL = '<site name="goal/east" pos="2.05 0.2 0"/><site name="start/a" pos="-1.4 0.2 0"/>'


@pytest.fixture
def checkpoints(tmp_path: Path) -> Path:
    """Return a copy of the apartment's checkpoints that may be damaged."""
    folder = tmp_path / "copied"
    shutil.copytree(checkpoints_dir() / "apartment" / "maze", folder / "maze")
    return folder


def in_subprocess(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *arguments], capture_output=True, text=True, timeout=60, check=False)


# What is imported, and usage


def test_help_imports_nothing_heavy() -> None:
    probe = (
        "import sys\n"
        "from twonav_cli.terminal.app import app\n"
        "try:\n    app(['--help'])\n"
        "except SystemExit:\n    pass\n"
        "heavy = {'torch', 'mujoco', 'rerun', 'numba', 'textual', 'scipy', 'cv2', 'numpy'} & set(sys.modules)\n"
        "print('heavy:', sorted(heavy))\n"
    )
    ended = in_subprocess("-c", probe)
    assert "Usage:" in ended.stdout
    assert ended.stdout.splitlines()[-1] == "heavy: []", ended.stderr


def test_help_names_every_command(twonav: Twonav) -> None:
    ended = twonav("--help")
    assert ended.code == 0
    for command in ("play", "train", "evaluate", "inspect", "doctor", "scenes", "version"):
        assert re.search(rf"^\W*{command}\b", ended.out, re.MULTILINE)


def test_the_version_is_that_of_the_package(twonav: Twonav) -> None:
    from twonav_cli import __version__

    assert twonav("version").out == __version__ + "\n"


@pytest.mark.parametrize(
    "arguments", [["fly"], ["play", "--nowhere"], ["train"], ["play", "--seed", "-1"], ["inspect"]]
)
def test_wrong_usage_ends_with_2(twonav: Twonav, arguments: list[str]) -> None:
    assert twonav(*arguments).code == 2


# Names


@pytest.mark.parametrize(
    ("arguments", "nearest", "also"),
    [
        (["play", "--goal", "kichen", "--plain"], "kitchen", "wardrobe"),
        (["play", "--goal", "bed", "--start", "s11", "--plain"], "s1", "s10"),
        (["play", "--goal", "bed", "--scene", "apartmnt", "--plain"], "apartment", "kitchen"),
        (["play", "--goal", "bed", "--stage", "mase", "--plain"], "maze", "3d"),
        (["play", "--goal", "bed", "--base", "omnii", "--plain"], "omni", "differential"),
        (["play", "--goal", "bed", "--localizer", "rawr", "--plain"], "raw", "truth"),
        (["train", "--stage", "localiser"], "localizer", "3d"),
        (["train", "--stage", "3d", "--base", "diferential"], "differential", "omni"),
        (["train", "--stage", "maze", "--scene", "kitchin"], "kitchen", "apartment"),
        (["evaluate", "--stage", "mze"], "maze", "localizer"),
        (["evaluate", "--base", "omnii"], "omni", "differential"),
        (["evaluate", "--localizer", "thruth"], "truth", "raw"),
        (["scenes", "show", "kichen"], "kitchen", "apartment"),
    ],
)
def test_a_wrong_name_is_answered_with_the_nearest_and_all_others(
    twonav: Twonav, arguments: list[str], nearest: str, also: str
) -> None:
    complaint = twonav(*arguments).complaint
    assert f"did you mean '{nearest}'" in complaint
    assert re.search(rf"Known: .*\b{also}\b", complaint)


def test_play_without_a_terminal_needs_a_goal(twonav: Twonav) -> None:
    assert "--goal" in twonav("play", "--stage", "maze").complaint


# Scenes


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("<mujoco><worldbody>", "not well-formed XML"),
        ("", "not well-formed XML"),
        ("<mujoco><worldbody><box/></worldbody></mujoco>", "cannot be loaded"),
        (ROOM.format(sites=""), "declares no goal"),
        (ROOM.format(sites=GOAL_IN_WALL), "goal 'east' .* move it"),
        (ROOM.format(sites='<site name="goal/far" pos="9 0 0"/>'), "goal 'far' .* outside the map"),
    ],
    ids=["cut-off", "empty", "not-mjcf", "no-goal", "goal-in-wall", "goal-outside"],
)
@pytest.mark.parametrize("command", [["play", "--plain", "--goal", "east", "--scene"], ["scenes", "show"]])
def test_a_scene_that_cannot_be_used_is_one_line(
    twonav: Twonav, tmp_path: Path, content: str, said: str, command: list[str]
) -> None:
    path = tmp_path / "mine.xml"
    path.write_text(content)
    complaint = twonav(*command, path).complaint
    assert "mine.xml" in complaint or "goal" in complaint
    assert re.search(said, complaint)


def test_a_scene_that_is_not_there_is_one_line(twonav: Twonav, tmp_path: Path) -> None:
    assert "there is no scene at" in twonav("scenes", "show", tmp_path / "none.xml").complaint


def test_a_scene_of_ones_own_is_trained_and_played(twonav: Twonav, room: Callable[[str], Path], runs: Path) -> None:
    scene = room(TWO_GOALS)
    assert twonav("train", "--stage", "maze", "--scene", scene, "--no-record").code == 0
    assert (runs / "room" / "maze" / "card.json").is_file()
    ended = twonav("play", "--stage", "maze", "--scene", scene, "--goal", "west", "--plain", "--no-record")
    assert ended.code == 0
    assert "1 of 1 goals reached" in ended.out


def test_a_scene_of_ones_own_without_an_agent_says_how_to_make_one(twonav: Twonav, room: Callable[[str], Path]) -> None:
    ended = twonav("play", "--stage", "maze", "--scene", room(TWO_GOALS), "--goal", "west", "--plain", "--no-record")
    assert "twonav train --stage maze" in ended.complaint


# Checkpoints


def flip(path: Path, byte: int) -> None:
    content = bytearray(path.read_bytes())
    content[byte] ^= 1
    path.write_bytes(content)


@pytest.mark.parametrize(
    "damage",
    [
        lambda maze: flip(maze / "arrays.safetensors", 5000),
        lambda maze: (maze / "arrays.safetensors").write_bytes((maze / "arrays.safetensors").read_bytes()[:5000]),
        lambda maze: (maze / "arrays.safetensors").unlink(),
        lambda maze: (maze / "card.json").write_bytes((maze / "card.json").read_bytes()[:300]),
        lambda maze: (maze / "card.json").unlink(),
        lambda maze: (maze / "card.json").write_bytes(b"\xff\xfe\x00"),
    ],
    ids=["flipped", "truncated", "no-arrays", "card-truncated", "no-card", "card-of-bytes"],
)
@pytest.mark.parametrize("command", [["play", "--goal", "bed", "--plain", "--no-record"], ["evaluate", "--json"]])
def test_a_damaged_checkpoint_is_one_line_and_nothing_is_overwritten(
    twonav: Twonav, checkpoints: Path, damage: Callable[[Path], object], command: list[str]
) -> None:
    damage(checkpoints / "maze")
    before = {path: path.read_bytes() for path in checkpoints.rglob("*") if path.is_file()}
    ended = twonav(*command, "--stage", "maze", "--checkpoints", checkpoints)
    assert str(checkpoints) in ended.complaint
    assert {path: path.read_bytes() for path in checkpoints.rglob("*") if path.is_file()} == before


def test_going_on_from_a_damaged_checkpoint_is_refused_and_leaves_it(twonav: Twonav, checkpoints: Path) -> None:
    arrays = checkpoints / "maze" / "arrays.safetensors"
    flip(arrays, 5000)
    before = arrays.read_bytes()
    ended = twonav("train", "--stage", "maze", "--resume", "--no-record", "--out", checkpoints / "maze")
    assert "is damaged" in ended.complaint
    assert arrays.read_bytes() == before


def test_a_checkpoint_of_another_scene_is_one_line(twonav: Twonav, checkpoints: Path) -> None:
    ended = twonav(
        "play", "--scene", "kitchen", "--stage", "maze", "--goal", "stove", "--plain", "--no-record", "--checkpoints",
        checkpoints,
    )  # fmt: skip
    assert "another scene" in ended.complaint


# Playing, training, measuring


def test_playing_plainly_prints_a_line_per_action_and_a_summary(twonav: Twonav, runs: Path) -> None:
    ended = twonav("play", "--stage", "maze", "--goal", "kitchen", "--plain", "--no-record")
    assert (ended.code, ended.err) == (0, "")
    first, begun, *actions, reached, summary = ended.out.splitlines()
    assert first == "play apartment, stage maze, seed 0"
    assert begun.startswith("trial 0: to kitchen from")
    assert actions
    assert all(re.match(r"  0\.\d+ +\( *\d+, *\d+\) (up|down|left|right) ", line) for line in actions)
    assert reached.startswith(f"trial 0: kitchen in {len(actions)} actions")
    assert summary.startswith("summary: 1 of 1 goals reached;")
    assert not list(runs.rglob("*.rrd"))


def test_the_same_seed_plays_the_same_and_another_one_does_not(twonav: Twonav) -> None:
    def played(seed: int) -> str:
        return twonav(
            "play", "--stage", "maze", "--goal", "bed", "--seed", str(seed), "--plain", "--no-record"
        ).out.split("\n", 1)[1]

    assert played(1) == played(1)
    assert played(1) != played(2)


def test_a_named_start_is_where_the_robot_begins(twonav: Twonav) -> None:
    ended = twonav("play", "--stage", "maze", "--goal", "bed", "--start", "s1", "--plain", "--no-record")
    assert "trial 0: to bed from ( 4,23)" in ended.out  # 7.0 m, 7.7 m on the grid that begins at -2.4 m, 9.5 m


def test_training_can_be_gone_on_with_and_is_already_done(twonav: Twonav, tmp_path: Path) -> None:
    train = ["train", "--stage", "maze", "--scene", "kitchen", "--json", "--no-record", "--out", tmp_path / "agent"]
    first = twonav(*train)
    report = first.only_object()
    assert first.code == 0
    assert report["outcome"] == "learned"
    assert report["goals_learned"] == report["goals"] == 5
    again = twonav(*train, "--resume")
    assert again.code == 0
    assert again.only_object() == report


def test_an_interrupted_training_saves_and_goes_on_as_if_unbroken(
    twonav: Twonav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from twonav_cli.terminal import train_maze

    train = ["train", "--stage", "maze", "--scene", "kitchen", "--json", "--no-record", "--out"]
    unbroken = twonav(*train, tmp_path / "unbroken").only_object()

    def interrupted(*arguments: Any) -> Any:
        *others, should_stop = arguments
        asked = 0

        def stop_at_third() -> bool:
            nonlocal asked
            asked += 1
            if asked == 3:
                os.kill(os.getpid(), signal.SIGINT)
            return bool(should_stop())

        return learn_maze(*others, stop_at_third)

    learn_maze = train_maze.learn_maze
    monkeypatch.setattr(train_maze, "learn_maze", interrupted)
    broken = twonav(*train, tmp_path / "broken")
    assert broken.code == 130
    assert broken.only_object()["outcome"] == "stopped"
    assert broken.only_object()["steps"] < unbroken["steps"]
    assert "--resume --out" in broken.err
    monkeypatch.setattr(train_maze, "learn_maze", learn_maze)
    assert twonav(*train, tmp_path / "broken", "--resume").only_object() == unbroken
    arrays = [(tmp_path / name / "arrays.safetensors").read_bytes() for name in ("unbroken", "broken")]
    assert arrays[0] == arrays[1]


def test_going_on_without_a_checkpoint_is_one_line(twonav: Twonav, tmp_path: Path) -> None:
    ended = twonav("train", "--stage", "maze", "--resume", "--no-record", "--out", tmp_path / "none")
    assert "there is no checkpoint in" in ended.complaint


def test_training_in_3d_without_a_localizer_is_one_line(twonav: Twonav, room: Callable[[str], Path]) -> None:
    scene = room(TWO_GOALS)
    for stage in ("maze", "2d"):
        assert twonav("train", "--stage", stage, "--scene", scene, "--no-record").code == 0
    ended = twonav("train", "--stage", "3d", "--scene", scene, "--no-record")
    assert "twonav train --stage localizer" in ended.complaint


def test_an_evaluation_is_one_object(twonav: Twonav, tmp_path: Path) -> None:
    ended = twonav("evaluate", "--stage", "maze", "--json", "--record", tmp_path / "e.rrd")
    report = ended.only_object()
    assert ended.code == 0
    assert (report["pairs"], report["successes"], report["spl"]) == (100, 100, 1.0)
    assert list(report["per_goal"])[:2] == ["kitchen", "table"]
    assert (tmp_path / "e.rrd").stat().st_size > 0


# Recordings


@pytest.fixture
def recording(twonav: Twonav, tmp_path: Path) -> Path:
    path = tmp_path / "play.rrd"
    assert twonav("play", "--stage", "maze", "--goal", "bed", "--plain", "--record", path).code == 0
    return path


def test_a_recording_is_summarized_for_people_and_for_scripts(twonav: Twonav, recording: Path) -> None:
    shown = twonav("inspect", recording)
    assert shown.code == 0
    assert "play of scene apartment, stage maze, seed 0: 1 of 1 goals reached" in shown.out
    assert "rerun" in shown.out
    report = twonav("inspect", recording, "--json").only_object()
    (trial,) = report["trials"]
    assert (report["scene"], trial["goal"], trial["outcome"]) == ("apartment", "bed", "reached")


def test_play_prints_where_the_recording_is(twonav: Twonav, runs: Path) -> None:
    ended = twonav("play", "--stage", "maze", "--goal", "bed", "--plain")
    path = Path(ended.out.splitlines()[-1])
    assert path.is_file()
    assert path.is_relative_to(runs)


@pytest.mark.parametrize("content", [b"trials: many\n", b"", b"RRF2 and then nothing that makes sense"])
def test_a_file_that_is_no_recording_is_one_line(twonav: Twonav, tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "notes.rrd"
    path.write_bytes(content)
    assert "notes.rrd" in twonav("inspect", path).complaint


def test_a_recording_that_is_not_there_is_one_line(twonav: Twonav, tmp_path: Path) -> None:
    assert "none.rrd" in twonav("inspect", tmp_path / "none.rrd").complaint


@pytest.mark.parametrize("name", ["notes.txt", "file/below.rrd", "."])
def test_a_recording_that_cannot_be_written_is_one_line(twonav: Twonav, tmp_path: Path, name: str) -> None:
    (tmp_path / "file").write_text("")
    ended = twonav("play", "--stage", "maze", "--goal", "bed", "--plain", "--record", tmp_path / name)
    assert ended.complaint


# Scenes and doctor, for scripts


def test_the_scenes_are_one_object_with_every_goal(twonav: Twonav) -> None:
    scenes = {scene["name"]: scene for scene in twonav("scenes", "--json").only_object()["scenes"]}
    assert len(scenes["apartment"]["goals"]) == 10
    assert scenes["kitchen"]["goals"] == ["stove", "fridge", "table", "window", "shelf"]


def test_a_scene_is_drawn_with_its_goals(twonav: Twonav) -> None:
    ended = twonav("scenes", "show", "kitchen")
    assert ended.code == 0
    assert "stove" in ended.out
    assert len(ended.out.splitlines()) > 10


def test_the_doctor_is_one_object_and_finds_a_healthy_machine(twonav: Twonav) -> None:
    ended = twonav("doctor", "--json")
    report = ended.only_object()
    assert report["healthy"], report
    assert ended.code == 0
    assert report["renderer"].endswith("draws")
    assert set(report["scenes"]) >= {"apartment", "kitchen"}


def test_the_doctor_notices_a_damaged_checkpoint(
    twonav: Twonav, checkpoints: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    from twonav_cli.terminal import doctor

    shutil.copytree(checkpoints, tmp_path / "shipped" / "apartment")
    flip(tmp_path / "shipped" / "apartment" / "maze" / "arrays.safetensors", 5000)
    monkeypatch.setattr(doctor, "checkpoints_dir", lambda: tmp_path / "shipped")
    ended = twonav("doctor", "--json")
    assert ended.code == 1
    assert not ended.only_object()["healthy"]
    assert "is damaged" in ended.only_object()["checkpoints"]["apartment/maze"]


# As another process sees it


@pytest.mark.usefixtures("runs")
def test_a_mistake_is_one_line_on_standard_error_and_nothing_on_standard_output() -> None:
    ended = in_subprocess("-m", "twonav_cli", "play", "--goal", "bed", "--stage", "mase")
    assert (ended.returncode, ended.stdout) == (1, "")
    assert ended.stderr.count("\n") == 1
    assert "Traceback" not in ended.stderr


@pytest.mark.usefixtures("runs")
def test_a_reader_that_goes_away_is_no_traceback() -> None:
    command = (
        f"{sys.executable} -m twonav_cli play --stage maze --goal bed --goal kitchen --plain --no-record | head -1"
    )
    ended = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60, check=False)
    assert ended.stdout == "play apartment, stage maze, seed 0\n"
    assert "Traceback" not in ended.stderr
    assert "Exception" not in ended.stderr


def test_going_on_with_another_seed_or_stage_is_refused(twonav: Twonav, tmp_path: Path) -> None:
    train = ["train", "--scene", "kitchen", "--no-record", "--out", tmp_path / "run"]
    assert twonav(*train, "--stage", "maze", "--json").code == 0
    assert "seed 0" in twonav(*train, "--stage", "maze", "--resume", "--seed", "1").complaint
    assert "of stage maze" in twonav(*train, "--stage", "3d", "--resume").complaint


def test_every_requested_goal_must_be_reached_for_exit_code_0(twonav: Twonav, monkeypatch: pytest.MonkeyPatch) -> None:
    from twonav_cli.experiments import journey

    def visits(outcomes: list[str]) -> list[journey.Visit]:
        return [journey.Visit("kitchen", outcome, 3, 3) for outcome in outcomes]

    for outcomes, code in ((["reached", "reached"], 0), (["reached", "time-out"], 1), (["reached"], 1)):
        monkeypatch.setattr(journey.Journey, "run", lambda self, *a, found=outcomes: visits(found))
        goals = ["--goal", "kitchen", "--goal", "kitchen"]
        assert twonav("play", "--stage", "maze", *goals, "--plain", "--no-record").code == code
