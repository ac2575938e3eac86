"""What recording costs: the same made-up events with and without a recorder, in one run.

    python benchmarks/bench_recorder.py [--trials 40] [--action-ms 15]

Prints milliseconds and bytes per action, and the share of an action of the 3D stage (12 ticks) that recording takes.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

from twonav_cli import events
from twonav_cli.events import Event, Sink, to_nobody
from twonav_cli.recording import rehearsal
from twonav_cli.recording.recorder import Recorder


def seconds_of(sink: Sink, sent: Sequence[Event]) -> tuple[float, float]:
    """Return wall and processor seconds that a sink takes for the events (processor: all threads of the writer)."""
    wall, cpu = time.perf_counter(), time.process_time()
    for event in sent:
        sink(event)
    return time.perf_counter() - wall, time.process_time() - cpu


def main() -> None:
    """Measure playing (everything kept) and training (flight recorder)."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--trials", type=int, default=40)
    parser.add_argument("--action-ms", type=float, default=15.0, help="what an action of the 3D stage costs")
    given = parser.parse_args()
    sent = list(rehearsal.driven_run(given.trials))
    first = next(index for index, event in enumerate(sent) if isinstance(event, events.TrialEnded)) + 1
    actions = sum(isinstance(event, events.StepTaken) for event in sent[first:])
    nothing = seconds_of(to_nobody, sent[first:])
    print(f"{given.trials} trials, {actions} actions, {len(sent)} events; an action costs {given.action_ms} ms")
    with tempfile.TemporaryDirectory() as folder:
        for name, every_trial in (("playing", True), ("training", False)):
            path = Path(folder) / f"{name}.rrd"
            recorder = Recorder(path, "3d", every_trial=every_trial)
            for event in sent[:first]:  # opening the file costs half a second, once
                recorder(event)
            before = path.stat().st_size
            wall, cpu = seconds_of(recorder, sent[first:])
            recorder.close()
            ms, cpu_ms = (1e3 * (took - idle) / actions for took, idle in zip((wall, cpu), nothing, strict=True))
            print(
                f"{name}: {ms:.2f} ms an action ({ms / given.action_ms:.1%}), {cpu_ms:.2f} ms of processor, "
                f"{(path.stat().st_size - before) / actions / 1e3:.1f} kB an action"
            )


if __name__ == "__main__":
    main()
