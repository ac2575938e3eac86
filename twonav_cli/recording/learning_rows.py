"""Rows about trials: how each ended, the TD errors after it, sums per goal. G goals, n trials.

A long run in the maze has hundreds of thousands of trials: beyond ROWS_PER_DOUBLING rows each row stands for two
trials, then four, and so on, so that the file grows with the logarithm of the run.
"""

from __future__ import annotations

from collections import deque
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from twonav_cli.events import Clock, GoalAdded, GoalLearned, QSnapshot, TrialBatch, TrialEnded, TrialStarted
from twonav_cli.maze import Maze
from twonav_cli.recording.columns import curves_of_goals, goal_errors, log10_error
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.goal_list import GoalList
from twonav_cli.recording.rounds import Rounds
from twonav_cli.recording.rrd_file import RrdFile

FloatArray = NDArray[np.float64]

ROWS_PER_DOUBLING = 10_000
BATCH_TRIALS = 1000
"""Compiled trials that are collected before they are written."""
STORY = ("choices", "learned", "log")
"""Tracks that are written before trials, all at level TRIAL: what a killed run leaves of them is never older."""
SHARE_TRIALS = 20
"""Trials over which the share of successes is taken."""
TABLE_TRIALS = 30
"""Trials in the table of the "Trials" tab."""
TABLE_HEAD = (
    "| trial | from | goal | outcome | actions | shortest | cause | evidence | sim_time |\n" + "|---" * 9 + "|\n"
)


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
    columns = ("goal", "start", "steps", "reached", "shortest", "last_step")
    width = max(batch.td_errors.shape[1] for batch in batches)
    # A goal that was added between two batches has no TD error in the first.
    errors = [np.pad(b.td_errors, ((0, 0), (0, width - b.td_errors.shape[1])), constant_values=np.nan) for b in batches]
    return TrialBatch(
        batches[-1].clock,
        **{name: np.concatenate([getattr(b, name) for b in batches]) for name in columns},
        td_errors=np.concatenate(errors),
    )


