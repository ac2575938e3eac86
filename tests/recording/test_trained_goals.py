from __future__ import annotations

import math

from twonav_cli.recording.trained_goals import apart, plain, trained_goals


def choice(goal: str, trials: int, steps: int, rival: str = "", rival_td_error: float = math.nan) -> dict[str, object]:
    return {
        "goal": goal, "reason": "its TD error is the largest", "after_trials": trials, "after_steps": steps,
        "td_error": 9.0, "rival": rival, "rival_td_error": rival_td_error,
    }  # fmt: skip


def test_a_turn_ends_where_the_next_begins_and_the_last_one_with_the_recording() -> None:
    choices = [choice("bed", 20, 300), choice("sofa", 0, 0, "bed", 5.0)]
    learned = [{"goal": "sofa", "after_trials": 20, "after_steps": 300}]
    sofa, bed = trained_goals(choices, learned, (25, 340), first_number=1)
    assert (sofa.goal, sofa.first_trial, sofa.last_trial, sofa.trials, sofa.actions) == ("sofa", 1, 20, 20, 300)
    assert (sofa.rival, sofa.rival_td_error, sofa.learned_at_trial, sofa.learned_at_step) == ("bed", 5.0, 20, 300)
    assert (bed.first_trial, bed.last_trial, bed.trials, bed.actions) == (21, 25, 5, 40)
    assert (bed.rival_td_error, bed.learned_at_trial) == (None, None)


def test_trials_that_are_counted_from_zero_keep_their_numbers() -> None:
    (turn,) = trained_goals([choice("bed", 0, 0)], [], (3, 30), first_number=0)
    assert (turn.first_trial, turn.last_trial, turn.trials) == (0, 2, 3)


def test_a_recording_without_choices_has_no_story() -> None:
    assert trained_goals([], [], (25, 340), first_number=1) == ()


def test_large_td_errors_are_written_in_full() -> None:
    assert [plain(value) for value in (10_000.0, 118.04, 0.77387, 0.0)] == ["10,000", "118", "0.7739", "0"]


def test_two_td_errors_are_written_so_that_they_differ_where_they_do() -> None:
    assert apart(129.41, 129.38) == ("129.41", "129.38")
    assert apart(10_000.25, 10_000.0) == ("10,000.2", "10,000")
    assert apart(5.0, 5.0) == ("5", "5")
