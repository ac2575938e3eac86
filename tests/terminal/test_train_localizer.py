"""`twonav train --stage frames` and `--stage localizer`, `twonav evaluate --stage localizer`: on very few frames."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from command_line import Twonav

from twonav_cli.checkpoint import read_card, signed
from twonav_cli.dataset.plan import PlanConfig
from twonav_cli.experiments.localizer_report import ReportConfig
from twonav_cli.localizer.training_state import STATE_FILE
from twonav_cli.terminal import train_frames, train_localizer

pytest_plugins = ("command_line",)

TRAIN = ("train", "--scene", "kitchen", "--quick", "--no-record")


@pytest.fixture(autouse=True)
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make a quick run a very quick one."""
    monkeypatch.setattr(train_frames, "QUICK_PLAN", PlanConfig(180, 300, 30, 0.005))
    monkeypatch.setattr(train_localizer, "QUICK_IMAGES", 512)
    monkeypatch.setattr(train_localizer, "QUICK_REPORT", ReportConfig(20, 30, 60, 15))


def test_frames_are_taken_and_found_again(twonav: Twonav) -> None:
    first = twonav(*TRAIN, "--stage", "frames", "--json").only_object()
    assert first["outcome"] == "collected"
    assert first["random_frames"] > 330
    assert first["grid_frames"] > 200
    frames = Path(first["random_folder"]) / "frames.npy"
    taken = frames.stat().st_mtime_ns
    assert twonav(*TRAIN, "--stage", "frames", "--json").only_object() == first
    assert frames.stat().st_mtime_ns == taken


def test_our_network_is_trained_measured_and_then_left_alone(twonav: Twonav, runs: Path) -> None:
    found = twonav(*TRAIN, "--stage", "localizer", "--json").only_object()
    assert found["outcome"] == "quick"
    assert {"off_grid", "held_cells", "paper_split", "belief", "tracks", "kidnaps", "off_grid_nearest"} <= set(found)
    folder = runs / "kitchen" / "localizer-quick"
    arrays = (folder / "arrays.safetensors").read_bytes()
    again = twonav(*TRAIN, "--stage", "localizer", "--resume", "--json").only_object()
    assert again["outcome"] == "learned"
    assert again["off_grid"] == found["off_grid"]
    assert (folder / "arrays.safetensors").read_bytes() == arrays


def test_a_kill_while_measuring_costs_no_training(twonav: Twonav, runs: Path) -> None:
    twonav(*TRAIN, "--stage", "localizer")
    folder = runs / "kitchen" / "localizer-quick"
    card = read_card(folder)
    whole = dict(card["metrics"])
    for name in ("settings", "tracks", "kidnaps"):
        card["metrics"].pop(name)
    (folder / "card.json").write_text(json.dumps(signed(card)))
    arrays = (folder / "arrays.safetensors").read_bytes()
    twonav(*TRAIN, "--stage", "localizer", "--resume")
    assert (folder / "arrays.safetensors").read_bytes() == arrays
    assert read_card(folder)["metrics"]["tracks"] == whole["tracks"]
    assert not (folder / STATE_FILE).exists()


def test_one_of_the_papers_networks_lies_beside_ours_and_gives_no_belief(twonav: Twonav, runs: Path) -> None:
    found = twonav(*TRAIN, "--stage", "localizer", "--network", "cnn-7", "--json").only_object()
    assert found["paper_split"]["n"] > 0
    assert "belief" not in found
    assert (runs / "kitchen" / "localizer-cnn-7-quick" / "card.json").is_file()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--stage", "localizer", "--network", "inception9"], "did you mean 'inception-9'"),
        (["--stage", "localizer", "--device", "tpu"], "device"),
        (["--stage", "maze", "--network", "cnn-7"], "--network is for --stage localizer only"),
        (["--stage", "frames", "--device", "cpu"], "--device is for --stage localizer only"),
    ],
)
def test_what_cannot_be_is_one_line(twonav: Twonav, runs: Path, arguments: list[str], said: str) -> None:
    assert said in twonav("train", "--scene", "kitchen", "--no-record", *arguments).complaint
    assert not runs.exists() or not list(runs.rglob("frames.npy"))


def test_evaluating_prints_errors_beliefs_tracks_and_kidnaps(twonav: Twonav, runs: Path) -> None:
    twonav(*TRAIN, "--stage", "localizer")
    (runs / "kitchen" / "localizer-quick").rename(runs / "kitchen" / "localizer")
    ended = twonav(
        "evaluate", "--stage", "localizer", "--scene", "kitchen", "--checkpoints", runs / "kitchen",
        "--frames", "20", "--track-frames", "20", "--kidnap-frames", "60",
    )  # fmt: skip
    assert ended.code == 0
    for said in ("random poses", "held-out cells", "paper's split", "90 % region", "ROC", "filtered", "kidnapped"):
        assert said in " ".join(ended.out.split())


def test_an_unfinished_training_is_not_written_over(twonav: Twonav, runs: Path) -> None:
    folder = runs / "kitchen" / "localizer-quick"
    folder.mkdir(parents=True)
    (folder / STATE_FILE).write_bytes(b"hours of work")
    assert "an unfinished training is in" in twonav(*TRAIN, "--stage", "localizer").complaint
    assert (folder / STATE_FILE).read_bytes() == b"hours of work"
    assert "damaged" in twonav(*TRAIN, "--stage", "localizer", "--resume").complaint


def test_going_on_with_a_network_of_other_settings_names_them(
    twonav: Twonav, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    twonav(*TRAIN, "--stage", "localizer")
    assert "images 512 and not 700" in twonav(*TRAIN, "--stage", "localizer", "--images", "700", "--resume").complaint


@pytest.mark.parametrize("option", ["--network", "--frames", "--track-frames", "--kidnap-frames"])
def test_other_stages_do_not_take_the_localizers_options(twonav: Twonav, option: str) -> None:
    value = "cnn-7" if option == "--network" else "5"
    said = f"{option} is for --stage localizer only"
    assert said in twonav("evaluate", "--stage", "maze", "--scene", "kitchen", option, value).complaint


def test_the_advice_for_a_missing_network_is_a_command_that_exists(twonav: Twonav, runs: Path) -> None:
    said = twonav("evaluate", "--stage", "localizer", "--scene", "kitchen", "--network", "cnn-9").complaint
    assert "`twonav train --stage localizer --scene kitchen --network cnn-9`" in said
    assert "unknown network" in twonav("evaluate", "--stage", "localizer", "--network", "bogus").complaint
