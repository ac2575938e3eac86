"""The agents of a table that are there: what they learned, trial by trial, and how they drove afterwards."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from twonav_cli.experiments.evaluation import PairResult
from twonav_cli.experiments.learning_run import LearningRun
from twonav_cli.experiments.transfer.agent_chain import AgentJob, finished_card
from twonav_cli.experiments.transfer.request import CHAINS, TransferRequest
from twonav_cli.experiments.transfer.stage_history import StageHistory
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import Floor


@dataclass(frozen=True)
class FinishedStage:
    """An agent of a stage.

    Attributes:
        run: How it learned.
        wall_s: How long that took.
        learned: Name of each goal that met the criterion.
        pairs: Every goal from every start, driven afterwards.
        goals: Names of all goals, in the maze's order.
    """

    run: LearningRun
    wall_s: float
    learned: tuple[str, ...]
    pairs: tuple[PairResult, ...]
    goals: tuple[str, ...]

    def actions_to(self, goal: str) -> float:
        """Return the mean actions to a goal over the starts from which it was reached; not a number where none was."""
        taken = [pair.actions for pair in self.pairs if pair.goal == goal and pair.success]
        return float(np.mean(taken)) if taken else float("nan")


Finished = dict[str, dict[str, list[FinishedStage]]]
"""Chain to stage to its agents, in their order."""


def finished_agents(request: TransferRequest, chains: tuple[str, ...], floor: Floor) -> Finished:
    """Return the agents of some chains that are finished in a stage.

    Raises:
        TwonavError: One is damaged, or of another scene or map.
    """
    return {
        chain: {
            stage: [
                found
                for agent in range(request.agents)
                if (found := _stage_of(AgentJob(request, chain, agent), stage, floor)) is not None
            ]
            for stage in CHAINS[chain]
        }
        for chain in chains
    }


def _stage_of(job: AgentJob, stage: str, floor: Floor) -> FinishedStage | None:
    card = finished_card(job, floor, stage)
    if card is None:
        return None
    agent = Agent.load(job.folder(floor, stage), floor.scene.digest, floor.map.digest)
    history = StageHistory.of_card(card, agent.goal_names)
    names = tuple(agent.goal_names)
    learned = tuple(name for name, done in zip(names, agent.progress.learned, strict=True) if done)
    pairs = tuple(PairResult(**pair) for pair in card["metrics"]["pairs"])
    return FinishedStage(history.learning_run(agent, floor.maze), history.wall_s, learned, pairs, names)
