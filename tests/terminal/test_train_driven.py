"""Training, measuring and playing in 2D from the command line, and what the stages need of one another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from room_texts import TWO_GOALS

from twonav_cli.checkpoint import read_card
from twonav_cli.paths import checkpoints_dir
from twonav_cli.recording.reader import summarize
from twonav_cli.terminal import train_all, train_driven
from twonav_cli.terminal.train import TrainRequest

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line", "small_room")


STARTS = '<site name="start/a" pos="-1.0 -0.8 0"/><site name="start/b" pos="0.6 -0.8 0"/>'


@pytest.fixture
def scene(room: Callable[[str], Path], twonav: Twonav) -> Path:
    """Return a small scene whose maze is learned."""
    path = room(TWO_GOALS + STARTS)
    assert twonav("train", "--stage", "maze", "--scene", path, "--no-record").code == 0
    return path


def test_an_agent_learns_on_in_2d_is_measured_there_and_can_be_watched(
    twonav: Twonav, runs: Path, scene: Path, tmp_path: Path
) -> None:
    name = scene.stem
    learned = twonav("train", "--stage", "2d", "--scene", scene, "--json", "--record", tmp_path / "t.rrd")
    assert (learned.code, learned.only_object()["outcome"]) == (0, "learned")
    card = read_card(runs / name / "2d")
    assert card["stage"] == "2d"
    assert card["settings"]["learning_rate"] == 0.1
    assert summarize(tmp_path / "t.rrd").kind == "2d"
    report = twonav(
        "evaluate", "--stage", "2d", "--scene", scene, "--checkpoints", runs / name, "--json",
        "--record", tmp_path / "e.rrd",
    ).only_object()  # fmt: skip
    assert report["successes"] == report["pairs"] > 0
    assert report["ratio"] < 1.5
    goal = next(iter(report["per_goal"]))
    played = twonav(
        "play", "--stage", "2d", "--scene", scene, "--checkpoints", runs / name, "--goal", goal, "--plain",
        "--record", tmp_path / "p.rrd",
    )  # fmt: skip
    assert played.code == 0
    assert summarize(tmp_path / "p.rrd").trials[0].outcome == "reached"


def test_without_the_stage_before_the_command_that_makes_it_is_named(twonav: Twonav, scene: Path) -> None:
    ended = twonav("train", "--stage", "3d", "--scene", scene, "--no-record")
    assert "twonav train --stage 2d" in ended.complaint


def test_the_card_of_an_agent_in_3d_names_the_localizer_that_it_learned_with(twonav: Twonav, runs: Path) -> None:
    ended = twonav("train", "--stage", "3d", "--scene", "kitchen", "--quick", "--json", "--no-record")
    assert (ended.code, ended.only_object()["outcome"]) == (0, "quick")
    localizer = read_card(checkpoints_dir() / "kitchen" / "localizer")
    assert read_card(runs / "kitchen" / "3d-quick")["localizer_sha256"] == localizer["sha256"]


def test_from_nothing_the_agent_is_another_one_and_lies_elsewhere(twonav: Twonav, runs: Path, scene: Path) -> None:
    train = ["train", "--stage", "2d", "--scene", scene, "--no-record", "--quick"]
    assert twonav(*train).code == twonav(*train, "--no-transfer").code == 0
    transferred, fresh = (read_card(runs / scene.stem / name) for name in ("2d-quick", "2d-no-transfer-quick"))
    assert "--no-transfer" in fresh["command"]
    assert "--no-transfer" not in transferred["command"]
    assert fresh["metrics"]["steps"] > 2 * transferred["metrics"]["steps"]


def test_a_run_that_was_stopped_goes_on_where_it_was(
    twonav: Twonav, runs: Path, scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    learn, asked = train_driven.learn_in_stage, []

    def stopped_early(stage, agent, seed, sink, should_stop, last):  # type: ignore[no-untyped-def]
        return learn(stage, agent, seed, sink, lambda: bool(asked.append(1)) or len(asked) > 20, last)

    train = ["train", "--stage", "2d", "--scene", scene, "--no-record", "--json"]
    with monkeypatch.context() as patch:
        patch.setattr(train_driven, "learn_in_stage", stopped_early)
        broken = twonav(*train)
    assert (broken.code, broken.only_object()["trials"]) == (130, 20)
    whole = twonav(*train, "--resume").only_object()
    assert whole["outcome"] == "learned"
    assert whole["trials"] > 20
    assert twonav(*train, "--resume").only_object()["trials"] == whole["trials"]


def test_all_trains_what_is_missing_in_order_and_ends_with_what_fails(
    twonav: Twonav, scene: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[TrainRequest] = []

    def noted(request: TrainRequest) -> int:
        asked.append(request)
        return 130 if request.stage == "localizer" else 0

    monkeypatch.setattr(train_all, "run_train", noted)
    ended = twonav("train", "--stage", "all", "--scene", scene, "--base", "differential", "--images", "900")
    assert ended.code == 130
    assert [request.stage for request in asked] == ["map", "2d", "localizer"]  # the maze is there already
    assert [request.base for request in asked] == ["differential", "differential", None]
    assert [request.images for request in asked] == [None, None, 900]
    assert "twonav train --stage all" in ended.err
