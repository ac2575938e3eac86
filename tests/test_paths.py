"""Where things lie."""

from __future__ import annotations

from pathlib import Path

import pytest

from twonav_cli import paths


def test_runs_go_where_the_user_says(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    assert paths.runs_dir() == tmp_path


def test_in_a_checkout_everything_lies_beside_the_package(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.delenv("TWONAV_RUNS", raising=False)
    monkeypatch.setattr(paths, "CHECKOUT", tmp_path)
    (tmp_path / "pyproject.toml").touch()
    (tmp_path / "scenes").mkdir()
    found = (paths.scenes_dir(), paths.checkpoints_dir(), paths.runs_dir())
    assert found == (tmp_path / "scenes", tmp_path / "checkpoints", tmp_path / "runs")


def test_an_installed_package_ships_scenes_and_checkpoints_and_writes_elsewhere(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.delenv("TWONAV_RUNS", raising=False)
    monkeypatch.setattr(paths, "CHECKOUT", tmp_path)
    assert paths.scenes_dir() == paths.PACKAGE / "shipped" / "scenes"
    assert paths.checkpoints_dir() == paths.PACKAGE / "shipped" / "checkpoints"
    assert not paths.runs_dir().is_relative_to(paths.PACKAGE)
    assert paths.runs_dir().name == "runs"
