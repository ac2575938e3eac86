"""Typed lines and scripted keys."""

from __future__ import annotations

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.terminal.commands import AddGoal, GoTo, Kidnap, Move, Pause, Quit, Speed
from twonav_cli.terminal.screen.prompt import Answer, Press, Wait, read_keys, read_prompt

GOALS = ["kitchen", "Living-Room", "kids-room"]


@pytest.mark.parametrize(
    ("typed", "asked"),
    [
        ("kitchen", GoTo("kitchen")),
        ("  KITCHEN ", GoTo("kitchen")),
        ("kit", GoTo("kitchen")),
        ("go to living room", GoTo("Living-Room")),
        ("kidnap", Kidnap()),
        ("pause", Pause(True)),
        ("resume", Pause(False)),
        ("speed 2", Speed(2.0)),
        ("speed x0.5", Speed(0.5)),
        ("left", Move(2)),
        ("quit", Quit()),
        ("help", Answer("help")),
        ("goals", Answer("goals")),
        ("", Answer("")),
        ("goal add Plant 3.2 -1.5", AddGoal("Plant", 3.2, -1.5)),
        ("GOAL Add plant 3.2,1.5", AddGoal("plant", 3.2, 1.5)),
        ("goal add plant", AddGoal("plant")),
        ("goal kitchen", GoTo("kitchen")),
    ],
)
def test_the_prompt_understands(typed: str, asked: object) -> None:
    assert read_prompt(typed, GOALS) == asked


def test_a_wrong_name_is_answered_with_the_nearest_one() -> None:
    with pytest.raises(TwonavError, match="did you mean 'kitchen'"):
        read_prompt("kithcen", GOALS)


def test_a_beginning_of_two_goals_is_neither() -> None:
    with pytest.raises(TwonavError, match="kids-room"):
        read_prompt("go ki", GOALS)


@pytest.mark.parametrize(
    ("typed", "why"),
    [
        ("goal add", "type `goal add plant 3.2 1.5`"),
        ("goal add plant 3.2", "type `goal add plant 3.2 1.5`"),
        ("goal add plant 3.2 1.5 0", "type `goal add plant 3.2 1.5`"),
        ("goal add plant 3.2 m", "'m' is not a number of metres"),
        ("goal add plant nan 1", "'nan' is not a number of metres"),
        ("goal add Kitchen 3.2 1.5", "already"),
        ("goal add living_room", "already"),
        ("goal add Speed", "'Speed' is a command"),
        ("goal add go 1 1", "'go' is a command"),
        ("goal add goal", "'goal' is a command"),
    ],
)
def test_a_new_goal_that_cannot_be_is_answered_in_one_line(typed: str, why: str) -> None:
    with pytest.raises(TwonavError, match=why):
        read_prompt(typed, GOALS)


def test_a_goal_that_is_being_added_can_be_asked_for_at_once_and_added_again() -> None:
    assert read_prompt("plant", GOALS, ["plant"]) == GoTo("plant")
    assert read_prompt("goal add plant 1 2", GOALS, ["plant"]) == AddGoal("plant", 1.0, 2.0)


@pytest.mark.parametrize("typed", ["speed", "speed fast", "speed 0", "speed nan", "speed 2 3"])
def test_a_speed_without_a_usable_factor_says_what_to_type(typed: str) -> None:
    with pytest.raises(TwonavError, match="type `speed 2`"):
        read_prompt(typed, GOALS)


def test_scripted_keys_are_characters_and_names() -> None:
    assert read_keys("g kit<enter> <wait> k <wait:0.5> <space>") == [
        *(Press(key) for key in ("g", "k", "i", "t", "enter")),
        Wait(None),
        Press("k"),
        Wait(0.5),
        Press("space"),
    ]


@pytest.mark.parametrize("script", ["<nowhere>", "g <enter", "<wait:x>"])
def test_an_unknown_key_is_refused(script: str) -> None:
    with pytest.raises(TwonavError, match="unknown key"):
        read_keys(script)
