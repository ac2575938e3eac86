"""What Table 3 or 4 says, ready for JSON, for the terminal and for a picture."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from twonav_cli.checkpoint import Card, versions
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.experiments.paper_errata import errata_of
from twonav_cli.experiments.paper_figures import EPOCHS, TABLE_3, TABLE_4

Figures = dict[str, Any]
"""Names to numbers, lists and further names: what JSON can hold."""

BELIEF, NEAREST = "belief", "nearest"
"""The rows beside the paper's: our network, and the most alike training frame without any learning."""

TRIALS = PAPER_SPLIT, OFF_GRID, HELD_CELLS = "paper_split", "off_grid", "held_cells"
"""The paper's test frames, random poses that were never trained on, and whole cells that were not."""

TITLES = {
    "table3": "Table 3: errors of the stacked denoising autoencoders",
    "table4": "Table 4: errors of the convolutional networks",
    "fig7": "Fig. 7: mean position error of every 25 cm cell",
}


@dataclass(frozen=True)
class LocalizerRow:
    """A network in a scene.

    Attributes:
        scene: Name.
        network: A name of NETWORKS, or NEAREST.
        paper: The printed errors; None for a row that the paper does not have.
        ours: Trial (PAPER_SPLIT, OFF_GRID, HELD_CELLS) to `error_metrics`; None when it is not trained.
        training: What the training took; None when there was none.
    """

    scene: str
    network: str
    paper: Figures | None
    ours: Figures | None
    training: Figures | None


@dataclass(frozen=True)
class LocalizerReport:
    """A table of localizers, the paper's figures and ours.

    Attributes:
        table: "table3" or "table4".
        title: One line.
        rows: Scene by scene: the paper's networks, then ours and the most alike frame where they could be measured.
        errata: The paper's slips: "row" and "text".
        settings: Everything that decides the figures, the command and the versions.
    """

    table: str
    title: str
    rows: list[LocalizerRow]
    errata: list[dict[str, str]]
    settings: Figures


def table_report(request: LocalizerRequest, rows: list[LocalizerRow], scenes: Figures) -> LocalizerReport:
    """Return the report of a request.

    Args:
        request: What was asked.
        rows: All of them.
        scenes: Scene to its map and its frames.
    """
    return LocalizerReport(
        request.table, TITLES[request.table], rows, errata_figures(request.table), settings_of(request, scenes)
    )


def trained_row(scene: str, network: str, card: Card | None, folder: Path) -> LocalizerRow:
    """Return a row that is trained for a table, whether it is yet or not, beside what the paper printed of it."""
    printed = (TABLE_3 | TABLE_4).get((scene, network))
    return LocalizerRow(scene, network, printed and printed._asdict(), *_of_card(card, folder))


def belief_row(scene: str, errors: Figures, card: Card, folder: Path) -> LocalizerRow:
    """Return the row of our network, measured now."""
    return LocalizerRow(scene, BELIEF, None, errors, training_figures(card, folder))


def nearest_row(scene: str, errors: Figures) -> LocalizerRow:
    """Return the row of the most alike training frame."""
    return LocalizerRow(scene, NEAREST, None, errors, None)


def training_figures(card: Card, folder: Path) -> Figures:
    """Return what a training took: pictures, the epochs that they make, time, device and digits."""
    settings, effort = card.get("settings", {}), card.get("training", {})
    images, frames = settings.get("images"), settings.get("training_frames")
    return {
        "images": images,
        "pretraining_images": settings.get("pretraining_images", 0),
        "training_frames": frames,
        "epochs": round(images / frames, 2) if images and frames else None,
        **{name: effort.get(name) for name in ("seconds", "pictures_per_s", "device", "precision", "parameters")},
        "folder": str(folder),
    }


def errata_figures(table: str) -> list[dict[str, str]]:
    """Return the paper's slips in a table or figure."""
    return [asdict(erratum) for erratum in errata_of(table)]


def settings_of(request: LocalizerRequest, scenes: Figures) -> Figures:
    """Return everything that decides the figures besides the trainings, which stand in their rows."""
    return {
        "seed": request.seed,
        "quick": request.quick,
        "scenes": scenes,
        "paper_epochs": EPOCHS,
        "repetitions": 1,
        "command": request.command(),
        "versions": versions(),
    }


def _of_card(card: Card | None, folder: Path) -> tuple[Figures | None, Figures | None]:
    """Return the errors and the training of a card."""
    if card is None:
        return None, None
    errors = {name: card["metrics"][name] for name in TRIALS if name in card["metrics"]}
    return errors, training_figures(card, folder)
