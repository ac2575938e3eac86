"""The two data sets of a scene as these tables use them: the paper's grid to learn from, all of it to measure at."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from twonav_cli.checkpoint import Card
from twonav_cli.dataset.store import FrameStore
from twonav_cli.experiments.localizer_tables.report import HELD_CELLS, OFF_GRID, PAPER_SPLIT
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.measuring import thinned

VALIDATION_FRAMES = 1000
"""Frames that are tried while a network learns; they only show how it goes (ours)."""


@dataclass(frozen=True)
class SceneFrames:
    """A scene's frames.

    Attributes:
        grid: The paper's, at every degree in the centre of every cell.
        random: Ours, at random poses.
    """

    grid: FrameStore
    random: FrameStore

    def training(self) -> Selection:
        """Return what the paper's networks learn from: its training half of the grid."""
        return self.grid, self.grid.training()

    def validation(self) -> Selection:
        """Return some of the frames that the paper keeps for validation."""
        return self.grid, thinned(self.grid.validation(), VALIDATION_FRAMES)

    def trials(self) -> dict[str, Selection]:
        """Return what every network is measured at; it has seen none of them."""
        return {
            PAPER_SPLIT: (self.grid, self.grid.paper_test()),
            OFF_GRID: (self.random, self.random.off_grid()),
            HELD_CELLS: (self.random, self.random.held_cells()),
        }

    def seen_cells(self, card: Card) -> bool:
        """Whether a network that learned from frames of another seed or map may have seen the held-out cells.

        Which cells are held out, the seed and the map decide.
        """
        meta = self.random.meta
        return any(card.get(name) is None or card[name] != meta.get(name) for name in ("seed", "map_digest"))

    def counts(self) -> dict[str, Any]:
        """Return how many frames there are of each kind, and who labelled them."""
        label = self.grid.meta.get("labels", "simulator")
        trials = {name: len(frames) for name, (_, frames) in self.trials().items()}
        return {"training": len(self.grid.training()), **trials, "labels": label}
