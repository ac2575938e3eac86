"""`twonav inspect`: what a recording holds, and how to look at it."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.table import Table

from twonav_cli.recording.reader import Summary, TrialRow, how_to_seek, summarize
from twonav_cli.terminal.console import out

MAX_ROWS = 100
MAX_FAILURES = 10


def run_inspect(file: Path, as_json: bool) -> int:
    """Print the summary of a recording; returns the exit code."""
    summary = summarize(file)
    if as_json:
        print(json.dumps(asdict(summary), default=str))
    else:
        _print_summary(summary, file)
    return 0


def _print_summary(summary: Summary, file: Path) -> None:
    console = out()
    console.print(
        f"{summary.command} of scene {summary.scene}, stage {summary.stage}, seed {summary.seed}"
        + (f": {summary.ending}" if summary.ending else "")
    )
    if not summary.whole:
        console.print("the writer was interrupted: what follows is what it had written")
    if summary.trials:
        console.print(_trials_table(summary.trials[-MAX_ROWS:]))
        if len(summary.trials) > MAX_ROWS:
            console.print(f"(the last {MAX_ROWS} of {len(summary.trials)} trials)")
    if summary.counts:
        console.print("outcomes: " + ", ".join(f"{name} {count}" for name, count in summary.counts.items()))
    for name, value in summary.metrics.items():
        console.print(f"{name}: {value:.4g}")
    for row in summary.failures[-MAX_FAILURES:]:
        console.print(f"what went wrong in trial {row.number}: {row.cause}. {row.evidence}", soft_wrap=True)
        console.print(f"  look at it: {how_to_seek(row, summary.kind)}", soft_wrap=True)
    console.print(f"open it:  rerun {file}", soft_wrap=True)


def _trials_table(rows: tuple[TrialRow, ...]) -> Table:
    table = Table(box=None, pad_edge=False)
    for heading in ("trial", "goal", "outcome", "actions", "shortest", "cause"):
        table.add_column(heading, justify="right" if heading in ("trial", "actions", "shortest") else "left")
    for row in rows:
        table.add_row(str(row.number), row.goal, row.outcome, str(row.steps), str(row.shortest), row.cause)
    return table
