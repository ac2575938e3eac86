"""Rows about learning: chosen goals, trials, TD errors. G goals, n trials.

A long run in the maze has hundreds of thousands of trials: beyond ROWS_PER_DOUBLING rows each row stands for two
trials, then four, and so on, so that the file grows with the logarithm of the run.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.events import Clock, GoalChosen, GoalLearned, TrialBatch, TrialEnded, TrialStarted
from twonav_cli.maze import Maze
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.rrd_file import RrdFile

FloatArray = NDArray[np.float64]

ROWS_PER_DOUBLING = 10_000
BATCH_TRIALS = 1000
"""Compiled trials that are collected before they are written."""
SHARE_TRIALS = 20
"""Trials over which the share of successes is taken."""
SMALLEST_ERROR = 1e-4
TABLE_TRIALS = 30
"""Trials in the table of the "Trials" tab."""
TABLE_HEAD = (
    "| trial | from | goal | outcome | actions | shortest | cause | evidence | sim_time |\n" + "|---" * 9 + "|\n"
)


def log10_error(td_errors: FloatArray) -> FloatArray:
    """Return log10 of TD errors of any shape, cut at SMALLEST_ERROR: plots have no logarithmic axis."""
    return np.asarray(np.log10(np.maximum(td_errors, SMALLEST_ERROR)), dtype=np.float64)


def thinned(batch: TrialBatch, every: int) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Return each group of `every` trials as one row.

    Returns:
        Index of each group's last trial [k], mean (taken, shortest) actions [k, 2], share that reached the goal [k].
    """
    count = len(batch.steps)
    starts = np.arange(0, count, every)
    last = np.minimum(starts + every, count) - 1
    sizes = last - starts + 1
    lengths = np.stack([batch.steps, batch.shortest], axis=1).astype(np.float64)
    means = np.add.reduceat(lengths, starts, axis=0) / sizes[:, None]
    share = np.add.reduceat(batch.reached.astype(np.float64), starts) / sizes
    return last.astype(np.int64), means, share


def _joined(batches: list[TrialBatch]) -> TrialBatch:
    columns = ("goal", "start", "steps", "reached", "shortest", "td_errors", "last_step")
    return TrialBatch(
        batches[-1].clock, **{name: np.concatenate([getattr(b, name) for b in batches]) for name in columns}
    )


