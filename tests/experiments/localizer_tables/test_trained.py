"""A row's network: trained, gone on with, found again, and refused when it is another."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from made_up_localizers import grid_store, made_up_floor, random_store
from safetensors.numpy import save

from twonav_cli.checkpoint import load_checkpoint
from twonav_cli.errors import TwonavError
from twonav_cli.events import to_nobody
from twonav_cli.experiments.localizer_tables.scene_frames import SceneFrames
from twonav_cli.experiments.localizer_tables.trained import (
    SHIPPED_CARDS,
    check_begun,
    finished,
    row_folder,
    shipped_card,
    train_row,
)
from twonav_cli.localizer.training_config import TrainingConfig, training_settings
from twonav_cli.localizer.training_state import STATE_FILE

CONFIG = training_settings("cnn-7", images=8 * 4, batch=8, part=8, nearest_frames=0, precision="float32")
FLOOR: Any = made_up_floor("kitchen")


def frames() -> SceneFrames:
    return SceneFrames(grid_store("kitchen"), random_store("kitchen"))


def trained(folder: Path, config: TrainingConfig = CONFIG, stop_after: int | None = None) -> Any:
    asked: list[int] = []

    def should_stop() -> bool:
        asked.append(1)
        return len(asked) == stop_after

    return train_row(frames(), folder, config, 0, should_stop, to_nobody, "twonav reproduce table3")


@pytest.fixture(scope="module")
def finished_row(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    folder = tmp_path_factory.mktemp("row")
    return folder, trained(folder)


def test_a_network_learns_from_the_papers_half_and_is_measured_at_the_rest(finished_row: tuple[Path, Any]) -> None:
    _, card = finished_row
    assert card["settings"]["training_frames"] == 60
    assert {name: card["metrics"][name]["n"] for name in ("paper_split", "off_grid", "held_cells")} == {
        "paper_split": 36, "off_grid": 20, "held_cells": 10,
    }  # fmt: skip
    assert card["command"] == "twonav reproduce table3"
    assert frames().counts() == {
        "training": 60, "paper_split": 36, "off_grid": 20, "held_cells": 10, "labels": "simulator",
    }  # fmt: skip


def test_a_training_that_was_stopped_goes_on_to_the_same_network(
    tmp_path: Path, finished_row: tuple[Path, Any]
) -> None:
    assert trained(tmp_path, stop_after=2) is None
    assert (tmp_path / STATE_FILE).is_file()
    assert finished(tmp_path, CONFIG, 0, FLOOR) is None
    trained(tmp_path)
    weights, unbroken = (load_checkpoint(folder, "localizer")[0] for folder in (tmp_path, finished_row[0]))
    assert all((weights[name] == unbroken[name]).all() for name in unbroken)


def test_a_training_goes_on_with_the_budget_that_it_was_begun_with_only(tmp_path: Path) -> None:
    trained(tmp_path, stop_after=2)
    said = f"begun with {CONFIG.images} pictures and not 960: go on with --images {CONFIG.images}, or delete the folder"
    with pytest.raises(TwonavError, match=said):
        trained(tmp_path, replace(CONFIG, images=960))
    check_begun(tmp_path, CONFIG)


@pytest.mark.parametrize("facts", [{"images": 960}, {"config": {"images": 960}}])
def test_a_training_of_another_budget_is_refused_wherever_its_state_says_so(tmp_path: Path, facts: Any) -> None:
    (tmp_path / STATE_FILE).write_bytes(save({}, metadata={"facts": json.dumps(facts)}))
    with pytest.raises(TwonavError, match="go on with --images 960"):
        check_begun(tmp_path, CONFIG)


@pytest.mark.parametrize("facts", [{}, {"config": {}}, {"config": 3}, 3, {"images": CONFIG.images}])
def test_a_training_that_does_not_say_its_budget_otherwise_is_left_to_what_goes_on_with_it(
    tmp_path: Path, facts: Any
) -> None:
    (tmp_path / STATE_FILE).write_bytes(save({}, metadata={"facts": json.dumps(facts)}))
    check_begun(tmp_path, CONFIG)
    (tmp_path / STATE_FILE).write_bytes(b"damaged")
    check_begun(tmp_path, CONFIG)


def test_a_finished_network_is_found_again_on_another_device(finished_row: tuple[Path, Any]) -> None:
    folder, card = finished_row
    same = replace(CONFIG, device="cpu", threads=7, precision="bfloat16", validations=1)
    assert finished(folder, same, 0, FLOOR) == card


def test_a_network_of_another_training_is_refused_with_what_differs(finished_row: tuple[Path, Any]) -> None:
    folder, _ = finished_row
    with pytest.raises(TwonavError, match=r"images 32 and not 960\): ask for the same, or delete the folder"):
        finished(folder, replace(CONFIG, images=960), 0, FLOOR)
    with pytest.raises(TwonavError, match="seed 0 and not 1"):
        finished(folder, CONFIG, 1, FLOOR)
    changed = SimpleNamespace(**{**vars(FLOOR), "scene": SimpleNamespace(name="kitchen", digest="new")})
    with pytest.raises(TwonavError, match="scene_digest digest of kitchen and not new"):
        finished(folder, CONFIG, 0, changed)  # type: ignore[arg-type]  # it has what is looked at
    mapped_anew = SimpleNamespace(**{**vars(FLOOR), "map": SimpleNamespace(digest="another")})
    with pytest.raises(TwonavError, match="and not another"):
        finished(folder, CONFIG, 0, mapped_anew)  # type: ignore[arg-type]  # it has what is looked at


def test_every_row_has_a_folder_of_its_own(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    rows = {row_folder(scene, name, quick) for scene in "ab" for name in ("cnn-7", "cnn-9") for quick in (False, True)}
    assert len(rows) == 8
    assert row_folder("kitchen", "cnn-7", True) == tmp_path / "reproduce-localizers" / "kitchen" / "cnn-7-quick"


def test_a_shipped_card_stands_in_only_for_a_network_of_the_same_training(
    finished_row: tuple[Path, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder, card = finished_row
    shipped = tmp_path / "kitchen" / SHIPPED_CARDS / "cnn-7"
    shipped.mkdir(parents=True)
    (shipped / "card.json").write_text((folder / "card.json").read_text())
    monkeypatch.setattr("twonav_cli.experiments.localizer_tables.trained.checkpoints_dir", lambda: tmp_path)
    assert shipped_card("cnn-7", CONFIG, 0, FLOOR) == card
    assert shipped_card("cnn-7", replace(CONFIG, images=960), 0, FLOOR) is None
    assert shipped_card("cnn-9", CONFIG, 0, FLOOR) is None
