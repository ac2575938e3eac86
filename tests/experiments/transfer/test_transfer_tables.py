"""Tables 9 and 10: agents that go through their stages, can be killed, and are put beside the paper's."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from twonav_cli.checkpoint import read_card, signed
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, GoalChosen, TrialEnded
from twonav_cli.experiments.paper_errata import errata_of
from twonav_cli.experiments.paper_figures import TABLE_9, TABLE_10
from twonav_cli.experiments.transfer import agent_chain
from twonav_cli.experiments.transfer.agent_chain import AgentJob, finished_card, run_agent
from twonav_cli.experiments.transfer.finished import finished_agents
from twonav_cli.experiments.transfer.request import CHAINS, FROM_NOTHING, TRANSFERRED, TransferRequest
from twonav_cli.experiments.transfer.stage_history import StageHistory
from twonav_cli.experiments.transfer.tables import transfer_report
from twonav_cli.grid import Cell
from twonav_cli.mapping.floor import Floor, read_floor

REQUEST = TransferRequest("table9", agents=2, scene="kitchen", localizer="truth", quick=True)


@pytest.fixture
def floor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Floor:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    # In 2D both chains take seconds; what 3D adds is the stage's own business.
    monkeypatch.setitem(CHAINS, TRANSFERRED, ("maze", "2d"))
    monkeypatch.setitem(CHAINS, FROM_NOTHING, ("2d",))
    return read_floor("kitchen")


def trial(goal: str, steps: int) -> TrialEnded:
    return TrialEnded(Clock(), goal, Cell(0, 0), "reached", steps, steps)


def test_a_history_keeps_every_trial_and_comes_back_from_a_card() -> None:
    history = StageHistory(["a", "b"])
    for event in (
        GoalChosen(Clock(), "b", "why"),
        trial("b", 5),
        trial("b", 4),
        GoalChosen(Clock(), "a", "why"),
        trial("a", 3),
    ):
        history(event)
    again = StageHistory.of_card({"metrics": {"history": history.kept()}}, ["a", "b"])
    assert again == history
    assert (again.goal_order, again.trial_goals, again.trial_steps) == (["b", "a"], [1, 1, 0], [5, 4, 3])
    assert StageHistory.of_card({}, ["a"]) == StageHistory(["a"])


def test_an_agent_learns_in_the_maze_goes_on_in_2d_and_is_driven_everywhere(floor: Floor) -> None:
    job = AgentJob(REQUEST, TRANSFERRED, 0)
    assert run_agent(job) == 0  # four trials teach no goal
    maze, flat = (read_card(job.folder(floor, stage)) for stage in ("maze", "2d"))
    assert all(maze["progress"]["trials_of_goal"])
    assert flat["metrics"]["trials"] == agent_chain.QUICK_TRIALS
    assert len(flat["metrics"]["pairs"]) == 25
    assert sum(pair["success"] for pair in flat["metrics"]["pairs"]) == 25
    written = (job.folder(floor, "2d") / "arrays.safetensors").stat().st_mtime_ns
    run_agent(job)
    assert (job.folder(floor, "2d") / "arrays.safetensors").stat().st_mtime_ns == written


class KilledError(Exception):
    """What a test kills an agent with."""


@pytest.mark.parametrize("where", ["learn_in_stage", "evaluate_pairs"])
def test_an_agent_that_was_killed_goes_on_and_ends_as_if_unbroken(
    floor: Floor, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    job, original = AgentJob(REQUEST, FROM_NOTHING, 0), getattr(agent_chain, where)
    run_agent(job)
    folder = job.folder(floor, "2d")
    whole, kept = read_card(folder), folder.rename(folder.with_name("kept"))

    def dies(world: Any, agent: Any, seed: int, sink: Any, *arguments: Any) -> None:
        if where == "evaluate_pairs":
            raise KilledError
        asked = list[int]()

        def killed_before_the_third_trial() -> bool:
            arguments[0]()  # which saves
            asked.append(1)
            if len(asked) == 3:
                raise KilledError
            return False

        original(world, agent, seed, sink, killed_before_the_third_trial, *arguments[1:])

    monkeypatch.setattr(agent_chain, "SAVE_EVERY_S", -1.0)
    with monkeypatch.context() as patch:
        patch.setattr(agent_chain, where, dies)
        with pytest.raises(KilledError):
            run_agent(job)
    assert finished_card(job, floor, "2d") is None
    assert read_card(folder)["metrics"]["trials"] == (2 if where == "learn_in_stage" else agent_chain.QUICK_TRIALS)
    run_agent(job)
    again = read_card(folder)
    for key in ("trials", "steps"):
        assert again["metrics"][key] == whole["metrics"][key]
    assert again["metrics"]["history"]["trial_steps"] == whole["metrics"]["history"]["trial_steps"]
    assert (folder / "arrays.safetensors").read_bytes() == (kept / "arrays.safetensors").read_bytes()


def test_an_agent_that_was_trained_otherwise_is_refused(floor: Floor) -> None:
    run_agent(AgentJob(REQUEST, FROM_NOTHING, 0))
    long = AgentJob(replace(REQUEST, quick=False), FROM_NOTHING, 0)
    folder = long.folder(floor, "2d")
    folder.parent.mkdir(parents=True)
    AgentJob(REQUEST, FROM_NOTHING, 0).folder(floor, "2d").rename(folder)
    with pytest.raises(TwonavError, match="trained with other settings"):
        finished_card(long, floor, "2d")


def test_a_card_from_before_a_setting_came_is_that_of_the_usual_one(floor: Floor) -> None:
    job = AgentJob(REQUEST, FROM_NOTHING, 0)
    run_agent(job)
    path = job.folder(floor, "2d") / "card.json"
    card = read_card(path.parent)
    del card["settings"]["replay_learning_rate"]
    path.write_text(json.dumps(signed(card)))
    assert finished_card(job, floor, "2d") is not None


def test_an_agent_that_learned_with_another_localizer_is_refused(floor: Floor, monkeypatch: pytest.MonkeyPatch) -> None:
    job = AgentJob(REQUEST, FROM_NOTHING, 0)
    monkeypatch.setattr(agent_chain, "_localizer", lambda *_: "one")
    run_agent(job)
    assert finished_card(job, floor, "2d") is not None
    monkeypatch.setattr(agent_chain, "_localizer", lambda *_: "another")
    with pytest.raises(TwonavError, match="another localizer"):
        finished_card(job, floor, "2d")


def test_the_report_has_our_goals_and_the_papers_columns(floor: Floor) -> None:
    for agent in range(2):
        run_agent(AgentJob(REQUEST, TRANSFERRED, agent))
    found = finished_agents(REQUEST, (TRANSFERRED,), floor)
    found[TRANSFERRED]["3d"] = [
        replace(agent, pairs=tuple(replace(pair, actions=2 * pair.actions) for pair in agent.pairs))
        for agent in found[TRANSFERRED]["2d"]
    ]
    report = transfer_report(REQUEST, found, {})
    assert report.ours["3d"]["actions_mean"] == 2 * report.ours["2d"]["actions_mean"]
    assert report.goals[0]["3d"]["actions_mean"] == 2 * report.goals[0]["2d"]["actions_mean"]
    assert [row["goal"] for row in report.goals] == list(floor.maze.goals)
    assert report.ours["2d"]["pairs"] == 50
    assert report.ours["2d"]["actions_mean"] == pytest.approx(9.88, abs=0.3)
    assert report.paper["3d"]["mean"] == 39.1
    assert report.goals[0]["2d"]["actions_std"] is not None


def test_table_10_counts_who_did_not_learn_and_stands_beside_transfer(floor: Floor) -> None:
    request = replace(REQUEST, table="table10")
    for chain in (FROM_NOTHING, TRANSFERRED):
        run_agent(AgentJob(request, chain, 0))
    found = finished_agents(request, (FROM_NOTHING, TRANSFERRED), floor)
    for chain in found.values():
        chain["3d"] = chain["2d"]
    report = transfer_report(request, found, {})
    assert [row["not_learned"] for row in report.goals] == [1] * len(floor.maze.goals)
    assert report.goals[0]["trials"]["mean"] is None
    assert report.ours[TRANSFERRED]["driven"]["success_rate"] == 1.0
    assert report.ours[FROM_NOTHING]["agents"] == 1


def test_the_printed_columns_average_as_printed_but_for_one() -> None:
    for table in (TABLE_9, TABLE_10):
        for name, column in table.items():
            assert np.mean(column.stds) == pytest.approx(column.average_std, abs=0.06)
            if name != "actions":
                assert np.mean(column.means) == pytest.approx(column.average_mean, abs=0.06)
    (erratum,) = errata_of("table10")
    assert "80.1" in erratum.text
    assert "112.7" in erratum.text


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"agents": 0}, "--repeats must be at least 1"),
        ({"processes": 0}, "--processes must be at least 1"),
        ({"seed": -1}, "--seed must be at least 0"),
        ({"localizer": "nose"}, "unknown localizer 'nose'"),
        ({"base": "legs"}, "unknown base 'legs'"),
    ],
)
def test_what_cannot_be_is_one_line(wrong: dict[str, object], complaint: str) -> None:
    REQUEST.check()
    with pytest.raises(TwonavError, match=complaint):
        replace(REQUEST, **wrong).check()  # type: ignore[arg-type]