class LearningRows:
    """Turns choices and trials into rows."""

    def __init__(self, file: RrdFile, maze: Maze) -> None:
        self._file = file
        self._maze = maze
        self._choices = dict.fromkeys(maze.goals, 0)
        self._recent: deque[bool] = deque(maxlen=SHARE_TRIALS)
        self._start = TrialStarted(Clock(), "", next(iter(maze.starts.values()), maze.free_cells[0]))
        self._table: deque[str] = deque(maxlen=TABLE_TRIALS)
        self._waiting: list[TrialBatch] = []
        self._rows = 0
        self._trials = 0
        self._totals = np.zeros((4, len(maze.goals)), dtype=np.int64)

    def goal_chosen(self, event: GoalChosen) -> None:
        """Write the choice, its reason and the TD errors behind it."""
        if event.goal in self._choices:
            self._choices[event.goal] += 1
        put, clock = self._file.put, event.clock
        put("log", ("INFO", f"goal {event.goal}: {event.reason}"), clock, Detail.TRIAL)
        if event.td_errors is not None:
            put("learning/td_error", log10_error(event.td_errors), clock, Detail.TRIAL)
        self._file.now("learning/choice", rr.TextDocument(self._choice_text(event), media_type="text/markdown"), clock)
        counts = np.array(list(self._choices.values()))
        self._file.now("learning/choices", rr.BarChart(counts, abscissa=np.arange(len(counts))), clock)

    def _choice_text(self, event: GoalChosen) -> str:
        errors = event.td_errors if event.td_errors is not None else np.full(len(self._choices), np.nan)
        rows = [
            f"| {i} | {'**' + name + '**' if name == event.goal else name} | {errors[i]:.3g} | {self._choices[name]} |"
            for i, name in enumerate(self._choices)
        ]
        head = "|  | goal | TD error | chosen |\n|---|---|---|---|\n"
        return f"## {event.goal}\n{event.reason}\n\n{head}" + "\n".join(rows)

    def trial_started(self, event: TrialStarted) -> None:
        """Colour the lane of goals from here on."""
        self._start = event
        self._file.put("state/goal", event.goal, event.clock, Detail.TRIAL)

    def trial_ended(self, event: TrialEnded) -> None:
        """Write the trial's row, its curves, its sentence; its colours are dated back to its first moment."""
        put, clock, start = self._file.put, event.clock, self._start.clock
        reached = event.outcome == "reached"
        self._recent.append(reached)
        self._trials = max(self._trials, clock.trial)
        put("trials", trial_row(event, start), clock, Detail.TRIAL)
        put("state/outcome", event.outcome, start, Detail.TRIAL)
        put("state/cause", event.cause or "none", start, Detail.TRIAL)
        put("learning/steps", (event.steps, event.shortest), clock, Detail.TRIAL)
        put("learning/reached", sum(self._recent) / len(self._recent), clock, Detail.TRIAL)
        put("log", trial_sentence(event), clock, Detail.TRIAL)
        self._table.appendleft(table_row(event, start))
        put("table", TABLE_HEAD + "\n".join(self._table), clock, Detail.TRIAL)

    def goal_learned(self, event: GoalLearned) -> None:
        """Write that a goal met the criterion."""
        self._file.put("log", ("INFO", f"goal {event.goal} is learned"), event.clock, Detail.TRIAL)

    def batch(self, event: TrialBatch) -> None:
        """Collect compiled trials and write them when there are enough."""
        self._waiting.append(event)
        if sum(len(batch.steps) for batch in self._waiting) >= BATCH_TRIALS:
            self.write_batches()

    def write_batches(self) -> None:
        """Write the compiled trials that were collected."""
        if not self._waiting:
            return
        batch = _joined(self._waiting)
        self._waiting = []
        if len(batch.steps) == 0:
            return
        last, lengths, share = thinned(batch, 2 ** (self._rows // ROWS_PER_DOUBLING))
        clocks = [Clock(self._trials + 1 + int(i), int(batch.last_step[i]), batch.clock.time_s) for i in last]
        self._rows += len(last)
        self._trials += len(batch.steps)
        send = self._file.send
        send("learning/td_error", clocks, rr.Scalars.columns(scalars=log10_error(batch.td_errors[last])))
        send("learning/steps", clocks, rr.Scalars.columns(scalars=lengths))
        send("learning/reached", clocks, rr.Scalars.columns(scalars=share))
        send("trials", clocks, rr.AnyValues.columns(**self._batch_rows(batch, last, clocks)))
        self._add_to_totals(batch, clocks[-1])

    def _batch_rows(self, batch: TrialBatch, last: NDArray[np.int64], clocks: list[Clock]) -> dict[str, Any]:
        goals, cells = self._maze.goal_names, list(self._maze.starts.values())
        starts = [cells[i] for i in batch.start[last]]
        first_steps = batch.last_step[last] - batch.steps[last]
        return {
            "number": [clock.trial for clock in clocks],
            "goal": [goals[i] for i in batch.goal[last]],
            "start_row": [cell.row for cell in starts],
            "start_col": [cell.col for cell in starts],
            "outcome": ["reached" if reached else "time-out" for reached in batch.reached[last]],
            "steps": batch.steps[last].tolist(),
            "shortest": batch.shortest[last].tolist(),
            "cause": ["" if reached else "time-out" for reached in batch.reached[last]],
            "evidence": [""] * len(last),
            "first_step": first_steps.tolist(),
            "last_step": batch.last_step[last].tolist(),
            "start_s": [clock.time_s for clock in clocks],
            "end_s": [clock.time_s for clock in clocks],
            "sampled": [True] * len(last),
        }

    def _add_to_totals(self, batch: TrialBatch, clock: Clock) -> None:
        goals = len(self._maze.goals)
        for row, weights in enumerate((batch.reached, ~batch.reached, batch.steps, batch.shortest)):
            counts = np.bincount(batch.goal, weights=weights.astype(np.float64), minlength=goals)
            self._totals[row] += counts.astype(np.int64)
        sums: dict[str, Any] = dict(zip(TOTALS, self._totals.copy(), strict=True))
        self._file.now("totals", rr.AnyValues(**sums), clock)
        chosen = self._totals[0] + self._totals[1]
        self._file.now("learning/choices", rr.BarChart(chosen, abscissa=np.arange(goals)), clock)
        text = totals_text(self._maze.goal_names, self._totals)
        self._file.now("learning/choice", rr.TextDocument(text, media_type="text/markdown"), clock)


TOTALS = ("reached", "failed", "steps", "shortest")
"""Sums per goal [G] over all compiled trials so far, whether their rows were kept or not."""


def totals_text(goals: list[str], totals: NDArray[np.int64]) -> str:
    """Return the sums [4, G] as a table in Markdown."""
    rows = []
    for index, goal in enumerate(goals):
        reached, failed, steps, shortest = (int(total) for total in totals[:, index])
        trials = max(reached + failed, 1)
        rows.append(f"| {index} | {goal} | {reached} | {failed} | {steps / trials:.1f} | {shortest / trials:.1f} |")
    head = "|  | goal | reached | not | mean actions | mean shortest |\n|---|---|---|---|---|---|\n"
    return "## All trials so far\n" + head + "\n".join(rows)


def trial_row(event: TrialEnded, start: Clock) -> dict[str, Any]:
    """Return the machine-readable row of a trial."""
    return {
        "number": event.clock.trial,
        "goal": event.goal,
        "start_row": event.start.row,
        "start_col": event.start.col,
        "outcome": event.outcome,
        "steps": event.steps,
        "shortest": event.shortest,
        "cause": event.cause,
        "evidence": event.evidence,
        "first_step": start.step,
        "last_step": event.clock.step,
        "start_s": start.time_s,
        "end_s": event.clock.time_s,
        "sampled": False,
    }


def table_row(event: TrialEnded, start: Clock) -> str:
    """Return the row of a trial in the table of the "Trials" tab."""
    outcome = event.outcome if event.outcome == "reached" else f"**{event.outcome}**"
    when = f"+{start.time_s:.1f} s to +{event.clock.time_s:.1f} s"
    fields = (
        event.clock.trial,
        tuple(event.start),
        event.goal,
        outcome,
        event.steps,
        event.shortest,
        event.cause,
        event.evidence.replace("|", "/"),
        when,
    )
    return "| " + " | ".join(str(field) for field in fields) + " |"


def trial_sentence(event: TrialEnded) -> tuple[str, str]:
    """Return level and sentence for the log: what happened, the cause, the evidence."""
    level = {"reached": "INFO", "given-up": "INFO", "time-out": "WARN"}.get(event.outcome, "ERROR")
    text = f"trial {event.clock.trial} to {event.goal}: {event.outcome} after {event.steps} actions"
    if event.shortest >= 0:
        text += f" (shortest {event.shortest})"
    cause = f". Cause: {event.cause}" if event.cause else ""
    evidence = f". Evidence: {event.evidence}" if event.evidence else ""
    return level, text + cause + evidence
