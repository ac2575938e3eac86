"""A checkpoint: a folder with arrays (safetensors) and a card (JSON) that says what they are and how they were made.

Nothing is unpickled. The card holds the SHA-256 of the arrays' file and of itself, so a flipped bit is noticed.
"""

from __future__ import annotations

import datetime
import hashlib
import json
import platform
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole

FORMAT = 2
ARRAYS_FILE = "arrays.safetensors"
NEXT_ARRAYS_FILE = "arrays.next.safetensors"
"""The arrays of a card that is being written; they take the others' place when it is there."""

CARD_FILE = "card.json"

Arrays = dict[str, NDArray[Any]]
Card = dict[str, Any]


def versions() -> dict[str, str]:
    """Return the versions that a result depends on."""
    found = {"python": platform.python_version()}
    for package in ("twonav", "numpy", "mujoco", "torch", "numba"):
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            continue
    return found


def save_checkpoint(folder: Path, arrays: Arrays, card: Card) -> Path:
    """Write arrays and card so that a reader finds the old pair or the new pair, wherever this is broken off.

    Args:
        folder: Where the two files go.
        arrays: Named arrays of any shape.
        card: Must hold "kind", "scene", "scene_digest", "map_digest", "command", "seed" and "metrics".

    Raises:
        TwonavError: The folder cannot be written.
    """
    from safetensors.numpy import save

    content = save({name: np.ascontiguousarray(array) for name, array in arrays.items()})
    full = {
        **card,
        "format": FORMAT,
        "sha256": hashlib.sha256(content).hexdigest(),
        "date": datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d"),
        "versions": versions(),
    }
    _settle(folder)
    write_whole(folder / NEXT_ARRAYS_FILE, content)
    write_whole(folder / CARD_FILE, json.dumps(signed(full), indent=2) + "\n")
    _settle(folder)
    return folder


def _settle(folder: Path) -> None:
    """Put the arrays that belong to the card where they belong, if writing them was broken off before that.

    Raises:
        TwonavError: The folder cannot be written.
    """
    following = folder / NEXT_ARRAYS_FILE
    try:
        sha256 = read_card(folder)["sha256"]
    except TwonavError:
        return  # without a card there is nothing to settle
    try:
        if following.exists() and hashlib.sha256(following.read_bytes()).hexdigest() == sha256:
            following.replace(folder / ARRAYS_FILE)
    except OSError as error:
        raise TwonavError(f"cannot write {folder / ARRAYS_FILE}: {error.strerror or error}") from error


def signed(card: Card) -> Card:
    """Return the card with the checksum of everything else in it, as it will be read back."""
    rest = {key: value for key, value in card.items() if key != "card_sha256"}
    content = json.dumps(json.loads(json.dumps(rest)), sort_keys=True).encode()
    return {**rest, "card_sha256": hashlib.sha256(content).hexdigest()}


def add_metrics(folder: Path, metrics: dict[str, Any]) -> None:
    """Put further figures into the card of a checkpoint; what it is and how it was made stays as it is.

    Raises:
        TwonavError: There is no card, it is damaged, or the folder cannot be written.
    """
    card = read_card(folder)
    card["metrics"] = {**card["metrics"], **metrics}
    write_whole(folder / CARD_FILE, json.dumps(signed(card), indent=2) + "\n")


def read_card(folder: Path) -> Card:
    """Read the card of a checkpoint.

    Raises:
        TwonavError: There is none, or it is damaged or not a card.
    """
    path = folder / CARD_FILE
    try:
        card = json.loads(path.read_text())
    except FileNotFoundError:
        raise TwonavError(f"there is no checkpoint in {folder}: train one, or name another folder") from None
    except (OSError, ValueError) as error:
        raise TwonavError(
            f"{path} is not a checkpoint card ({str(error).splitlines()[0]}): restore it or train again"
        ) from error
    known = isinstance(card, dict) and card.get("format") == FORMAT
    if not known or "sha256" not in card or "kind" not in card:
        raise TwonavError(f"{path} is not a checkpoint card of this version of twonav: train again")
    if signed(card) != card:
        raise TwonavError(f"{path} is damaged (its checksum is not its own): restore it or train again")
    return dict(card)


def load_checkpoint(
    folder: Path, kind: str, scene_digest: str | None = None, map_digest: str | None = None
) -> tuple[Arrays, Card]:
    """Read a checkpoint and check that it is whole and belongs here.

    Args:
        folder: Where the two files are.
        kind: What it must be: "agent" or "localizer".
        scene_digest: The scene it must have been made for, unless None.
        map_digest: The map it must have been made for, unless None.

    Returns:
        The arrays by name, and the card.

    Raises:
        TwonavError: Missing, truncated, changed, of another kind, scene or map.
    """
    from safetensors import SafetensorError
    from safetensors.numpy import load

    card = read_card(folder)
    if card["kind"] != kind:
        raise TwonavError(f"the checkpoint in {folder} is of kind {card['kind']!r}, not {kind!r}: name another folder")
    if scene_digest is not None and card.get("scene_digest") != scene_digest:
        raise TwonavError(
            f"the {kind} in {folder} was made for another scene or another version of it "
            f"({card.get('scene', 'unknown')}): train it again for this one"
        )
    if map_digest is not None and card.get("map_digest") != map_digest:
        raise TwonavError(
            f"the {kind} in {folder} was made on another map of the scene: train it again on this one, "
            "name its folder with --checkpoints, or the other map with --map-from"
        )
    path, content = folder / ARRAYS_FILE, _content(folder, card["sha256"])
    try:
        return load(content), card
    except (SafetensorError, ValueError) as error:
        raise TwonavError(f"{path} is not a safetensors file ({error}): train again") from error


def _content(folder: Path, sha256: str) -> bytes:
    """Return the content of the arrays' file that has a checksum.

    Raises:
        TwonavError: It cannot be read, or none has it.
    """
    path = folder / ARRAYS_FILE
    for looked_at in (path, folder / NEXT_ARRAYS_FILE, path):  # once more: who writes may have settled meanwhile
        with suppress(OSError):
            content = looked_at.read_bytes()
            if hashlib.sha256(content).hexdigest() == sha256:
                return content
    try:
        path.read_bytes()
    except OSError as error:
        raise TwonavError(f"{path} cannot be read ({error.strerror}): restore it or train again") from error
    raise TwonavError(f"{path} is damaged (its checksum is not the card's): restore it or train again")
