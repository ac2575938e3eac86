"""`twonav inspect`: what a recording holds, and how to look at it."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.table import Table

from twonav_cli.recording.looks import WRONG_M, LookSummary
from twonav_cli.recording.mapped import MappingSummary
from twonav_cli.recording.reader import Summary, TrialRow, how_to_seek, summarize
from twonav_cli.recording.trained_goals import TrainedGoal, why_chosen
from twonav_cli.terminal.console import out

MAX_ROWS = 100
MAX_FAILURES = 10
MAX_ROWS_OF_TRAINING = 10
"""Trials of a training run that are listed: its goals tell more."""


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
    what = f"log {summary.scene}" if summary.command == "map" else f"scene {summary.scene}, stage {summary.stage}"
    ending = f": {summary.ending}" if summary.ending else ""
    console.print(f"{summary.command} of {what}, seed {summary.seed}{ending}")
    if not summary.whole:
        console.print("the writer was interrupted: what follows is what it had written")
    for warning in summary.warnings:
        console.print(f"warnings: {warning}", soft_wrap=True, markup=False)
    for added in summary.added:
        where = f"goal {added.goal} was added in cell ({added.row}, {added.col}) at trial {added.at_trial}"
        console.print(where, soft_wrap=True)
    if summary.learning:
        console.print(_goals_table(summary.learning))
    if summary.kind == "map":
        for line in mapping_lines(summary.mapping):
            console.print(line, soft_wrap=True)
    elif not summary.trials and summary.kind != "localizer":
        console.print(no_trial(summary), soft_wrap=True)
    shown = MAX_ROWS_OF_TRAINING if summary.learning else MAX_ROWS
    if summary.trials:
        console.print(_trials_table(summary.trials[-shown:]))
        if len(summary.trials) > shown:
            console.print(f"(the last {shown} of {len(summary.trials)} recorded trials)")
    if summary.counts:
        console.print("outcomes: " + ", ".join(f"{name} {count}" for name, count in summary.counts.items()))
    if summary.looks is not None:
        console.print(looks_line(summary.looks), soft_wrap=True)
    for name, value in summary.metrics.items():
        console.print(f"{name}: {value:.4g}")
    compiled = [str(row.number) for row in summary.failures if row.sampled]
    if compiled:
        last = ", ".join(compiled[-MAX_FAILURES:])
        console.print(f"trials that did not reach their goal, the last ones: {last}", soft_wrap=True)
    for row in [row for row in summary.failures if not row.sampled][-MAX_FAILURES:]:
        console.print(f"what went wrong in trial {row.number}: {row.cause}. {row.evidence}", soft_wrap=True)
        console.print(f"  look at it: {how_to_seek(row, summary.kind)}", soft_wrap=True)
    console.print(f"open it:  rerun {file}", soft_wrap=True)


def looks_line(looks: LookSummary) -> str:
    """Return how many looks were wrong, and how sure the robot was then and otherwise."""

    def sure(confidence: float | None) -> str:
        return "-" if confidence is None else f"{confidence:.2f}"

    if looks.wrong == 0:
        median = sure(looks.confidence_right)
        return f"looks: {looks.looks}, none of them more than {WRONG_M} m off; confidence (median) {median}"
    return (
        f"looks: {looks.looks}, {looks.wrong} of them ({100 * looks.wrong_share:.1f} %) more than {WRONG_M} m off; "
        f"confidence (median) {sure(looks.confidence_wrong)} in these, {sure(looks.confidence_right)} in the others"
    )


def mapping_lines(mapping: MappingSummary | None) -> list[str]:
    """Return how a mapping went, line by line."""
    if mapping is None:
        return ["no keyframe was written"]
    m = mapping
    width_m, height_m = m.cols * m.resolution_m, m.rows * m.resolution_m
    drawn = f"{width_m:.1f} x {height_m:.1f} m, {m.cols} x {m.rows} pixels of {m.resolution_m:g} m"
    lines = [
        f"keyframes: {m.keyframes} in {m.duration_s:.0f} s; particles: {m.particles}",
        f"map: {drawn}" if m.rows else "map: none was drawn",
        f"particles drawn again: {m.resampled} times",
        f"scan matching failed: {_unmatched(m)}",
        f"largest jump from odometry's guess: {m.jump_m.value:.2f} m at keyframe {m.jump_m.keyframe}, "
        f"{m.jump_deg.value:.0f} deg at keyframe {m.jump_deg.keyframe}",
        f"odometry alone ends {m.from_odometry_m:.2f} m away",
    ]
    if m.error_m is not None:
        lines.append(
            f"distance from the truth: at most {m.error_m.value:.2f} m, at keyframe {m.error_m.keyframe}; "
            f"at the end {m.last_error_m:.2f} m"
        )
    failed = (m.lost or m.unmatched)[-1:]
    moments = [
        *(f"#{keyframe} (scan matching failed)" for keyframe in failed),
        f"#{m.jump_m.keyframe} (the largest jump in metres)",
        f"#{m.jump_deg.keyframe} (the largest in degrees)",
    ]
    return [*lines, f"  look at it: timeline keyframe, {', '.join(moments)}"]


def _unmatched(mapping: MappingSummary) -> str:
    if not mapping.unmatched:
        return "at no keyframe"
    latest = ", ".join(map(str, mapping.unmatched[-MAX_FAILURES:]))
    some = f"at {len(mapping.unmatched)} keyframes for some particles, at {len(mapping.lost)} for all"
    return f"{some}; the last ones: {latest}"


def no_trial(summary: Summary) -> str:
    """Return why a recording has no trials, as far as it tells."""
    if summary.ending == "learned":
        return "no trial was made: every goal was learned before"
    return "no trial was made" if summary.ending else "no trial was written"


def _goals_table(goals: tuple[TrainedGoal, ...]) -> Table:
    """Return the goals in the order of training."""
    table = Table(box=None, pad_edge=False)
    for heading in ("", "goal", "trials", "of them", "actions", "learned", "chosen because (TD errors)"):
        table.add_column(heading, justify="right" if heading in ("of them", "actions") else "left")
    for rank, turn in enumerate(goals, start=1):
        learned = "no" if turn.learned_at_trial is None else f"after action {turn.learned_at_step:,}"
        trials = f"{turn.first_trial} to {turn.last_trial}" if turn.trials else "none"
        table.add_row(str(rank), turn.goal, trials, str(turn.trials), f"{turn.actions:,}", learned, because(turn))
    return table


def because(turn: TrainedGoal) -> str:
    """Return the rule's reason with the numbers behind it, where they are known."""
    if turn.td_error is None:
        return turn.reason
    rival = None if turn.rival_td_error is None else (turn.rival, turn.rival_td_error)
    return why_chosen(turn.reason, turn.td_error, rival)


def _trials_table(rows: tuple[TrialRow, ...]) -> Table:
    table = Table(box=None, pad_edge=False)
    for heading in ("trial", "goal", "outcome", "actions", "shortest", "cause"):
        table.add_column(heading, justify="right" if heading in ("trial", "actions", "shortest") else "left")
    for row in rows:
        table.add_row(str(row.number), row.goal, row.outcome, str(row.steps), str(row.shortest), row.cause)
    return table
