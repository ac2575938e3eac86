"""The options of `twonav train --stage maze` that say how and where the agent learns; sentences are the settings'."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated

import typer

from twonav_cli.config import LearningConfig
from twonav_cli.learner.learners import LEARNERS

SENTENCES = {field.name: field.metadata["help"] for field in fields(LearningConfig) if "help" in field.metadata}
"""Setting to the sentence that stands beside it in the configuration."""

OF_PRESET = "the preset's"
"""Where the value of a setting comes from that is not given."""

WatchOption = Annotated[
    bool, typer.Option("--watch", help="Watch the agent learn, from one action a second up (maze only).")
]
TrainBaseOption = Annotated[
    str | None, typer.Option("--base", help="omni or differential (map, 2d and 3d).", show_default="omni")
]
LearnerOption = Annotated[
    str | None,
    typer.Option("--learner", help=f"Who learns: {', '.join(LEARNERS)} (maze only).", show_default="multi"),
]
PresetOption = Annotated[
    str | None,
    typer.Option(
        "--preset", help="Settings to begin from: maze (ours) or paper-maze (discount 0.99).", show_default="maze"
    ),
]
DiscountOption = Annotated[float | None, typer.Option("--discount", help=SENTENCES["discount"], show_default=OF_PRESET)]
TemperatureOption = Annotated[
    float | None, typer.Option("--temperature", help=SENTENCES["temperature"], show_default=OF_PRESET)
]
InitialQOption = Annotated[
    float | None, typer.Option("--initial-q", help=SENTENCES["initial_q"], show_default=OF_PRESET)
]
GoalSelectionOption = Annotated[
    str | None, typer.Option("--goal-selection", help=SENTENCES["goal_selection"], show_default=OF_PRESET)
]
ExplorationOption = Annotated[
    str | None, typer.Option("--exploration", help=SENTENCES["exploration"], show_default=OF_PRESET)
]
CoolingOption = Annotated[str | None, typer.Option("--cooling", help=SENTENCES["cooling"], show_default=OF_PRESET)]
RandomMazeOption = Annotated[
    int | None,
    typer.Option(
        "--random-maze",
        min=0,
        help="Learn in the random maze of this number, drawn from the seed (§4.3), not in a scene.",
    ),
]
