"""The game without a terminal."""

from __future__ import annotations

import io

from fake_game import FakeGame

from twonav_cli.events import RunEnded
from twonav_cli.terminal.commands import AddGoal
from twonav_cli.terminal.plain import PlainPrinter


def printed() -> list[str]:
    game, stream = FakeGame(), io.StringIO()
    printer = PlainPrinter(stream)
    for event in [*game.began(), *game.walk("kitchen"), RunEnded(game.clock, "1 of 1 goals reached")]:
        printer(event)
    return stream.getvalue().splitlines()


def test_there_is_one_line_per_action_one_per_trial_and_a_summary() -> None:
    lines = printed()
    assert lines[1] == "trial 1: to kitchen from (12,23), shortest 26 actions"
    assert sum(line.startswith("  1.") for line in lines) == 26
    assert lines[-2] == "trial 1: kitchen in 26 actions, shortest 26"
    assert lines[-1].startswith("summary: 1 of 1 goals reached; 1 of 1 reached, SPL 1.00; 26 actions, 20.8 s simulated")


def test_an_action_line_holds_cell_action_outcome_truth_error_and_values() -> None:
    line = printed()[2]
    for part in ("1.1 ", "(12,23) up", "reached", "true (11,23)", "6.7 cm", "3.4 deg", "Q   27.74", "TD"):
        assert part in line


def test_a_goal_that_is_added_is_one_line_and_its_trials_are_counted_like_any_other() -> None:
    game, stream = FakeGame(), io.StringIO()
    printer = PlainPrinter(stream)
    for event in [*game.began(), *game.answer(AddGoal("plant", 0.2, 7.4)), *game.walk("plant")]:
        printer(event)
    lines = stream.getvalue().splitlines()
    assert lines[1].startswith("info: plant: learned in")
    assert lines[2].startswith("trial 1: to plant from (12,23), shortest ")
    assert lines[-1].startswith("trial 1: plant in ")
