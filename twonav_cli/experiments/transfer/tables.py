"""Tables 9 and 10: the figures of the agents beside the paper's.

G goals, n agents.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from twonav_cli.experiments.evaluation import figures
from twonav_cli.experiments.paper_errata import errata_of
from twonav_cli.experiments.paper_figures import TABLE_9, TABLE_10, TABLE_10_NOT_REACHED
from twonav_cli.experiments.statistics import rounded, summary_of
from twonav_cli.experiments.transfer.finished import Finished, FinishedStage
from twonav_cli.experiments.transfer.request import FROM_NOTHING, TRANSFERRED, TransferRequest

Figures = dict[str, Any]

TITLES = {
    "table9": "Table 9: actions to the goals after learning, in 2D and in 3D",
    "table10": "Table 10: learning in 3D without what was learned before",
}


@dataclass(frozen=True)
class TransferReport:
    """Table 9 or 10, the paper's figures and ours.

    Attributes:
        table: A name of TABLES.
        title: One line.
        goals: Table 9: a row for each of our goals. Table 10: a row for each place in the order of training.
        paper: The printed columns.
        ours: What the rows add up to.
        errata: The paper's slips: "row" and "text".
        settings: Everything that decides the figures, the command and the versions.
    """

    table: str
    title: str
    goals: list[Figures]
    paper: Figures
    ours: Figures
    errata: list[dict[str, str]]
    settings: Figures


def transfer_report(request: TransferRequest, found: Finished, settings: Figures) -> TransferReport:
    """Return the report of a request.

    Args:
        request: What was asked.
        found: The agents that are there.
        settings: Of the report.
    """
    goals, paper, ours = (_table9 if request.table == "table9" else _table10)(request, found)
    errata = [asdict(erratum) for erratum in errata_of(request.table)]
    return TransferReport(request.table, TITLES[request.table], goals, paper, ours, errata, settings)


def _table9(request: TransferRequest, found: Finished) -> tuple[list[Figures], Figures, Figures]:
    """Return a row for every goal, the paper's columns, and the figures of all goals, of 2D and 3D."""
    stages = {name: found[TRANSFERRED][name] for name in ("2d", "3d")}
    names = next((agents[0].goals for agents in stages.values() if agents), ())
    rows = [
        {"goal": goal, **{name: _driven(agents, goal) for name, agents in stages.items() if agents}} for goal in names
    ]
    ours = {name: {**_driven(agents, None), **_effort(agents, request.seed)} for name, agents in stages.items()}
    return rows, {name: asdict_of(column) for name, column in TABLE_9.items()}, ours


def asdict_of(column: Any) -> Figures:
    """Return a printed column pair as JSON can hold it."""
    return {
        "goals": [{"mean": mean, "std": std} for mean, std in zip(column.means, column.stds, strict=True)],
        "mean": column.average_mean,
        "std": column.average_std,
    }


def _driven(agents: list[FinishedStage], goal: str | None) -> Figures:
    """Return how agents drove to a goal, or to all, from every start; the deviation is that from agent to agent."""
    pairs = [
        replace(pair, repeat=number)
        for number, agent in enumerate(agents)
        for pair in agent.pairs
        if goal in (None, pair.goal)
    ]
    return figures(pairs)


def _effort(agents: list[FinishedStage], seed: int) -> Figures:
    """Return what learning all goals took: trials, actions and minutes, over the agents."""
    columns = {
        "trials": [agent.run.trials if agent.run.learned else np.inf for agent in agents],
        "steps": [agent.run.steps if agent.run.learned else np.inf for agent in agents],
        "minutes": [agent.wall_s / 60 for agent in agents],
        "actions_per_pair": [_mean_actions(agent) for agent in agents],
    }
    figures_of = {name: summary_of([values], seed).report() for name, values in columns.items() if values}
    return {"agents": len(agents), "learned_all": sum(agent.run.learned for agent in agents), **figures_of}


def _mean_actions(agent: FinishedStage) -> float:
    taken = [pair.actions for pair in agent.pairs if pair.success]
    return float(np.mean(taken)) if taken else float("inf")


def _table10(request: TransferRequest, found: Finished) -> tuple[list[Figures], Figures, Figures]:
    """Return a row for every place in the order of training, the paper's columns, and what either way took."""
    agents = found[FROM_NOTHING]["3d"]
    places = max((len(agent.goals) for agent in agents), default=0)
    paper = {
        **{name: asdict_of(column) for name, column in TABLE_10.items()},
        "not_reached": list(TABLE_10_NOT_REACHED),
    }
    ways = {FROM_NOTHING: agents, TRANSFERRED: found[TRANSFERRED]["3d"]}
    ours: Figures = {name: _effort(way, request.seed) | {"driven": _driven(way, None)} for name, way in ways.items()}
    before = [np.mean([agent.wall_s for agent in found[TRANSFERRED][stage]] or [0.0]) for stage in ("maze", "2d")]
    ours[TRANSFERRED]["minutes_before"] = rounded(sum(before) / 60)
    return [_place(agents, place) for place in range(places)], paper, ours


def _place(agents: list[FinishedStage], place: int) -> Figures:
    """Return the trials of the goal trained in this place, the actions to it afterwards, and who did not learn it."""
    trials, actions, not_learned = [], [], 0
    for agent in agents:
        order = agent.run.goal_order
        goal = agent.goals[order[place]] if place < len(order) else None
        if goal is None or goal not in agent.learned:
            not_learned += 1
            continue
        trials.append(float(agent.run.trials_of_goal[place]))
        actions.append(agent.actions_to(goal))
    return {
        "place": place + 1,
        "trials": _mean_and_std(trials),
        "actions": _mean_and_std(actions),
        "not_learned": not_learned,
    }


def _mean_and_std(values: list[float]) -> Figures:
    known = [value for value in values if np.isfinite(value)]
    return {
        "mean": rounded(np.mean(known)) if known else None,
        "std": rounded(np.std(known, ddof=1)) if len(known) > 1 else None,
    }
