from __future__ import annotations

import math

from twonav_cli.learner.goals import GOAL_SELECTIONS
from twonav_cli.recording.trained_goals import LARGEST, NOT_WRITTEN, Walked, apart, plain, trained_goals, why_chosen


def choice(goal: str, trials: int, steps: int, rival: str = "", rival_td_error: float = math.nan) -> dict[str, object]:
    return {
        "goal": goal, "reason": "its TD error is the largest", "after_trials": trials, "after_steps": steps,
        "td_error": 9.0, "rival": rival, "rival_td_error": rival_td_error,
    }  # fmt: skip


def test_a_turn_ends_where_the_next_begins_and_the_last_one_with_the_recording() -> None:
    choices = [choice("bed", 20, 300), choice("sofa", 0, 0, "bed", 5.0)]
    learned = [{"goal": "sofa", "after_trials": 20, "after_steps": 300}]
    sofa, bed = trained_goals(choices, learned, [], (25, 340), first_number=1)
    assert (sofa.goal, sofa.first_trial, sofa.last_trial, sofa.trials, sofa.actions) == ("sofa", 1, 20, 20, 300)
    assert (sofa.rival, sofa.rival_td_error, sofa.learned_at_trial, sofa.learned_at_step) == ("bed", 5.0, 20, 300)
    assert (bed.first_trial, bed.last_trial, bed.trials, bed.actions) == (21, 25, 5, 40)
    assert (bed.rival_td_error, bed.learned_at_trial) == (None, None)


def test_trials_that_are_counted_from_zero_keep_their_numbers() -> None:
    (turn,) = trained_goals([choice("bed", 0, 0)], [], [], (3, 30), first_number=0)
    assert (turn.first_trial, turn.last_trial, turn.trials) == (0, 2, 3)


def walked(goal: str, first: int, last: int) -> list[Walked]:
    """Trials of ten actions each, from the first to the last."""
    return [Walked(goal, trial, 10 * (trial - 1), 10 * trial) for trial in range(first, last + 1)]


def test_a_turn_ends_at_the_last_trial_of_its_own_goal_and_lost_choices_are_said_to_be_lost() -> None:
    trials = [*walked("sofa", 1, 20), *walked("bed", 21, 24), *walked("tv", 25, 30), *walked("bed", 31, 33)]
    turns = trained_goals([choice("sofa", 0, 0), choice("bed", 30, 300)], [], trials, (33, 330), first_number=1)
    found = [(turn.goal, turn.first_trial, turn.last_trial, turn.actions, turn.reason) for turn in turns]
    assert found == [
        ("sofa", 1, 20, 200, LARGEST),
        ("bed", 21, 24, 40, NOT_WRITTEN),
        ("tv", 25, 30, 60, NOT_WRITTEN),
        ("bed", 31, 33, 30, LARGEST),
    ]
    assert (turns[1].td_error, turns[1].rival, turns[1].rival_td_error) == (None, "", None)


def test_thinned_trials_tell_where_a_lost_choice_was() -> None:
    trials = [*walked("sofa", 1, 20)[1::4], *walked("bed", 19, 30)[3::4]]
    _, bed = trained_goals([choice("sofa", 0, 0)], [], trials, (30, 300), first_number=1)
    assert (bed.first_trial, bed.last_trial, bed.actions) == (19, 30, 120)


def test_trials_without_any_choice_are_listed_by_their_goals() -> None:
    (bed,) = trained_goals([], [], walked("bed", 71, 75), (75, 750), first_number=1)
    assert (bed.goal, bed.first_trial, bed.last_trial, bed.actions) == ("bed", 71, 75, 50)


def test_equal_td_errors_are_told_as_equal_and_the_first_counts_only_by_its_rule() -> None:
    assert why_chosen(LARGEST, 1e4, ("sofa", 1e4)) == f"{LARGEST} (10,000, as that of sofa; the first of equals)"
    assert why_chosen("drawn at random", 1e4, ("sofa", 1e4)) == "drawn at random (10,000, as that of sofa)"
    assert GOAL_SELECTIONS["td-error"] == LARGEST


def test_a_recording_without_choices_and_trials_has_no_story() -> None:
    assert trained_goals([], [], [], (25, 340), first_number=1) == ()


def test_large_td_errors_are_written_in_full() -> None:
    assert [plain(value) for value in (10_000.0, 118.04, 0.77387, 0.0)] == ["10,000", "118", "0.7739", "0"]


def test_two_td_errors_are_written_so_that_they_differ_where_they_do() -> None:
    assert apart(129.41, 129.38) == ("129.41", "129.38")
    assert apart(10_000.25, 10_000.0) == ("10,000.2", "10,000")
    assert apart(5.0, 5.0) == ("5", "5")
