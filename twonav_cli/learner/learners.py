"""The learners by name: the paper's two, the explorers that beat them, and the one that knows the maze already."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from twonav_cli.config import LearningConfig, learning_preset
from twonav_cli.errors import unknown_name


@dataclass(frozen=True)
class Learner:
    """A strategy for the maze."""

    name: str
    sentence: str
    changes: dict[str, Any] = field(default_factory=dict)
    """Settings it brings along, over those of the preset."""


LEARNERS: dict[str, Learner] = {
    learner.name: learner
    for learner in (
        Learner("single", "Q-learning with one goal at a time, nothing shared (Eq. 1, §4.3)."),
        Learner("multi", "Q-learning that updates every goal from every action (Eq. 2, §4.3)."),
        Learner(
            "optimistic",
            "Multi-goal Q-learning from values above the goal's reward, nearly greedy, replayed often (ours).",
            {"discount": 0.95, "initial_q": 110.0, "temperature": 0.05, "replay_period_steps": 10},
        ),
        Learner(
            "prioritized-sweeping",
            "Dyna: after each action the most surprising remembered values are backed up (Moore and Atkeson 1993).",
            {"discount": 0.95, "initial_q": 110.0, "temperature": 0.05, "replay_period_steps": 1_000_000_000},
        ),
        Learner(
            "nearest-untried",
            "Walks to the nearest action never tried, and plans on what it saw (in the spirit of R-max, 2002).",
            {"discount": 0.95, "temperature": 0.001, "temperature_decay": 1.0, "replay_period_steps": 1_000_000_000},
        ),
        Learner(
            "oracle",
            "Knows the maze from the start: what the criterion costs by itself (ours).",
            {"discount": 0.95, "temperature": 0.001, "temperature_decay": 1.0, "replay_period_steps": 1_000_000_000},
        ),
    )
}


def learner_settings(name: str, preset: str = "paper-maze", **changes: Any) -> LearningConfig:
    """Return the settings of a learner: the preset's, with the learner's own over them, with `changes` over both.

    Raises:
        TwonavError: No learner or preset of that name.
    """
    if name not in LEARNERS:
        raise unknown_name("learner", name, LEARNERS)
    return learning_preset(preset, **{**LEARNERS[name].changes, **changes, "learner": name})
