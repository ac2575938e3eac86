"""What `twonav train --stage maze` may change of how the agent learns; what is not said is the preset's."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

from twonav_cli.config import LearningConfig
from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.learner.learners import learner_settings

PRESETS = ("maze", "paper-maze")


@dataclass(frozen=True)
class LearningChoices:
    """What the command line says about learning in the maze; None is what the preset says."""

    learner: str | None = None
    preset: str | None = None
    discount: float | None = None
    temperature: float | None = None
    initial_q: float | None = None
    goal_selection: str | None = None
    exploration: str | None = None
    cooling: str | None = None

    def given(self) -> dict[str, Any]:
        """Return what was said, by name."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def config(self) -> LearningConfig:
        """Return the settings of the learner: its own over the preset's, and what was said over both.

        Raises:
            TwonavError: No learner or preset of that name.
        """
        changes = self.given()
        learner, preset = changes.pop("learner", "multi"), changes.pop("preset", "maze")
        if preset not in PRESETS:
            raise unknown_name("preset", preset, PRESETS)
        return learner_settings(learner, preset, **changes)

    def check(self) -> None:
        """Make sure that the settings can be learned with.

        Raises:
            TwonavError: A name that there is not, or a number out of its range.
        """
        from twonav_cli.learner.agent import checked

        checked(self.config())

    def arguments(self) -> list[str]:
        """Return what was said as it is typed."""
        return [part for name, value in self.given().items() for part in (option_of(name), str(value))]

    def check_same(self, saved: LearningConfig, where: str) -> None:
        """Refuse to go on with a run that learns otherwise than was said; saying nothing is to take its settings.

        Args:
            saved: Settings of the run.
            where: The run's folder, for the message.

        Raises:
            TwonavError: Says what differs.
        """
        if not self.given():
            return
        wanted = self.config()
        names = [field.name for field in fields(LearningConfig)]
        differing = [
            f"{name.replace('_', ' ')} {getattr(saved, name)} where {getattr(wanted, name)} is asked for"
            for name in names
            if getattr(saved, name) != getattr(wanted, name)
        ]
        if differing:
            raise TwonavError(
                f"the run in {where} has {', '.join(differing)}: "
                "leave the settings out to go on with its own, or leave --resume out"
            )


def option_of(name: str) -> str:
    """Return a setting's option on the command line."""
    return f"--{name.replace('_', '-')}"
