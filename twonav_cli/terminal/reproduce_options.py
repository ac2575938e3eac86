"""The options of `twonav reproduce` that are about localizers, and about agents in 2D and 3D."""

from __future__ import annotations

from typing import Annotated

import typer

from twonav_cli.experiments.localizer_tables.request import PICTURES

_FOR = "(table3, table4, fig7)"
_OF_AGENTS = "(table9, table10)"

QuickRowsOption = Annotated[
    bool, typer.Option("--quick", help="A small run of a slow table, which shows that everything works.")
]
RowImagesOption = Annotated[
    int | None,
    typer.Option(
        "--images",
        min=1,
        help=f"Pictures shown to each network, repeats included {_FOR}.",
        show_default=f"{PICTURES['cnn']:,}; autoencoders {PICTURES['sda']:,}; the best in the apartment 3 times",
    ),
]
RowDeviceOption = Annotated[
    str | None, typer.Option("--device", help=f"Train on auto, cpu or cuda {_FOR}.", show_default="auto")
]
NetworksOption = Annotated[
    str | None,
    typer.Option(
        "--networks", help=f"Only the rows of these networks, as in cnn-7,inception-9 {_FOR}; or whose (fig9)."
    ),
]
OnlyFinishedOption = Annotated[
    bool, typer.Option("--only-finished", help="Train nothing for a slow table: print what is there.")
]
AgentLocalizerOption = Annotated[
    str | None,
    typer.Option("--localizer", help=f"Poses in 3D: raw, filtered or truth {_OF_AGENTS}.", show_default="raw"),
]
AgentBaseOption = Annotated[
    str | None, typer.Option("--base", help=f"omni or differential {_OF_AGENTS}.", show_default="omni")
]
