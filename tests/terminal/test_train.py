"""`twonav train --stage maze`: its options, going on with a run, random mazes, and the command that repeats a run."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from twonav_cli.checkpoint import read_card
from twonav_cli.config import LearningConfig, learning_preset
from twonav_cli.errors import TwonavError
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.learners import LEARNERS, learner_settings
from twonav_cli.random_maze import random_maze
from twonav_cli.terminal import train_maze
from twonav_cli.terminal.choices import check_choices
from twonav_cli.terminal.learning_choices import LearningChoices
from twonav_cli.terminal.train import TrainRequest

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line",)

TRAIN = ["train", "--stage", "maze", "--no-record"]
IN_KITCHEN = [*TRAIN, "--scene", "kitchen"]


def settings_in(folder: Path) -> dict[str, Any]:
    found = read_card(folder)["settings"]
    assert isinstance(found, dict)
    return found


# What is asked for


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--discount", "1"], "discount must be at least 0 and below 1: 1.0 was given"),
        (["--discount", "-0.5"], "discount must be at least 0"),
        (["--discount", "nan"], "discount must be"),
        (["--temperature", "0"], "temperature must be at least 1e-06: 0.0 was given"),
        (["--temperature", "inf"], "temperature must be at least 1e-06"),
        (["--initial-q", "inf"], "initial q must be between"),
        (["--initial-q", "nan"], "initial q must be between"),
        (["--learner", "mutli"], "did you mean 'multi'.*nearest-untried"),
        (["--preset", "paper-mase"], "did you mean 'paper-maze'.*Known: maze, paper-maze"),
        (["--preset", "3d"], "Known: maze, paper-maze"),
        (["--goal-selection", "td-eror"], "did you mean 'td-error'.*sequential"),
        (["--exploration", "bolzmann"], "did you mean 'boltzmann'.*epsilon-greedy"),
        (["--watch"], "--watch needs a terminal"),
        (["--random-maze", "2"], "leave --scene or --random-maze out"),
    ],
)
def test_what_cannot_be_is_one_line_and_nothing_is_trained(
    twonav: Twonav, runs: Path, arguments: list[str], said: str
) -> None:
    assert re.search(said, twonav(*IN_KITCHEN, *arguments).complaint)
    assert not (runs / "kitchen" / "maze").exists()


@pytest.mark.parametrize("stage", ["localizer", "3d"])
@pytest.mark.parametrize(
    "arguments",
    [
        ["--learner", "multi"],
        ["--preset", "maze"],
        ["--discount", "0.9"],
        ["--temperature", "2"],
        ["--initial-q", "80"],
        ["--goal-selection", "random"],
        ["--exploration", "boltzmann"],
        ["--random-maze", "1"],
        ["--watch"],
    ],
)
def test_other_stages_refuse_the_options_of_the_maze(twonav: Twonav, stage: str, arguments: list[str]) -> None:
    complaint = twonav("train", "--stage", stage, *arguments).complaint
    assert f"{arguments[0]} is for --stage maze only" in complaint


@pytest.mark.parametrize(
    ("stage", "arguments", "said"),
    [
        ("maze", ["--images", "5"], "--images is for --stage localizer only"),
        ("3d", ["--images", "5"], "--images is for --stage localizer only"),
        ("maze", ["--base", "omni"], "--base is for --stage map, 2d and 3d only"),
        ("localizer", ["--base", "differential"], "--base is for --stage map, 2d and 3d only"),
        ("maze", ["--no-transfer"], "--no-transfer is for --stage 2d and 3d only"),
        ("all", ["--resume"], "--resume is not for --stage all"),
        ("all", ["--out", "somewhere"], "--out is not for --stage all"),
        ("all", ["--quick"], "--quick is not for --stage all"),
    ],
)
def test_a_stage_refuses_what_it_does_not_use(twonav: Twonav, stage: str, arguments: list[str], said: str) -> None:
    assert said in twonav("train", "--stage", stage, *arguments).complaint


def test_the_command_of_3d_names_the_base_that_was_used() -> None:
    assert TrainRequest("3d").command().endswith("--base omni")
    assert TrainRequest("3d", base="differential").command().endswith("--base differential")


def test_a_negative_random_maze_is_wrong_usage(twonav: Twonav) -> None:
    assert twonav(*TRAIN, "--random-maze", "-1").code == 2


def test_watching_with_a_dumb_terminal_is_one_line(twonav: Twonav, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "dumb")
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    assert "--watch needs a terminal that can move its cursor" in twonav(*IN_KITCHEN, "--watch").complaint


def test_the_help_says_what_the_settings_say(twonav: Twonav) -> None:
    said = " ".join(twonav("train", "--help").out.split())
    for name in ("discount", "temperature", "goal_selection"):
        (field,) = [field for field in LearningConfig.__dataclass_fields__.values() if field.name == name]
        assert field.metadata["help"] in said
    assert all(name in said for name in LEARNERS)


def test_every_command_refuses_the_same_names_in_the_same_words() -> None:
    with pytest.raises(TwonavError, match="did you mean 'maze'"):
        check_choices("mase", ("maze", "3d"))
    with pytest.raises(TwonavError, match="unknown base"):
        check_choices("maze", ("maze", "3d"), base="legs")
    with pytest.raises(TwonavError, match="unknown localizer"):
        check_choices("maze", ("maze", "3d"), localizer="nose")


# Settings


def test_saying_nothing_is_the_preset_and_what_is_said_goes_over_the_learners_own() -> None:
    assert LearningChoices().config() == learning_preset("maze")
    assert LearningChoices(preset="paper-maze", temperature=3.0).config() == learning_preset(
        "paper-maze", temperature=3.0
    )
    assert LearningChoices(learner="single").config() == learning_preset("maze", learner="single")
    chosen = LearningChoices(learner="optimistic", discount=0.8).config()
    assert chosen == learner_settings("optimistic", "maze", discount=0.8)
    assert chosen.initial_q == LEARNERS["optimistic"].changes["initial_q"]


def test_what_was_chosen_is_what_the_agent_learns_with(twonav: Twonav, tmp_path: Path) -> None:
    chosen = ["--learner", "single", "--preset", "paper-maze", "--temperature", "3", "--goal-selection", "sequential"]
    ended = twonav(*IN_KITCHEN, *chosen, "--out", tmp_path / "a")
    assert ended.code == 0
    settings = settings_in(tmp_path / "a")
    assert (settings["learner"], settings["discount"], settings["temperature"]) == ("single", 0.99, 3.0)
    assert settings["goal_selection"] == "sequential"


@pytest.mark.parametrize(
    "arguments",
    [
        ["--scene", "kitchen"],
        ["--scene", "kitchen", "--learner", "optimistic", "--discount", "0.9", "--seed", "3"],
        ["--random-maze", "2", "--preset", "paper-maze", "--goal-selection", "random", "--initial-q", "90.5"],
    ],
)
def test_the_command_on_the_card_repeats_the_run(twonav: Twonav, tmp_path: Path, arguments: list[str]) -> None:
    assert twonav(*TRAIN, *arguments, "--out", tmp_path / "a").code == 0
    command = shlex.split(read_card(tmp_path / "a")["command"])
    assert command[:2] == ["twonav", "train"]
    assert twonav(*command[1:], "--no-record", "--out", tmp_path / "b").code == 0
    assert len({(tmp_path / name / "arrays.safetensors").read_bytes() for name in "ab"}) == 1
    assert settings_in(tmp_path / "a") == settings_in(tmp_path / "b")


def test_the_command_leaves_out_what_was_not_said() -> None:
    assert TrainRequest("maze").command() == "twonav train --stage maze --scene apartment --seed 0"
    request = TrainRequest("maze", random_maze=4, watch=True, choices=LearningChoices(exploration="boltzmann"))
    assert request.command() == "twonav train --stage maze --random-maze 4 --seed 0 --exploration boltzmann"
    assert request.resume_command().endswith(" --exploration boltzmann --resume")


# Going on with a run


def test_a_run_is_gone_on_with_its_own_settings_or_the_same_ones(twonav: Twonav, tmp_path: Path) -> None:
    run = [*IN_KITCHEN, "--out", tmp_path / "a"]
    chosen = ["--learner", "optimistic", "--discount", "0.9"]
    assert twonav(*run, *chosen).code == 0
    assert twonav(*run, "--resume").code == 0
    assert twonav(*run, "--resume", *chosen).code == 0
    assert settings_in(tmp_path / "a")["discount"] == 0.9
    assert read_card(tmp_path / "a")["command"].endswith(" ".join(chosen))


def test_other_settings_than_the_runs_are_refused_with_what_differs(twonav: Twonav, tmp_path: Path) -> None:
    run = [*IN_KITCHEN, "--out", tmp_path / "a"]
    assert twonav(*run).code == 0
    before = (tmp_path / "a" / "card.json").read_bytes()
    complaint = twonav(*run, "--resume", "--discount", "0.9", "--learner", "single").complaint
    assert "learner multi where single is asked for, discount 0.95 where 0.9 is asked for" in complaint
    assert "temperature" not in complaint
    assert (tmp_path / "a" / "card.json").read_bytes() == before


# Random mazes


def test_a_random_maze_is_learned_and_its_agent_belongs_to_no_scene(twonav: Twonav, runs: Path) -> None:
    ended = twonav(*TRAIN, "--random-maze", "3", "--seed", "1", "--json")
    report = ended.only_object()
    assert (ended.code, report["scene"], report["goals_learned"]) == (0, "random-3", 10)
    folder = runs / "random-1-3" / "maze"
    card = read_card(folder)
    assert (card["scene"], card["random_maze"], card["seed"]) == ("random-3", 3, 1)
    Agent.load(folder).check_fits(random_maze(1, 3))
    for scene in ("apartment", "kitchen"):
        ended = twonav("evaluate", "--stage", "maze", "--scene", scene, "--checkpoints", runs / "random-1-3")
        assert "was made for another scene" in ended.complaint


def test_another_random_maze_is_not_gone_on_with(twonav: Twonav, tmp_path: Path) -> None:
    run = [*TRAIN, "--out", tmp_path / "a"]
    assert twonav(*run, "--random-maze", "3").code == 0
    assert twonav(*run, "--random-maze", "3", "--resume").code == 0
    assert "random-3" in twonav(*run, "--random-maze", "4", "--resume").complaint
    assert "random-3" in twonav(*run, "--scene", "kitchen", "--resume").complaint


def test_a_run_in_a_random_maze_is_recorded_with_its_settings(twonav: Twonav, tmp_path: Path) -> None:
    path = tmp_path / "r.rrd"
    train = ["train", "--stage", "maze", "--random-maze", "0", "--learner", "oracle", "--record", path]
    assert twonav(*train, "--out", tmp_path / "a").code == 0
    assert "train of scene random-0, stage maze, seed 0: learned" in twonav("inspect", path).out
    found = json.loads(twonav("inspect", path, "--json").out)
    assert found["scene"] == "random-0"
    assert found["settings"]["discount"] == "0.95"
    assert found["settings"]["trial limit steps"] == "500"


# What was learned is not lost


@pytest.mark.parametrize("place", [["--scene", "kitchen"], ["--random-maze", "0"]])
def test_a_folder_that_cannot_be_written_is_said_before_anything_is_learned(
    twonav: Twonav, tmp_path: Path, place: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def not_called(*_: Any) -> None:
        raise AssertionError("something was learned")

    monkeypatch.setattr(train_maze, "learn_maze", not_called)
    (tmp_path / "file").write_text("in the way")
    assert "name another --out" in twonav(*TRAIN, *place, "--out", tmp_path / "file" / "out").complaint


def test_a_run_that_has_learned_everything_is_left_as_it_is_and_not_recorded(
    twonav: Twonav, tmp_path: Path, runs: Path
) -> None:
    run = ["train", "--stage", "maze", "--scene", "kitchen", "--out", tmp_path / "a"]
    assert twonav(*run, "--no-record").code == 0
    before = {path.name: (path.stat().st_mtime_ns, path.read_bytes()) for path in (tmp_path / "a").iterdir()}
    ended = twonav(*run, "--resume")
    assert ended.code == 0
    assert "already learned: nothing left to do" in ended.err
    assert "done" not in ended.err
    assert before == {path.name: (path.stat().st_mtime_ns, path.read_bytes()) for path in (tmp_path / "a").iterdir()}
    assert not (runs / "recordings").exists()


def test_the_same_number_of_another_seed_is_another_maze_with_a_folder_of_its_own(twonav: Twonav, runs: Path) -> None:
    for seed in ("0", "1"):
        assert twonav(*TRAIN, "--random-maze", "3", "--seed", seed).code == 0
    assert [read_card(runs / f"random-{seed}-3" / "maze")["seed"] for seed in (0, 1)] == [0, 1]


def test_an_unfinished_run_of_other_settings_is_not_written_over(
    twonav: Twonav, runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped_at_once(*arguments: Any) -> Any:
        return learn_maze(*arguments[:-1], lambda: True)

    learn_maze = train_maze.learn_maze
    monkeypatch.setattr(train_maze, "learn_maze", stopped_at_once)
    assert twonav(*IN_KITCHEN, "--discount", "0.9").code == 130
    before = (runs / "kitchen" / "maze" / "card.json").read_bytes()
    complaint = twonav(*IN_KITCHEN, "--discount", "0.8").complaint
    assert "an unfinished run of other settings is in" in complaint
    assert "--discount 0.9 --resume" in complaint
    assert (runs / "kitchen" / "maze" / "card.json").read_bytes() == before
    monkeypatch.setattr(train_maze, "learn_maze", learn_maze)
    assert twonav(*IN_KITCHEN, "--discount", "0.8", "--out", tmp_path / "a").code == 0
    assert twonav(*IN_KITCHEN, "--discount", "0.9", "--resume").code == 0
    assert twonav(*IN_KITCHEN, "--discount", "0.8").code == 0, "a finished run is replaced as before"


def test_a_run_into_a_pipe_ends_with_whole_lines(twonav: Twonav, tmp_path: Path) -> None:
    err = twonav(*IN_KITCHEN, "--out", tmp_path / "a").err
    assert "done:" in err
    assert "…" not in err
    assert "━" not in err
