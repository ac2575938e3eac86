"""What a person asks of Table 3, Table 4 or Fig. 7: which rows, from which seed, and how much training."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.experiments.paper_figures import FIG_7, SIZES_M, TABLE_3, TABLE_4

PRINTED: dict[str, Mapping[tuple[str, str], Any]] = {"table3": TABLE_3, "table4": TABLE_4, "fig7": FIG_7}
"""Name to the paper's figures by scene and network."""

OWN_ROW = "belief-grid"
"""A row of Table 4 that the paper does not have: our network, trained on the frames of the paper's (ours)."""

ROWS: dict[str, list[tuple[str, str]]] = {
    table: [*printed, *((scene, OWN_ROW) for scene in SIZES_M if table == "table4")]
    for table, printed in PRINTED.items()
}
"""Name to the rows that are trained, each a scene and a network."""

PICTURES = {"cnn": 596_160, "sda": 298_080}
"""How many pictures each network is shown to learn poses, repeats included (ours; the paper: 10,000 epochs, §4.2.1).

They are 12 and 6 passes over the kitchen's training frames, 4 and 2 over the apartment's.
"""

LONGER, LONGER_IN, TIMES = ("inception-9", OWN_ROW), "apartment", 3
"""The paper's best network and ours learn as many passes in the apartment as in the kitchen (ours)."""


def default_images(network: str, scene: str) -> int:
    """Return how many pictures a network of a scene is shown when nobody says so, repeats included."""
    pictures = PICTURES["sda" if network.startswith("sda-") else "cnn"]
    return pictures * (TIMES if scene == LONGER_IN and network in LONGER else 1)


@dataclass(frozen=True)
class LocalizerRequest:
    """A table or figure about localizers, and what it is made from.

    Attributes:
        table: A key of PRINTED.
        seed: Of the frames, the weights and the batches.
        quick: Whether small frame sets and a few pictures are meant; they show that everything works.
        images: Pictures shown to each network to learn poses; None for what `budget` says.
        device: "auto", "cpu" or "cuda".
        scene: Only its rows; None for all.
        networks: Only their rows; empty for all.
        map_from: "survey" or "geometry": on which map the frames are taken; None as `read_floor` chooses.
        only_finished: Train nothing and take no frames.
    """

    table: str
    seed: int = 0
    quick: bool = False
    images: int | None = None
    device: str = "auto"
    scene: str | None = None
    networks: tuple[str, ...] = ()
    map_from: str | None = None
    only_finished: bool = False

    def rows(self) -> dict[str, list[str]]:
        """Return the networks of every scene, the paper's in its order, as far as they were asked for."""
        found: dict[str, list[str]] = {}
        for scene, network in ROWS[self.table]:
            if self.scene in (None, scene) and (not self.networks or network in self.networks):
                found.setdefault(scene, []).append(network)
        return found

    def only(self, scene: str, network: str) -> LocalizerRequest:
        """Return the request of one row."""
        return replace(self, scene=scene, networks=(network,))

    def check(self) -> None:
        """Make sure that there is something to make.

        Raises:
            TwonavError: No row of the table has that scene or network, a number is out of its range, or there is no
                such device.
        """
        rows = ROWS[self.table]
        known = list(dict.fromkeys(network for _, network in rows))
        for network in self.networks:
            if network not in known:
                raise unknown_name(f"network of {self.table}", network, known)
        scenes = list(dict.fromkeys(scene for scene, _ in rows))
        if self.scene is not None and self.scene not in scenes:
            raise unknown_name(f"scene of {self.table}", self.scene, scenes)
        if not self.rows():
            raise TwonavError(
                f"{self.table} has no row of scene {self.scene} for {', '.join(self.networks)}: leave --scene out"
            )
        if self.seed < 0:
            raise TwonavError(f"--seed must be at least 0: {self.seed} was given")
        if self.images is not None and self.images < 1:
            raise TwonavError(f"--images must be at least 1: {self.images} was given")
        from twonav_cli.localizer.devices import chosen_device

        chosen_device(self.device)

    def command(self) -> str:
        """Return the command that makes the table again."""
        parts = ["twonav", "reproduce", self.table, "--seed", str(self.seed)]
        parts += ["--quick"] if self.quick else []
        parts += [] if self.images is None else ["--images", str(self.images)]
        parts += [] if self.scene is None else ["--scene", self.scene]
        parts += ["--networks", ",".join(self.networks)] if self.networks else []
        parts += [] if self.map_from is None else ["--map-from", self.map_from]
        parts += [] if self.device == "auto" else ["--device", self.device]
        parts += ["--only-finished"] if self.only_finished else []
        return shlex.join(parts)
