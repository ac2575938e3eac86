"""Many learning runs, one after the other or on several processors; the same seed gives the same runs either way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from twonav_cli.config import LearningConfig
from twonav_cli.experiments.learning_run import LearningRun, never, run_learner
from twonav_cli.maze import Maze
from twonav_cli.rng import stream
from twonav_cli.worker_pool import StoppedError, done_in_workers

STEPS_AT_MOST = 5_000_000
"""Actions after which a run gives up (ours): twenty times what the paper's single-goal learner takes on average."""

CHUNKS_PER_PROCESSOR = 16
"""So that the last chunk is short beside the whole, and handing one over costs little."""

ITEMS_PER_CHUNK = 8
"""At most, so that the progress bar moves."""


@dataclass(frozen=True)
class Item:
    """One learning run to make: what learns, where, and which repeat it is."""

    config: LearningConfig
    maze: int
    """Number of the maze in the list that goes with the items."""
    repeat: int

    def seed(self, seed: int) -> int:
        """Return the seed of this run.

        It does not depend on the settings: learners are compared on the same random numbers, and the run can be made
        again beside others.
        """
        return int(stream(seed, "repeat", self.maze, self.repeat).integers(2**31))


def make_runs(
    items: Sequence[Item],
    mazes: Sequence[Maze],
    seed: int,
    processes: int = 1,
    should_stop: Callable[[], bool] = never,
    on_run: Callable[[LearningRun], None] = lambda run: None,
    steps_at_most: int = STEPS_AT_MOST,
) -> list[LearningRun]:
    """Make every run and return them in the order of the items.

    Args:
        items: What to run.
        mazes: The items' mazes.
        seed: Each item draws from its own stream of it.
        processes: More than 1 shares the runs among so many workers.
        should_stop: Asked several times a second.
        on_run: Called after each run, in the order in which they end.
        steps_at_most: Actions after which a run gives up.

    Raises:
        StoppedError: `should_stop` said so.
        TwonavError: A run cannot be made, or a worker was killed.
    """
    runs: dict[int, LearningRun] = {}

    def keep(number: int, run: LearningRun) -> None:
        if run.outcome == "stopped":
            raise StoppedError
        runs[number] = run
        on_run(run)

    # One run of each learner here first: what it compiles is on disk before several workers want it.
    here = first_of_each_learner(items) if processes > 1 else range(len(items))
    for number in here:
        item = items[number]
        keep(number, run_item(item, mazes[item.maze], seed, should_stop, steps_at_most))
    left = [number for number in range(len(items)) if number not in runs]
    if left:

        def chunk_of(numbers: Sequence[int]) -> Chunk:
            wanted = tuple(items[number] for number in numbers)
            return Chunk(wanted, {item.maze: mazes[item.maze] for item in wanted}, seed, steps_at_most)

        _make_in_workers(left, chunk_of, processes, should_stop, keep)
    return [runs[number] for number in range(len(items))]


def run_item(item: Item, maze: Maze, seed: int, should_stop: Callable[[], bool], steps_at_most: int) -> LearningRun:
    """Make one run."""
    return run_learner(maze, item.config, item.seed(seed), should_stop, steps_at_most)


def first_of_each_learner(items: Sequence[Item]) -> list[int]:
    """Return the number of the first item of every learner."""
    first: dict[str, int] = {}
    for number, item in enumerate(items):
        first.setdefault(item.config.learner, number)
    return list(first.values())


@dataclass(frozen=True)
class Chunk:
    """Some runs that a worker makes at once, with everything it needs for them."""

    items: tuple[Item, ...]
    mazes: dict[int, Maze]
    """Number to maze, only those of the items."""
    seed: int
    steps_at_most: int


def run_chunk(chunk: Chunk) -> list[LearningRun]:
    """Make the runs of a chunk."""
    return [run_item(item, chunk.mazes[item.maze], chunk.seed, never, chunk.steps_at_most) for item in chunk.items]


def _make_in_workers(
    numbers: Sequence[int],
    chunk_of: Callable[[Sequence[int]], Chunk],
    processes: int,
    should_stop: Callable[[], bool],
    keep: Callable[[int, LearningRun], None],
) -> None:
    size = min(ITEMS_PER_CHUNK, max(1, len(numbers) // (processes * CHUNKS_PER_PROCESSOR)))
    parts = [numbers[first : first + size] for first in range(0, len(numbers), size)]
    for part, runs in done_in_workers(run_chunk, [chunk_of(part) for part in parts], processes, should_stop):
        for number, run in zip(parts[part], runs, strict=True):
            keep(number, run)
