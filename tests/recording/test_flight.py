from __future__ import annotations

import pytest

from twonav_cli.recording.flight import Detail, FlightRule, has_failed


@pytest.mark.parametrize(
    ("seen", "failed", "file_bytes", "level"),
    [(0, False, 0, Detail.FULL), (5, False, 0, Detail.POSES), (5, True, 0, Detail.FULL), (20, False, 0, Detail.FULL),
     (5, True, 100, Detail.TRIAL)],
)  # fmt: skip
def test_failed_first_and_every_twentieth_trials_are_kept_until_the_file_is_full(
    seen: int, failed: bool, file_bytes: int, level: Detail
) -> None:
    assert FlightRule(every_trial=False, budget_bytes=100).level(seen, failed, file_bytes) == level


def test_every_trial_is_kept_when_a_person_plays() -> None:
    assert FlightRule(every_trial=True).level(7, False, 0) == Detail.FULL


def test_a_trial_given_up_for_another_goal_has_not_failed() -> None:
    assert [has_failed(outcome) for outcome in ("reached", "given-up", "time-out", "false-arrival")] == [0, 0, 1, 1]
