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
        ("goal add plant 3.2 m", "numbers of metres.*not 'm'"),
        ("goal add plant nan 1", "numbers of metres.*not 'nan'"),
        ("goal add Kitchen 3.2 1.5", "already: .* 'Kitchen'$"),
        ("goal add living_room", "already"),
        ("goal add Speed", "cannot be called as a command is.*'Speed'$"),
        ("goal add go 1 1", "cannot be called as a command is"),
        ("goal add goal", "cannot be called as a command is"),
        (f"goal add {'x' * 41}", "^a goal's name has up to 40 letters and digits, - or _ between: not 'xxx"),
        ("goal add plant! 1 1", "^a goal's name has up to 40 letters and digits, - or _ between: not 'plant!'"),
        ("goal add -plant 1 1", "^a goal's name has up to 40"),
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


@pytest.mark.parametrize("typed", ["x" * 200, f"go {'x' * 200}", f"goal add {'x' * 200}", f"goal add a 1 {'x' * 200}"])
def test_what_to_do_stands_before_the_typed_word_where_a_narrow_screen_does_not_cut_it(typed: str) -> None:
    with pytest.raises(TwonavError) as refused:
        read_prompt(typed, GOALS)
    said = str(refused.value)
    assert 20 < said.index("xxx") < 80
    assert said.endswith("x'")
