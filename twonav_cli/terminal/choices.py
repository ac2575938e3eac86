"""The names that several commands share: one check for all of them, before anything is loaded."""

from __future__ import annotations

from collections.abc import Sequence

from twonav_cli.config import BASES, LOCALIZERS
from twonav_cli.errors import unknown_name


def check_choices(stage: str, stages: Sequence[str], localizer: str = "raw", base: str = "omni") -> None:
    """Refuse a stage, localizer or base that there is not.

    Args:
        stage: What was asked for.
        stages: What the command knows.
        localizer: What was asked for.
        base: What was asked for.

    Raises:
        TwonavError: Names the right ones.
    """
    for kind, name, right in (("stage", stage, stages), ("localizer", localizer, LOCALIZERS), ("base", base, BASES)):
        if name not in right:
            raise unknown_name(kind, name, right)
