"""`twonav reproduce table3 | table4 | fig7` as a user meets it, with tiny trainings on made-up frames."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from made_up_localizers import grid_store, made_up_floor, made_up_maps, made_up_report, random_store

from twonav_cli.checkpoint import load_checkpoint, read_card, save_checkpoint
from twonav_cli.dataset.plan import GRID_SET
from twonav_cli.dataset.store import FrameStore
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.localizer.training import train
from twonav_cli.localizer.training_config import TrainingConfig, training_settings
from twonav_cli.terminal import console, localizer_rows, reproduce_localizers, reproduced_localizers

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line",)

IMAGES = 16
TINY = {"batch": 8, "part": 8, "precision": "float32", "nearest_frames": 0}


def tiny_budget(network: str, scene: str, request: LocalizerRequest) -> TrainingConfig:
    images = request.images or IMAGES
    name = network if network.startswith(("cnn", "inception")) else "cnn-7"  # an autoencoder takes seconds to write
    return replace(training_settings(name, images=images, **TINY), network=name)


def taken(floor: Any, name: str, seed: int, quick: bool, should_stop: Callable[[], bool]) -> FrameStore:
    return grid_store(floor.scene.name) if name == GRID_SET else random_store(floor.scene.name)


def taken_store(folder: Path) -> FrameStore:
    scene = folder.parent.name
    return grid_store(scene) if GRID_SET in folder.name else random_store(scene)


def nothing_is_there(*_: Any, **__: Any) -> Any:
    raise TwonavError("there is none here")


def not_called(*_: Any, **__: Any) -> Any:
    raise AssertionError("something was done that was not asked for")


@pytest.fixture(autouse=True)
def _made_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """Put made-up rooms and frames and tiny trainings in place of the real ones, on a terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    console.out.cache_clear()
    console.err.cache_clear()
    monkeypatch.setattr(reproduce_localizers, "read_floor", lambda scene, *_, **__: made_up_floor(scene))
    monkeypatch.setattr(localizer_rows, "collected", taken)
    monkeypatch.setattr(localizer_rows, "budget", tiny_budget)
    monkeypatch.setattr(localizer_rows, "checkpoint_folder", nothing_is_there)


