"""The options of `twonav reproduce` that are about localizers."""

from __future__ import annotations

from typing import Annotated

import typer

from twonav_cli.experiments.localizer_tables.request import PICTURES

_FOR = "(table3, table4, fig7)"

QuickRowsOption = Annotated[
    bool, typer.Option("--quick", help=f"Few frames and pictures, which show that everything works {_FOR}.")
]
RowImagesOption = Annotated[
    int | None,
    typer.Option(
        "--images",
        min=1,
        help=f"Pictures shown to each network, repeats included {_FOR}.",
        show_default=f"{PICTURES['cnn']:,}; autoencoders {PICTURES['sda']:,}",
    ),
]
RowDeviceOption = Annotated[
    str | None, typer.Option("--device", help=f"Train on auto, cpu or cuda {_FOR}.", show_default="auto")
]
NetworksOption = Annotated[
    str | None,
    typer.Option("--networks", help=f"Only the rows of these networks, as in cnn-7,inception-9 {_FOR}."),
]
OnlyFinishedOption = Annotated[
    bool, typer.Option("--only-finished", help=f"Train nothing: print what is there {_FOR}.")
]
