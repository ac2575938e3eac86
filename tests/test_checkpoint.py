"""Checkpoints: whole, undamaged and made for this scene and map, or refused in one line."""

from __future__ import annotations

import contextlib
import json
from pathlib import Path

import numpy as np
import pytest

from twonav_cli import checkpoint
from twonav_cli.checkpoint import ARRAYS_FILE, CARD_FILE, load_checkpoint, read_card, save_checkpoint
from twonav_cli.errors import TwonavError

ARRAYS = {"q": np.arange(24, dtype=np.float64).reshape(2, 3, 4), "free": np.array([[True, False]])}
CARD = {
    "kind": "agent",
    "scene": "kitchen",
    "scene_digest": "0123456789abcdef",
    "map_digest": "fedcba9876543210",
    "command": "twonav train --stage maze",
    "seed": 5,
    "metrics": {"steps": 1.5, "nothing": None},
}


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return save_checkpoint(tmp_path / "maze", ARRAYS, CARD)


def refused(folder: Path, kind: str = "agent", scene: str | None = None, map_: str | None = None) -> str:
    """Return the one line that a checkpoint is refused with."""
    with pytest.raises(TwonavError) as caught:
        load_checkpoint(folder, kind, scene, map_)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def flip(path: Path, byte: int, bit: int = 0) -> None:
    content = bytearray(path.read_bytes())
    content[byte] ^= 1 << bit
    path.write_bytes(content)


def test_what_was_saved_is_loaded(folder: Path) -> None:
    arrays, card = load_checkpoint(folder, "agent", CARD["scene_digest"], CARD["map_digest"])
    assert {name: array.tolist() for name, array in arrays.items()} == {n: a.tolist() for n, a in ARRAYS.items()}
    assert arrays["q"].dtype == np.float64
    assert card.items() >= CARD.items()
    assert card["versions"]["numpy"] == np.__version__
    assert len(card["date"]) == 10


def test_a_transposed_array_keeps_its_values(tmp_path: Path) -> None:
    save_checkpoint(tmp_path, {"q": ARRAYS["q"].T}, CARD)
    arrays, _ = load_checkpoint(tmp_path, "agent")
    assert np.array_equal(arrays["q"], ARRAYS["q"].T)


def test_a_loaded_card_can_be_saved_again(folder: Path) -> None:
    arrays, card = load_checkpoint(folder, "agent")
    save_checkpoint(folder, {"q": arrays["q"] + 1}, card)
    assert load_checkpoint(folder, "agent")[0]["q"][0, 0, 0] == 1.0


def test_a_missing_checkpoint_is_refused(tmp_path: Path) -> None:
    assert "there is no checkpoint" in refused(tmp_path / "nowhere")


def test_a_missing_arrays_file_is_refused(folder: Path) -> None:
    (folder / ARRAYS_FILE).unlink()
    assert "cannot be read" in refused(folder)


@pytest.mark.parametrize("kept", [0, 1, 8, 100])
def test_truncated_arrays_are_refused(folder: Path, kept: int) -> None:
    path = folder / ARRAYS_FILE
    path.write_bytes(path.read_bytes()[:kept])
    assert "is damaged" in refused(folder)


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.99])
def test_a_truncated_card_is_refused(folder: Path, share: float) -> None:
    path = folder / CARD_FILE
    content = path.read_bytes()
    path.write_bytes(content[: int(share * len(content))])
    assert "not a checkpoint card" in refused(folder)


def test_one_flipped_bit_anywhere_in_the_arrays_is_refused(folder: Path) -> None:
    path = folder / ARRAYS_FILE
    for byte in range(0, path.stat().st_size, 17):
        flip(path, byte, byte % 8)
        assert "is damaged" in refused(folder)
        flip(path, byte, byte % 8)
    assert load_checkpoint(folder, "agent")


