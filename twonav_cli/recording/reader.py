"""Reads a recording back: what was run, how its trials went, and whether it ended properly."""

from __future__ import annotations

import json
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from rerun.chunk import RrdReader

from twonav_cli.errors import TwonavError
from twonav_cli.recording.flight import has_failed
from twonav_cli.recording.looks import CONFIDENCE, ERROR, LookSummary, look_summary
from twonav_cli.recording.mapped import MappingSummary, mapping_summary
from twonav_cli.recording.trained_goals import TrainedGoal, Walked, trained_goals

MAGIC = b"RRF2"


@dataclass(frozen=True)
class TrialRow:
    """One trial as recorded."""

    number: int
    """Number of the trial."""
    goal: str
    start_row: int
    start_col: int
    outcome: str
    steps: int
    shortest: int
    cause: str
    evidence: str
    first_step: int
    last_step: int
    start_s: float
    end_s: float
    sampled: bool
    """Whether it was picked out of many compiled trials."""

    @property
    def failed(self) -> bool:
        """Whether it failed; one that was given up for another goal did not."""
        return has_failed(self.outcome)


@dataclass(frozen=True)
class AddedGoal:
    """A goal that was added while the run went on."""

    goal: str
    row: int
    col: int
    at_trial: int
    """The clock's trial at that moment."""


@dataclass(frozen=True)
class Summary:
    """What a recording holds."""

    path: Path
    kind: str
    """"map", "maze", "2d", "3d" or "localizer"."""
    command: str
    scene: str
    stage: str
    seed: int
    settings: dict[str, str]
    goals: tuple[str, ...]
    """Those that the run began with."""
    added: tuple[AddedGoal, ...]
    trials: tuple[TrialRow, ...]
    counts: dict[str, int]
    """Outcome to number of trials, compiled ones included."""
    goal_counts: dict[str, tuple[int, int]]
    """Goal to (trials that reached it, trials that did not)."""
    learning: tuple[TrainedGoal, ...]
    """The goals in the order of training; empty when nothing was trained, or goals were chosen by a person."""
    metrics: dict[str, float]
    """Last validation of a network's training, else empty."""
    ending: str
    """What the run said at its end; empty when it never said it."""
    whole: bool
    """Whether the writer closed the file; a killed one did not."""
    mapping: MappingSummary | None = None
    """How the mapping went, in a recording of the mapper."""
    warnings: tuple[str, ...] = ()
    """What the run warned of, such as a log whose odometry jumps."""
    looks: LookSummary | None = None
    """How often the robot took itself for somewhere else, where a localizer says how sure it is."""

    @property
    def failures(self) -> tuple[TrialRow, ...]:
        """The failed trials."""
        return tuple(row for row in self.trials if row.failed)


def how_to_seek(row: TrialRow, kind: str) -> str:
    """Return the sentence that says where in the viewer a trial is."""
    if kind in ("2d", "3d"):
        return f"timeline sim_time, +{row.start_s:.1f} s to +{row.end_s:.1f} s"
    return f"timeline trial, #{row.number} (step #{row.first_step} to #{row.last_step})"


def summarize(path: Path) -> Summary:
    """Read a recording that twonav wrote, also one whose writer was killed.

    Raises:
        TwonavError: Missing, not an .rrd file, cut off, or not made by twonav.
    """
    chunks, whole = _chunks(Path(path))
    run = _properties(chunks)
    if "kind" not in run or "scene" not in run:
        raise TwonavError(f"{path} was not recorded by twonav: open it with `rerun {path}`")
    trials = _trial_rows(chunks.get("/trials", []))
    goals = tuple(json.loads(run["goals"]))
    counts, goal_counts = _counts(trials, goals, chunks.get("/totals", []))
    endings = [row["outcome"] for row in _rows(chunks.get("/ending", []))]
    return Summary(
        path=Path(path),
        kind=run["kind"],
        command=run["command"],
        scene=run["scene"],
        stage=run["stage"],
        seed=int(run["seed"]),
        settings=json.loads(run["settings"]),
        goals=goals,
        added=tuple(AddedGoal(**row) for row in _rows(chunks.get("/added", []))),
        trials=trials,
        counts=counts,
        goal_counts=goal_counts,
        learning=_learning(chunks, trials) if run["command"] == "train" else (),
        metrics=_last_metrics(chunks),
        ending=endings[-1] if endings else "",
        whole=whole,
        mapping=mapping_summary(list(_rows(chunks.get("/keyframes", []))), list(_rows(chunks.get("/drawings", [])))),
        warnings=tuple(row["text"] for row in _rows(chunks.get("/warnings", []))),
        looks=look_summary(chunks.get(ERROR, []), chunks.get(CONFIDENCE, [])),
    )


