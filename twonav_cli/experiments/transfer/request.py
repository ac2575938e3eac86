"""What a person asks of Tables 9 and 10 and of Fig. 8 (c) to (e): how many agents, where, from which seed."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from twonav_cli.config import BASES, LOCALIZERS, LearningConfig, learning_preset
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.paths import runs_dir
from twonav_cli.rng import stream

TABLES = ("table9", "table10")

AGENTS, QUICK_AGENTS = 10, 2
"""Agents that learn (§4.3.1), and how many of them show that everything works."""

TRANSFERRED, FROM_NOTHING = "transferred", "from-nothing"
CHAINS: dict[str, tuple[str, ...]] = {TRANSFERRED: ("maze", "2d", "3d"), FROM_NOTHING: ("3d",)}
"""The stages that an agent goes through."""

CHAINS_OF = {"table9": (TRANSFERRED,), "table10": (FROM_NOTHING, TRANSFERRED)}
"""What each table is about; Table 10's agents are beside those that were transferred."""

FOLDER = "reproduce-agents"


@dataclass(frozen=True)
class TransferRequest:
    """A table about transfer, and what it is made from.

    Attributes:
        table: A name of TABLES.
        agents: How many agents learn.
        seed: Of everything random.
        scene: Where.
        localizer: A name of LOCALIZERS.
        base: "omni" or "differential".
        processes: How many agents learn at a time.
        quick: Whether few agents and trials are meant; they show that everything works.
        map_from: "survey" or "geometry"; None as `read_floor` chooses.
        only_finished: Train nothing: print what is there.
    """

    table: str
    agents: int = AGENTS
    seed: int = 0
    scene: str = "apartment"
    localizer: str = "raw"
    base: str = "omni"
    processes: int = 1
    quick: bool = False
    map_from: str | None = None
    only_finished: bool = False

    def check(self) -> None:
        """Make sure that the request can be fulfilled.

        Raises:
            TwonavError: A number is out of its range, or a name is none.
        """
        for name, value in (("repeats", self.agents), ("processes", self.processes)):
            if value < 1:
                raise TwonavError(f"--{name} must be at least 1: {value} was given")
        if self.seed < 0:
            raise TwonavError(f"--seed must be at least 0: {self.seed} was given")
        if self.localizer not in LOCALIZERS:
            raise unknown_name("localizer", self.localizer, LOCALIZERS)
        if self.base not in BASES:
            raise unknown_name("base", self.base, BASES)

    def agent_seed(self, agent: int) -> int:
        """Return the seed of an agent: the same in every table."""
        return int(stream(self.seed, "agent", agent).integers(2**31))

    def folder(self, scene: str, map_digest: str, chain: str, stage: str, agent: int) -> Path:
        """Return where an agent of a stage lies; the map, the pose's source and the base tell agents apart."""
        kind = stage if stage == "maze" else f"{stage}-{self.base}" + (f"-{self.localizer}" if stage == "3d" else "")
        name = f"{chain}-{kind}" + ("-quick" if self.quick else "")
        return runs_dir() / FOLDER / f"{scene}-{map_digest[:8]}" / name / f"seed{self.seed}-agent{agent}"

    def learning(self, stage: str) -> LearningConfig:
        """Return how an agent learns in a stage; in a quick run a goal counts as learned sooner."""
        return learning_preset(stage, **({"consecutive_successes": 2} if self.quick and stage != "maze" else {}))

    def command(self) -> str:
        """Return the command that makes the table again."""
        parts = ["twonav", "reproduce", self.table, "--repeats", str(self.agents), "--seed", str(self.seed)]
        parts += ["--scene", self.scene, "--localizer", self.localizer, "--base", self.base]
        parts += ["--quick"] if self.quick else []
        parts += [] if self.map_from is None else ["--map-from", self.map_from]
        return shlex.join(parts + (["--only-finished"] if self.only_finished else []))
