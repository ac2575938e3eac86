"""`twonav reproduce table9`, `table10` and `fig9` as a user meets them."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from twonav_cli.recording.reader import summarize
from twonav_cli.terminal import reproduce_fig9, reproduce_transfer
from twonav_cli.worker_pool import StoppedError

if TYPE_CHECKING:
    from command_line import Twonav

pytest_plugins = ("command_line",)

KITCHEN = ["--scene", "kitchen", "--quick"]


@pytest.fixture
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the agents learn in this process."""

    def in_turn(
        work: Callable[[Any], Any], jobs: Sequence[Any], processes: int, should_stop: Callable[[], bool]
    ) -> Iterator[tuple[int, Any]]:
        for number, job in enumerate(jobs):
            if should_stop():
                raise StoppedError
            yield number, work(job)

    monkeypatch.setattr(reproduce_transfer, "done_in_workers", in_turn)


@pytest.mark.usefixtures("here")
def test_table_9_and_10_train_what_is_missing_and_are_printed_and_written(
    twonav: Twonav, runs: Path, tmp_path: Path
) -> None:
    asked = ["--repeats", "1", "--localizer", "truth", "--out", tmp_path]
    ended = twonav("reproduce", "table9", *KITCHEN, *asked)
    assert ended.code == 0
    assert "all, the paper's 27.0" in ended.out
    assert "25 of 25" in ended.out
    assert ended.out.splitlines()[-1].startswith("twonav reproduce table9 --repeats 1 --seed 0 --scene kitchen")
    report = json.loads((tmp_path / "table9-quick.json").read_text())
    assert report["ours"]["3d"]["agents"] == 1
    assert report["settings"]["command"] in ended.out
    assert (tmp_path / "table9-quick.png").stat().st_size > 1000
    other = twonav("reproduce", "table10", *KITCHEN, *asked, "--json").only_object()
    assert other["ours"]["transferred"]["agents"] == other["ours"]["from-nothing"]["agents"] == 1
    assert other["paper"]["not_reached"][1] == 3
    assert "80.1" in other["errata"][0]["text"]


@pytest.mark.usefixtures("here")
def test_only_finished_trains_nothing(twonav: Twonav, tmp_path: Path) -> None:
    ended = twonav("reproduce", "table10", *KITCHEN, "--only-finished", "--out", tmp_path, "--json")
    assert ended.only_object()["goals"] == []


def test_fig_9_is_printed_drawn_and_recorded(twonav: Twonav, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reproduce_fig9, "QUICK_LOOKS", 60)
    ended = twonav("reproduce", "fig9", *KITCHEN, "--networks", "inception-9", "--out", tmp_path)
    assert ended.code == 0
    report = json.loads((tmp_path / "fig9-quick.json").read_text())
    assert report["looks"] == 60
    assert f"{report['wrong']} of 60 looks" in ended.out
    assert (tmp_path / "fig9-quick.png").stat().st_size > 5000
    assert summarize(tmp_path / "fig9-quick.rrd").kind == "3d"


def test_a_network_that_is_not_there_is_one_line(twonav: Twonav) -> None:
    assert (
        "twonav train --stage localizer --scene kitchen --network cnn-7"
        in twonav("reproduce", "fig9", *KITCHEN, "--networks", "cnn-7").complaint
    )
    assert "unknown network" in twonav("reproduce", "fig9", "--networks", "cnn-8").complaint
