"""Pairs shared among processes give the figures of one process."""

from __future__ import annotations

from pathlib import Path

import pytest

from twonav_cli.events import to_nobody
from twonav_cli.experiments.evaluation import PairResult, evaluate_pairs, pairs_of
from twonav_cli.experiments.shared_evaluation import Drive, evaluate_shared, open_drive
from twonav_cli.mapping.floor import Floor, read_floor


@pytest.fixture
def floor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Floor:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    return read_floor("kitchen")


@pytest.mark.parametrize("stage", ["maze", "2d"])
def test_two_workers_find_what_one_process_finds(floor: Floor, stage: str) -> None:
    drive, told = Drive("kitchen", stage, seed=4), list[PairResult]()
    shared = evaluate_shared(drive, floor, 2, 2, told.append, lambda: False)
    world, agent = open_drive(drive, floor)
    alone = evaluate_pairs(world, agent, 4, to_nobody, lambda pair: None, lambda: False, pairs_of(floor.maze, 2))
    assert len(alone.pairs) == 50
    assert shared.pairs == alone.pairs
    assert sorted(told, key=repr) == sorted(shared.pairs, key=repr)


def test_an_evaluation_that_is_stopped_keeps_what_was_driven(floor: Floor) -> None:
    told = list[PairResult]()
    table = evaluate_shared(Drive("kitchen", "maze"), floor, 3, 2, told.append, lambda: len(told) >= 20)
    assert 20 <= len(table.pairs) < 75
    assert len(told) == len(table.pairs)