def _chunks(path: Path) -> tuple[dict[str, list[Any]], bool]:
    """Return the record batches by entity, and whether the file has its footer."""
    try:
        with path.open("rb") as file:
            magic = file.read(len(MAGIC))
    except OSError as error:
        raise TwonavError(f"cannot read the recording {path}: {error.strerror or error}") from error
    if magic != MAGIC:
        raise TwonavError(f"{path} is not a Rerun recording of this version (.rrd)")
    found: dict[str, list[Any]] = {}
    with warnings.catch_warnings(record=True) as complaints:
        warnings.simplefilter("always")
        try:
            for chunk in RrdReader(str(path)).stream():
                entity = chunk.entity_path
                if entity in _READ or entity.startswith("/val/"):
                    found.setdefault(entity, []).append(chunk.to_record_batch())
        except (RuntimeError, ValueError, OSError) as error:
            repair = f"rerun rrd optimize {path} --continue-on-error -o repaired.rrd"
            raise TwonavError(f"{path} is cut off or damaged; what is left may be had with `{repair}`") from error
    return found, not any("footer" in str(complaint.message) for complaint in complaints)


_READ = {
    "/trials", "/totals", "/choices", "/learned", "/added", "/ending", "/keyframes", "/drawings", "/warnings",
    "/__properties/run", ERROR, CONFIDENCE,
}  # fmt: skip


def _rows(batches: list[Any]) -> Iterator[dict[str, Any]]:
    """Yield each row as component to value; a component of one value is that value."""
    for batch in batches:
        names = [field.name for field in batch.schema if (field.metadata or {}).get(b"rerun:kind") == b"data"]
        columns = {name: batch[name].to_pylist() for name in names}
        for index in range(batch.num_rows):
            row = {name: column[index] for name, column in columns.items() if column[index]}
            yield {name: value[0] if len(value) == 1 else value for name, value in row.items()}


def _properties(chunks: dict[str, list[Any]]) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for row in _rows(chunks.get("/__properties/run", [])):
        found |= row
    return found


def _trial_rows(batches: list[Any]) -> tuple[TrialRow, ...]:
    names = [field.name for field in fields(TrialRow)]
    rows = [TrialRow(**{name: row[name] for name in names}) for row in _rows(batches) if "number" in row]
    return tuple(sorted(rows, key=lambda row: row.number))


def _learning(chunks: dict[str, list[Any]], trials: tuple[TrialRow, ...]) -> tuple[TrainedGoal, ...]:
    compiled = any(row.sampled for row in trials)
    first = 1 if compiled else 0
    walked = [Walked(row.goal, row.number - first + 1, row.first_step, row.last_step) for row in trials]
    ends = [(trial.trials, trial.last_step) for trial in walked]
    choices, learned = list(_rows(chunks.get("/choices", []))), list(_rows(chunks.get("/learned", [])))
    known = [(row["after_trials"], row["after_steps"]) for row in (*choices, *learned)]
    return trained_goals(choices, learned, walked, max([*ends, *known], default=(0, 0)), first)


def _counts(
    trials: tuple[TrialRow, ...], goals: tuple[str, ...], totals: list[Any]
) -> tuple[dict[str, int], dict[str, tuple[int, int]]]:
    outcomes: Counter[str] = Counter(row.outcome for row in trials if not row.sampled)
    reached: Counter[str] = Counter(row.goal for row in trials if not row.sampled and not row.failed)
    failed: Counter[str] = Counter(row.goal for row in trials if not row.sampled and row.failed)
    last = {name: _as_list(value) for name, value in max(_rows(totals), key=_size, default={}).items()}
    for index, goal in enumerate(goals):
        reached[goal] += int(last["reached"][index]) if last else 0
        failed[goal] += int(last["failed"][index]) if last else 0
    if last:
        outcomes["reached"] += int(sum(last["reached"]))
        outcomes["time-out"] += int(sum(last["failed"]))
    names = [*goals, *(name for name in {**reached, **failed} if name not in goals)]
    per_goal = {name: (reached[name], failed[name]) for name in names}
    return {name: count for name, count in outcomes.most_common() if count}, per_goal


def _as_list(value: Any) -> list[Any]:
    return value if isinstance(value, list) else [value]


def _size(row: dict[str, Any]) -> int:
    """Sums only grow: the row of most trials is the last one."""
    return int(sum(_as_list(row["reached"])) + sum(_as_list(row["failed"])))


def _last_metrics(chunks: dict[str, list[Any]]) -> dict[str, float]:
    """Return the latest value of every validation metric."""
    found: dict[str, float] = {}
    for entity, batches in chunks.items():
        if not entity.startswith("/val/"):
            continue
        latest: tuple[int, float] | None = None
        for batch in batches:
            if "batch" not in batch.schema.names:
                continue
            for when, value in zip(batch["batch"].to_pylist(), batch["Scalars:scalars"].to_pylist(), strict=True):
                if value and (latest is None or when >= latest[0]):
                    latest = (when, float(value[0]))
        if latest is not None:
            found[entity.rsplit("/", 1)[-1]] = latest[1]
    return found
