"""The trained network behind a row: found where it was left, or trained now; a killed training goes on."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import CARD_FILE, Card, read_card
from twonav_cli.errors import TwonavError
from twonav_cli.events import Sink
from twonav_cli.experiments.localizer_tables.scene_frames import SceneFrames
from twonav_cli.localizer.training import train
from twonav_cli.localizer.training_config import TrainingConfig
from twonav_cli.localizer.training_state import STATE_FILE
from twonav_cli.mapping.floor import Floor
from twonav_cli.paths import checkpoints_dir, runs_dir

FOLDER = "reproduce-localizers"
SHIPPED_CARDS = "paper-networks"

MAY_DIFFER = (
    "device", "precision", "threads", "validations", "validation_frames", "nearest_frames", "save_every_s",
)  # fmt: skip
"""Settings that do not make another network; the table says on what each was trained."""


def row_folder(scene: str, name: str, quick: bool) -> Path:
    """Return where the network of a row lies, and what was measured with it."""
    return runs_dir() / FOLDER / scene / (f"{name}-quick" if quick else name)


def finished(folder: Path, config: TrainingConfig, seed: int, floor: Floor) -> Card | None:
    """Return the card of a finished network; None where there is none.

    Args:
        folder: Where it would be.
        config: How it must have been trained.
        seed: The seed that it must have.
        floor: Scene and map that it must be of.

    Raises:
        TwonavError: There is one that was trained otherwise, or it is damaged.
    """
    if not (folder / CARD_FILE).is_file():
        return None
    card = read_card(folder)
    found, wanted = _origin(card), _expected(config, seed, floor)
    other = [f"{name} {found.get(name)} and not {value}" for name, value in wanted.items() if found.get(name) != value]
    if other:
        raise TwonavError(
            f"the network in {folder} was trained otherwise ({', '.join(other)}): ask for the same, "
            "or delete the folder to train it anew"
        )
    return card


def check_begun(folder: Path, config: TrainingConfig) -> None:
    """Make sure that a training that was left in a folder is to end where it was meant to.

    Its rate falls towards the end, so one that went on to another end would be neither budget's network.

    Raises:
        TwonavError: It was begun with another number of pictures.
    """
    images = _begun_images(folder / STATE_FILE)
    if images not in (None, config.images):
        raise TwonavError(
            f"the training in {folder} was begun with {images} pictures and not {config.images}: "
            f"go on with --images {images}, or delete the folder to train anew"
        )


def _begun_images(path: Path) -> Any:
    """Return the budget that a training's state was begun with; None where there is none, or it does not say so."""
    from safetensors import SafetensorError, safe_open

    if not path.is_file():
        return None
    try:
        with safe_open(path, framework="numpy") as opened:
            facts = {"config": {}, **json.loads((opened.metadata() or {}).get("facts", "{}"))}
            return facts["config"].get("images", facts.get("images"))
    except (OSError, SafetensorError, ValueError, TypeError, AttributeError):  # damaged, which going on complains of
        return None


def shipped_card(network: str, config: TrainingConfig, seed: int, floor: Floor) -> Card | None:
    """Return the shipped card of a network that was trained for our own page; None where there is none, or of another.

    Its weights are not shipped, only what was measured.
    """
    folder = checkpoints_dir() / floor.scene.name / SHIPPED_CARDS / network
    try:
        return finished(folder, config, seed, floor)
    except TwonavError:
        return None


def train_row(
    frames: SceneFrames,
    folder: Path,
    config: TrainingConfig,
    seed: int,
    should_stop: Callable[[], bool],
    sink: Sink,
    command: str,
) -> Card | None:
    """Train a network from where a training was left, or from the start; return its card, or None when stopped.

    Raises:
        TwonavError: Too few frames, a training of other settings was left in the folder, or it diverges.
    """
    check_begun(folder, config)
    saved = train(
        frames.training(), folder, config, seed, frames.trials(), frames.validation(), should_stop, sink,
        resume=True, command=command,
    )  # fmt: skip
    return None if saved is None else read_card(saved)


def _expected(config: TrainingConfig, seed: int, floor: Floor) -> dict[str, Any]:
    """Return what decides a network, by name."""
    settings = {name: value for name, value in asdict(config).items() if name not in MAY_DIFFER}
    return {**settings, "seed": seed, "scene_digest": floor.scene.digest, "map_digest": floor.map.digest}


def _origin(card: Card) -> dict[str, Any]:
    return {**card.get("settings", {}), **{name: card.get(name) for name in ("seed", "scene_digest", "map_digest")}}
