"""`twonav inspect`: what a recording holds, and how to look at it."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.table import Table

from twonav_cli.recording.reader import Summary, summarize
from twonav_cli.terminal.console import out

MAX_ROWS = 200


def run_inspect(file: Path, as_json: bool) -> int:
    """Print the summary of a recording; returns the exit code."""
    summary = summarize(file)
    if as_json:
        print(json.dumps(asdict(summary), default=str))
        return 0
    _print_summary(summary, file)
    return 0


def _print_summary(summary: Summary, file: Path) -> None:
    console = out()
    console.print(
        f"{file}: {summary.kind}, scene {summary.scene}, stage {summary.stage}, seed {summary.seed}"
    )
    if not summary.ended:
        console.print("the writer was interrupted: what follows is what it had written")
    table = Table(box=None, pad_edge=False)
    for heading in ("trial", "goal", "outcome", "actions", "shortest", "cause", "evidence"):
        table.add_column(heading, justify="right" if heading in ("trial", "actions", "shortest") else "left")
    for row in summary.trials[:MAX_ROWS]:
        table.add_row(
            str(row.trial), row.goal, row.outcome, str(row.steps), str(row.shortest), row.cause, row.evidence
        )
    console.print(table)
    if len(summary.trials) > MAX_ROWS:
        console.print(f"... and {len(summary.trials) - MAX_ROWS} more trials")
    console.print("outcomes: " + ", ".join(f"{name} {count}" for name, count in summary.counts.items()))
    for row in summary.failures[:10]:
        console.print(f"look at trial {row.trial}: set the timeline to `trial` and the cursor to {row.trial}")
    console.print(f"open it:  rerun {file}", soft_wrap=True)