@pytest.mark.parametrize("bit", [0, 5])  # 5 changes the case of a letter
def test_one_flipped_bit_anywhere_in_the_card_is_refused(folder: Path, bit: int) -> None:
    path = folder / CARD_FILE
    before = read_card(folder)
    for byte in range(path.stat().st_size):
        flip(path, byte, bit)
        with contextlib.suppress(TwonavError):  # what is not refused must not have changed anything
            assert read_card(folder) == before, f"bit {bit} of byte {byte} changed the card and nobody noticed"
        flip(path, byte, bit)
    assert read_card(folder) == before


def test_a_card_that_was_edited_by_hand_is_refused(folder: Path) -> None:
    path = folder / CARD_FILE
    path.write_text(json.dumps(json.loads(path.read_text()) | {"seed": 6}))
    assert "is damaged" in refused(folder)


@pytest.mark.parametrize("content", ["[]", "null", '{"format": 99}', '{"format": []}', "{}", "\udcff", "nan"])
def test_what_is_no_card_is_refused(folder: Path, content: str) -> None:
    (folder / CARD_FILE).write_bytes(content.encode(errors="surrogateescape"))
    assert "not a checkpoint card" in refused(folder)


def test_another_kind_is_refused(folder: Path) -> None:
    assert "'agent', not 'localizer'" in refused(folder, "localizer")


def test_another_scene_is_refused_and_named(folder: Path) -> None:
    assert "another scene or another version of it (kitchen)" in refused(folder, scene="f" * 16)


def test_another_map_is_refused(folder: Path) -> None:
    assert "made on another map" in refused(folder, map_="f" * 16)


def test_arrays_that_are_no_safetensors_file_are_refused(folder: Path) -> None:
    import hashlib

    (folder / ARRAYS_FILE).write_bytes(b"not tensors at all")
    card = read_card(folder) | {"sha256": hashlib.sha256(b"not tensors at all").hexdigest()}
    (folder / CARD_FILE).write_text(json.dumps(checkpoint.signed(card)))
    assert "is not a safetensors file" in refused(folder)


def broken_off(monkeypatch: pytest.MonkeyPatch, writes: int, folder: Path, factor: float) -> None:
    """Save the arrays, a number of times as large, and be killed after so many files."""
    with monkeypatch.context() as patched:
        write_whole, replace = checkpoint.write_whole, Path.replace
        left = [writes]

        def count() -> None:
            if not left[0]:
                raise KeyboardInterrupt
            left[0] -= 1

        def counted_write(path: Path, content: bytes | str) -> Path:
            count()
            return write_whole(path, content)

        def counted_replace(path: Path, target: Path) -> Path:
            if path.name == checkpoint.NEXT_ARRAYS_FILE:
                count()
            return replace(path, target)

        patched.setattr(checkpoint, "write_whole", counted_write)
        patched.setattr(Path, "replace", counted_replace)
        with pytest.raises(KeyboardInterrupt):
            save_checkpoint(folder, {"q": ARRAYS["q"] * factor}, {**CARD, "seed": factor})


def loaded_factor(folder: Path) -> int:
    """Return how many times as large the arrays are, which the card must say too."""
    arrays, card = load_checkpoint(folder, "agent")
    (factor,) = {*(arrays["q"].ravel()[1:] / ARRAYS["q"].ravel()[1:])}
    assert card["seed"] == factor
    return int(factor)


@pytest.mark.parametrize(("writes", "there"), [(0, 5), (1, 5), (2, 2)])
def test_a_save_that_breaks_off_anywhere_leaves_the_old_pair_or_the_new_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, writes: int, there: int
) -> None:
    save_checkpoint(tmp_path, {"q": ARRAYS["q"] * 5}, CARD)
    broken_off(monkeypatch, writes, tmp_path, 2)
    assert loaded_factor(tmp_path) == there
    for again in (0, 1, 2):  # the second save may begin with what the first left undone
        broken_off(monkeypatch, again, tmp_path, 3)
        assert loaded_factor(tmp_path) in (there, 3)
    save_checkpoint(tmp_path, {"q": ARRAYS["q"] * 4}, {**CARD, "seed": 4})
    assert loaded_factor(tmp_path) == 4
    assert {file.name for file in tmp_path.iterdir()} == {ARRAYS_FILE, CARD_FILE}