class LearningRows:
    """Turns trials into rows."""

    def __init__(self, file: RrdFile, maze: Maze, goals: GoalList) -> None:
        self._file, self._maze, self._goals = file, maze, goals
        self._recent: deque[bool] = deque(maxlen=SHARE_TRIALS)
        self._start = TrialStarted(Clock(), "", next(iter(maze.starts.values()), maze.free_cells[0]))
        self._table: deque[str] = deque(maxlen=TABLE_TRIALS)
        self._waiting: list[TrialBatch] = []
        self._rounds = Rounds(max(len(maze.starts), 1))
        self._rows = 0
        self._goal = -1
        self._compiled = np.zeros((4, len(goals)), dtype=np.int64)
        self._single = self._compiled.copy()

    def goal_added(self, event: GoalAdded) -> None:
        """Make room for the new goal's sums."""
        new = ((0, 0), (0, len(self._goals) - self._compiled.shape[1]))
        self._compiled, self._single = np.pad(self._compiled, new), np.pad(self._single, new)

    def trial_started(self, event: TrialStarted) -> None:
        """Colour the lane of goals from here on."""
        self._start = event
        self._file.put("state/goal", event.goal, event.clock, Detail.TRIAL)

    def trial_ended(self, event: TrialEnded) -> None:
        """Write the trial's row, its curves, its sentence; its colours are dated back to its first moment."""
        put, clock, start = self._file.put, event.clock, self._start.clock
        reached = event.outcome == "reached"
        self._recent.append(reached)
        put("trials", trial_row(event, start), clock, Detail.TRIAL)
        put("state/outcome", event.outcome, start, Detail.TRIAL)
        put("state/cause", event.cause or "none", start, Detail.TRIAL)
        put("learning/steps", (event.steps, event.shortest), clock, Detail.TRIAL)
        put("learning/reached", sum(self._recent) / len(self._recent), clock, Detail.TRIAL)
        put("log", trial_sentence(event), clock, Detail.TRIAL)
        self._table.appendleft(table_row(event, start))
        put("table", TABLE_HEAD + "\n".join(self._table), clock, Detail.TRIAL)
        if event.goal in self._goals:
            shortest = max(event.shortest, 0)
            self._single[:, self._goals.names.index(event.goal)] += (reached, not reached, event.steps, shortest)
            self._show_totals(clock)

    def snapshot(self, event: QSnapshot) -> None:
        """Write the TD error of every goal, unless what was never tried counts in it, which a table does not tell."""
        if event.td_errors is None:
            return
        means = event.td_errors[:, ~self._maze.blocked].mean(axis=(1, 2))
        if not np.isnan(means).any():
            row = goal_errors(self._goals.at_start, means)
            self._file.put("learning/td_error", row, event.clock, Detail.TRIAL)

    def batch(self, event: TrialBatch) -> None:
        """Collect compiled trials and write them when there are enough."""
        if len(event.steps) == 0:
            return
        if event.goal[0] != self._goal:
            begun = Clock(event.clock.trial - len(event.steps), int(event.last_step[0] - event.steps[0]))
            self._file.put("state/goal", self._goals.name_of(int(event.goal[0])), begun, Detail.TRIAL)
        self._goal = int(event.goal[-1])
        self._waiting.append(event)
        moments, means = self._rounds.add(event)
        for (trial, step), mean in list(zip(moments.tolist(), means, strict=True))[:: self._every()]:
            self._file.put("learning/round", mean, Clock(trial, step, event.clock.time_s), Detail.TRIAL)
        if sum(len(batch.steps) for batch in self._waiting) >= BATCH_TRIALS:
            self.write_batches()

    def goal_learned(self, event: GoalLearned) -> None:
        """Write the trials up to here, so that their sums are those of whole goals."""
        self.write_batches()

    def _every(self) -> int:
        """Number of trials that a row stands for by now."""
        return int(2 ** (self._rows // ROWS_PER_DOUBLING))

    def write_batches(self) -> None:
        """Write the compiled trials that were collected."""
        if not self._waiting:
            return
        batch = _joined(self._waiting)
        self._waiting = []
        last, lengths, share = thinned(batch, self._every())
        # The run's own count: a recording of a run that was gone on with does not begin at its first trial.
        before = batch.clock.trial - len(batch.steps)
        clocks = [Clock(before + 1 + int(i), int(batch.last_step[i]), batch.clock.time_s) for i in last]
        self._rows += len(last)
        self._file.ship_first(STORY)
        send = self._file.send
        powers = log10_error(batch.td_errors[last])
        for entity, curves in curves_of_goals("learning/td_error", self._goals.at_start, powers):
            send(entity, clocks, curves)
        send("learning/steps", clocks, rr.Scalars.columns(scalars=lengths))
        send("learning/reached", clocks, rr.Scalars.columns(scalars=share))
        send("trials", clocks, rr.AnyValues.columns(**self._batch_rows(batch, last, clocks)))
        self._add_to_totals(batch, clocks[-1])

    def _batch_rows(self, batch: TrialBatch, last: NDArray[np.int64], clocks: list[Clock]) -> dict[str, Any]:
        cells = list(self._maze.starts.values())
        starts = [cells[i] for i in batch.start[last]]
        first_steps = batch.last_step[last] - batch.steps[last]
        return {
            "number": [clock.trial for clock in clocks],
            "goal": [self._goals.name_of(int(i)) for i in batch.goal[last]],
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
        goals = self._compiled.shape[1]
        for row, weights in enumerate((batch.reached, ~batch.reached, batch.steps, batch.shortest)):
            counts = np.bincount(batch.goal, weights=weights.astype(np.float64), minlength=goals)
            self._compiled[row] += counts[:goals].astype(np.int64)
        sums: dict[str, Any] = dict(zip(TOTALS, self._compiled.copy(), strict=True))
        # As columns, which go out at once: a row of `now` waits, and would be lost when the run is killed.
        self._file.send("totals", [clock], rr.AnyValues.columns(**sums).partition([goals]))
        self._show_totals(clock)

    def _show_totals(self, clock: Clock) -> None:
        text = totals_text(self._goals.names, self._compiled + self._single)
        self._file.now("learning/totals", rr.TextDocument(text, media_type="text/markdown"), clock)


TOTALS = ("reached", "failed", "steps", "shortest")
"""Sums per goal [G] over all compiled trials of the recording so far, whether their rows were kept or not."""


def totals_text(goals: list[str], totals: NDArray[np.int64]) -> str:
    """Return the sums [4, G] as a table in Markdown."""
    rows = []
    for index, goal in enumerate(goals):
        reached, failed, steps, shortest = (int(total) for total in totals[:, index])
        trials = max(reached + failed, 1)
        rows.append(f"| {goal} | {reached} | {failed} | {steps:,} | {steps / trials:.1f} | {shortest / trials:.1f} |")
    head = "| goal | reached | not | actions | per trial | shortest |\n" + "|---" * 6 + "|\n"
    return head + "\n".join(rows)


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