@pytest.fixture
def belief(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put our network, trained for a moment, where a scene's localizer is looked for."""
    frames = random_store("apartment")
    config = training_settings("belief", images=16, **TINY)
    folder = train((frames, frames.training()), tmp_path / "belief", config, 0)
    assert folder is not None
    monkeypatch.setattr(localizer_rows, "checkpoint_folder", lambda *_: folder)
    return folder


KITCHEN_7 = ["reproduce", "table4", "--scene", "kitchen", "--networks", "cnn-7"]


def row_of(report: dict[str, Any], network: str) -> dict[str, Any]:
    (row,) = [row for row in report["rows"] if row["network"] == network]
    assert isinstance(row, dict)
    return row


# A table


def test_a_missing_network_is_trained_and_stands_beside_the_paper(twonav: Twonav, runs: Path) -> None:
    ended = twonav(*KITCHEN_7)
    assert ended.code == 0
    lines = ended.out.splitlines()
    assert max(map(len, lines)) <= 80
    assert lines[-1] == "twonav reproduce table4 --seed 0 --scene kitchen --networks cnn-7"
    assert "0.066 0.087" in ended.out  # the paper's
    report = json.loads((runs / "reproduce" / "table4.json").read_text())
    row = row_of(report, "cnn-7")
    assert row["paper"]["pos_mean_m"] == 0.066
    assert f"{row['ours']['paper_split']['pos_mean_m']:.3f}" in ended.out
    assert {name: errors["n"] for name, errors in row["ours"].items()} == {
        "paper_split": 36, "off_grid": 20, "held_cells": 10,
    }  # fmt: skip
    assert row["training"]["images"] == IMAGES
    assert row["training"]["epochs"] == round(IMAGES / 60, 2)
    assert {"seconds", "device", "precision", "parameters"} <= set(row["training"])
    assert (runs / "reproduce" / "table4.png").read_bytes().startswith(b"\x89PNG")
    assert str(runs / "reproduce" / "table4.png") in ended.err
    assert read_card(runs / "reproduce-localizers" / "kitchen" / "cnn-7")["command"] == lines[-1]


def test_a_finished_network_is_used_again(twonav: Twonav, runs: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    twonav(*KITCHEN_7)
    monkeypatch.setattr(localizer_rows, "train_row", not_called)
    monkeypatch.setattr(localizer_rows, "nearest_locator", lambda _: _Unused())
    first = (runs / "reproduce" / "table4.json").read_text()
    assert twonav(*KITCHEN_7, "--device", "cpu").code == 0
    again = json.loads((runs / "reproduce" / "table4.json").read_text())
    assert row_of(again, "cnn-7") == row_of(json.loads(first), "cnn-7")


class _Unused:
    """A locator that is the most alike frame by name, and must not be asked."""

    identity = localizer_rows.nearest_locator((grid_store("kitchen"), grid_store("kitchen").training())).identity
    place = not_called
    portion = 1


def test_a_finished_network_of_other_settings_is_refused_in_one_line(twonav: Twonav) -> None:
    twonav(*KITCHEN_7)
    said = twonav(*KITCHEN_7, "--images", "24").complaint
    assert "images 16 and not 24" in said
    assert "cnn-7" in said
    assert "delete the folder to train it anew" in said


def test_networks_of_the_table_that_are_refused_stop_everything_before_a_training(
    twonav: Twonav, monkeypatch: pytest.MonkeyPatch
) -> None:
    twonav("reproduce", "table4", "--scene", "apartment", "--networks", "cnn-7")
    monkeypatch.setattr(localizer_rows, "train_row", not_called)
    assert "images 16 and not 24" in twonav("reproduce", "table4", "--networks", "cnn-7", "--images", "24").complaint


def test_only_finished_trains_nothing_and_takes_no_frames(
    twonav: Twonav, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    twonav(*KITCHEN_7)
    for name in ("train_row", "collected"):
        monkeypatch.setattr(localizer_rows, name, not_called)
    ended = twonav("reproduce", "table4", "--scene", "kitchen", "--only-finished")
    assert ended.code == 0
    assert ended.out.count("not trained") == 6
    report = json.loads((runs / "reproduce" / "table4.json").read_text())
    assert [row["network"] for row in report["rows"] if row["ours"]] == ["cnn-7"]
    assert "belief and nearest: there are no frames in" in report["settings"]["scenes"]["kitchen"]["notes"][0]


def test_json_is_the_only_thing_on_standard_output(twonav: Twonav, runs: Path) -> None:
    report = twonav(*KITCHEN_7, "--json").only_object()
    assert report == json.loads((runs / "reproduce" / "table4.json").read_text())
    assert {"table", "title", "rows", "errata", "settings"} == set(report)


def test_a_quick_table_lies_beside_the_full_one(twonav: Twonav, runs: Path) -> None:
    twonav(*KITCHEN_7, "--quick")
    twonav(*KITCHEN_7)
    assert {path.name for path in (runs / "reproduce").iterdir()} == {
        "table4.json", "table4.png", "table4-quick.json", "table4-quick.png",
    }  # fmt: skip
    assert (runs / "reproduce-localizers" / "kitchen" / "cnn-7-quick" / "card.json").is_file()


def test_the_most_alike_frame_and_our_network_stand_at_the_end(twonav: Twonav, runs: Path, belief: Path) -> None:
    twonav("reproduce", "table4", "--scene", "apartment", "--networks", "cnn-7")
    report = json.loads((runs / "reproduce" / "table4.json").read_text())
    assert [row["network"] for row in report["rows"]] == ["cnn-7", "belief", "nearest"]
    ours, nearest = row_of(report, "belief"), row_of(report, "nearest")
    assert ours["training"]["folder"] == str(belief)
    assert ours["paper"] is nearest["paper"] is nearest["training"] is None
    for row in (ours, nearest):
        assert {name: errors["n"] for name, errors in row["ours"].items()} == {
            "paper_split": 36, "off_grid": 20, "held_cells": 10,
        }  # fmt: skip


@pytest.mark.parametrize("changed", [{"seed": 1}, {"map_digest": "of another map"}, {"map_digest": None}])
def test_our_network_is_not_measured_in_held_out_cells_that_it_may_have_seen(
    twonav: Twonav, runs: Path, belief: Path, changed: dict[str, Any]
) -> None:
    arrays, card = load_checkpoint(belief, "localizer")
    save_checkpoint(belief, arrays, {**card, **changed})
    ended = twonav("reproduce", "table4", "--scene", "apartment", "--networks", "cnn-7")
    report = json.loads((runs / "reproduce" / "table4.json").read_text())
    assert set(row_of(report, "belief")["ours"]) == {"paper_split", "off_grid"}
    for network in ("cnn-7", "nearest"):
        assert set(row_of(report, network)["ours"]) == {"paper_split", "off_grid", "held_cells"}
    said = "apartment, not measured: belief in held-out cells: it was trained with another seed or on another map"
    assert said in " ".join(ended.out.split())


def test_frames_of_another_map_are_not_used(
    twonav: Twonav, runs: Path, belief: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def taken_before(folder: Path, scene_digest: str) -> FrameStore:
        store = taken_store(folder)
        return replace(store, meta={**store.meta, "map_digest": "of an older survey"})

    monkeypatch.setattr(localizer_rows, "open_store", taken_before)
    ended = twonav("reproduce", "table4", "--scene", "apartment", "--only-finished")
    assert "were taken on another map: delete it to take them anew" in " ".join(ended.out.split())
    report = json.loads((runs / "reproduce" / "table4.json").read_text())
    assert {row["network"] for row in report["rows"]}.isdisjoint({"belief", "nearest"})


def test_another_network_in_place_of_ours_is_no_row_of_ours(
    twonav: Twonav, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    twonav(*KITCHEN_7)
    folder = runs / "reproduce-localizers" / "kitchen" / "cnn-7"
    monkeypatch.setattr(localizer_rows, "checkpoint_folder", lambda *_: folder)
    out = " ".join(twonav(*KITCHEN_7).out.split())
    assert "not measured: belief: the localizer in" in out
    assert "is another network" in out


# Stopping


def test_stopping_in_a_training_says_how_to_go_on_and_goes_on(
    twonav: Twonav, runs: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []
    shown = localizer_rows.fitting_bar

    def interrupted(*arguments: Any) -> Any:
        show = shown(*arguments)

        def show_and_interrupt(event: Any) -> None:
            asked.append(1)
            if len(asked) == 1:
                os.kill(os.getpid(), signal.SIGINT)
            show(event)

        return show_and_interrupt

    monkeypatch.setattr(localizer_rows, "fitting_bar", interrupted)
    ended = twonav(*KITCHEN_7, "--images", str(8 * 21), "--out", tmp_path / "out")
    assert ended.code == 130
    assert "nothing is written of table4; what is trained is kept" in ended.err
    go_on = "twonav reproduce table4 --seed 0 --images 168 --scene kitchen --networks cnn-7 --out"
    assert f"go on with: {go_on} {tmp_path / 'out'}" in ended.err
    assert list((tmp_path / "out").iterdir()) == []
    folder = runs / "reproduce-localizers" / "kitchen" / "cnn-7"
    assert [path.name for path in folder.iterdir()] == ["training.safetensors"]
    assert twonav(*KITCHEN_7, "--images", str(8 * 21), "--out", tmp_path / "out").code == 0
    assert (folder / "card.json").is_file()


def test_stopping_while_measuring_keeps_the_trained_network(
    twonav: Twonav, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: Any, **__: Any) -> Any:
        raise localizer_rows.StoppedError

    monkeypatch.setattr(localizer_rows, "placed", stopped)
    assert twonav(*KITCHEN_7).code == 130
    assert (runs / "reproduce-localizers" / "kitchen" / "cnn-7" / "card.json").is_file()
    assert list((runs / "reproduce").iterdir()) == []


def test_stopping_among_finished_networks_says_how_to_go_on_with_those_only(
    twonav: Twonav, monkeypatch: pytest.MonkeyPatch
) -> None:
    def stopped(*_: Any, **__: Any) -> Any:
        raise localizer_rows.StoppedError

    monkeypatch.setattr(localizer_rows, "open_store", lambda folder, _: taken_store(folder))
    monkeypatch.setattr(localizer_rows, "placed", stopped)
    ended = twonav(*KITCHEN_7, "--only-finished")
    assert ended.code == 130
    assert ended.err.splitlines()[-1].endswith("--scene kitchen --networks cnn-7 --only-finished")


def test_a_training_that_was_begun_with_another_budget_stops_everything_before_frames_are_taken(
    twonav: Twonav, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    config = tiny_budget("cnn-9", "kitchen", LocalizerRequest("table4", images=32))
    frames, folder = grid_store("kitchen"), runs / "reproduce-localizers" / "kitchen" / "cnn-9"
    assert train((frames, frames.training()), folder, config, 0, should_stop=lambda: True) is None
    monkeypatch.setattr(localizer_rows, "collected", not_called)
    said = twonav("reproduce", "table4", "--networks", "cnn-7,cnn-9").complaint
    assert "was begun with 32 pictures and not 16: go on with --images 32, or delete the folder" in said


# Fig. 7


def test_fig_7_has_a_map_for_each_network_and_a_recording(twonav: Twonav, runs: Path, belief: Path) -> None:
    ended = twonav("reproduce", "fig7", "--networks", "inception-9")
    assert ended.code == 0
    assert max(map(len, ended.out.splitlines())) <= 80
    folder = runs / "reproduce"
    assert {path.name for path in folder.iterdir()} == {"fig7.json", "fig7.png", "fig7.rrd"}
    report = json.loads((folder / "fig7.json").read_text())
    assert [one["network"] for one in report["maps"]] == ["inception-9", "belief", "nearest"]
    for one in report["maps"]:
        assert (one["summary"]["cells"], one["summary"]["frames"]) == (12, 36)
        assert len(one["cells"]) == 12
        assert one["summary"]["min_m"] <= one["summary"]["median_m"] <= one["summary"]["max_m"]
    assert report["maps"][0]["paper"] == {"min_m": 0.12, "max_m": 0.56}
    assert "0.12 0.56" in " ".join(ended.out.split())
    inspected = twonav("inspect", folder / "fig7.rrd")
    assert inspected.code == 0
    assert "reproduce of scene apartment, stage fig7, seed 0" in inspected.out


def test_fig_7_without_any_frames_says_what_is_missing(twonav: Twonav, runs: Path) -> None:
    ended = twonav("reproduce", "fig7", "--only-finished")
    assert ended.code == 0
    assert ended.out.count("not trained") == 2
    assert "0.43 1.60" in " ".join(ended.out.split())
    assert {path.name for path in (runs / "reproduce").iterdir()} == {"fig7.json"}


# What is asked for


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (
            ["table3", "--repeats", "2"],
            "--repeats is for table5, table6, table7, table8, fig8, sensitivity, table9, table10: table3",
        ),
        (["table3", "--mazes", "2"], "--mazes is for table5, table6, sensitivity: table3 does not use it"),
        (["table4", "--discount", "0"], "--discount is for table5"),
        (["table4", "--cooling", "once"], "--cooling is for table5"),
        (["fig7", "--processes", "2"], "--processes is for table5"),
        (["table3", "--networks", "cnn-7"], "unknown network of table3 'cnn-7'"),
        (["table4", "--networks", ""], "--networks names no network: name some, as in cnn-7,inception-9"),
        (["table4", "--networks", " ,"], "--networks names no network"),
        (["fig7", "--scene", "kitchen"], "unknown scene of fig7 'kitchen'"),
        (["table4", "--device", "tpu"], "unknown device 'tpu'"),
    ],
)
def test_what_a_table_of_localizers_does_not_use_is_one_line(
    twonav: Twonav, arguments: list[str], complaint: str
) -> None:
    assert complaint in twonav("reproduce", *arguments).complaint


def test_help_says_that_all_are_the_tables_about_mazes(twonav: Twonav) -> None:
    said = " ".join(twonav("reproduce", "--help").out.split())
    assert "Those about mazes take two minutes together (all)." in said
    assert "table3" in said


# What is printed


@pytest.mark.parametrize("table", ["table3", "table4"])
def test_a_whole_table_fits_80_columns_with_its_errata(table: str, capsys: pytest.CaptureFixture[str]) -> None:
    report = made_up_report(table, notes=("belief: none",))
    reproduced_localizers.print_errors(report)
    out = capsys.readouterr().out
    assert max(map(len, out.splitlines())) <= 80
    assert "…" not in out
    words = " ".join(out.split())
    for mark, erratum in zip("abcdefgh", report.errata, strict=False):
        assert f"({mark}) {erratum['row']}: {erratum['text']}" in words
    assert "Epochs are a budget, not the paper's 10,000; one training of each network; seed 0." in words
    assert "12,000 training frames labelled by the mapper; 7,200 test frames on the grid" in words
    assert "kitchen, not measured: belief: none" in words


def test_errata_are_marked_beside_their_rows(capsys: pytest.CaptureFixture[str]) -> None:
    reproduced_localizers.print_errors(made_up_report("table4"))
    lines = capsys.readouterr().out.splitlines()
    beside = [line for line in lines if line.startswith("inception-9 ")]
    assert beside[0].split()[-2:] == ["a", "b"]


def test_a_network_that_is_not_trained_says_so(capsys: pytest.CaptureFixture[str]) -> None:
    reproduced_localizers.print_errors(made_up_report("table4", missing=("inception-pool-7",)))
    reproduced_localizers.print_maps(made_up_maps(missing=("sda-3x4000",)))
    out = capsys.readouterr().out
    assert out.count("not trained") == 2
    assert "nan" not in out.lower()
    assert max(map(len, out.splitlines())) <= 80
