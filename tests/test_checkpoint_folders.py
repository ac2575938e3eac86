"""Which folder holds a scene's checkpoint."""

from __future__ import annotations

from pathlib import Path

import pytest

from twonav_cli import checkpoint_folders
from twonav_cli.checkpoint import CARD_FILE
from twonav_cli.checkpoint_folders import checkpoint_folder, localizer_name
from twonav_cli.errors import TwonavError


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """Return the folders of the shipped checkpoints and of the user's own runs, both empty."""
    shipped, own = tmp_path / "shipped", tmp_path / "own"
    monkeypatch.setattr(checkpoint_folders, "checkpoints_dir", lambda: shipped)
    monkeypatch.setattr(checkpoint_folders, "runs_dir", lambda: own)
    return shipped, own


def put_card(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / CARD_FILE).write_text("{}")
    return folder


def test_the_shipped_checkpoint_goes_before_the_own_one_unless_asked_otherwise(places: tuple[Path, Path]) -> None:
    shipped, own = (put_card(place / "kitchen" / "maze") for place in places)
    assert checkpoint_folder("kitchen", "maze") == shipped
    assert checkpoint_folder("kitchen", "maze", own_first=True) == own


def test_the_own_checkpoint_is_found_where_none_is_shipped(places: tuple[Path, Path]) -> None:
    own = put_card(places[1] / "kitchen" / "maze")
    assert checkpoint_folder("kitchen", "maze") == own


def test_where_a_folder_is_named_only_that_one_counts(places: tuple[Path, Path], tmp_path: Path) -> None:
    put_card(places[0] / "kitchen" / "maze")
    chosen = put_card(tmp_path / "chosen" / "maze").parent
    assert checkpoint_folder("kitchen", "maze", chosen) == chosen / "maze"
    with pytest.raises(TwonavError, match=r"no localizer checkpoint in .*chosen"):
        checkpoint_folder("kitchen", "localizer", chosen)


def test_a_missing_checkpoint_is_answered_with_the_command_that_makes_it(places: tuple[Path, Path]) -> None:
    with pytest.raises(TwonavError, match=r"`twonav train --stage localizer --scene kitchen`"):
        checkpoint_folder("kitchen", "localizer")


def test_ours_is_the_localizer_and_the_papers_say_which_network_they_are() -> None:
    names = [localizer_name(network) for network in (None, "belief", "inception-9")]
    assert names == ["localizer", "localizer", "localizer-inception-9"]
