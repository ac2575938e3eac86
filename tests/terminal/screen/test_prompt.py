"""Typed lines and scripted keys."""

from __future__ import annotations

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.terminal.commands import GoTo, Kidnap, Move, Pause, Quit, Speed
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
