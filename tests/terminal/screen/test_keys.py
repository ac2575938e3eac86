"""What keys do."""

from __future__ import annotations

import pytest

from twonav_cli.terminal.commands import GoTo, Kidnap, Move, Pause, SingleStep, Speed
from twonav_cli.terminal.screen.keys import HELP, PROMPT, Controls, press

GOALS = [f"goal{n}" for n in range(12)]


@pytest.mark.parametrize(
    ("key", "command"),
    [
        ("k", Kidnap()),
        ("space", Pause(True)),
        (".", SingleStep()),
        ("+", Speed(2.0)),
        ("-", Speed(0.5)),
        ("1", GoTo("goal0")),
        ("0", GoTo("goal9")),
        ("up", Move(0)),
        ("j", Move(1)),
        ("a", Move(2)),
        ("l", Move(3)),
    ],
)
def test_a_key_asks_for_its_command(key: str, command: object) -> None:
    assert press(key, Controls(), GOALS).commands == (command,)


def test_k_is_up_once_the_player_drives_and_capital_k_kidnaps_always() -> None:
    driving = press("h", Controls(), GOALS).controls
    assert press("k", driving, GOALS).commands == (Move(0),)
    assert press("K", driving, GOALS).commands == (Kidnap(),)
    assert press("k", press("escape", driving, GOALS).controls, GOALS).commands == (Kidnap(),)


def test_a_digit_without_a_goal_does_nothing() -> None:
    assert press("7", Controls(), GOALS[:3]).commands == ()


def test_space_goes_on_when_paused_and_a_single_step_pauses() -> None:
    paused = press(".", Controls(), GOALS).controls
    assert paused.paused
    assert press("space", paused, GOALS).commands == (Pause(False),)


def test_keys_open_the_prompt_and_the_help() -> None:
    assert [press(key, Controls(), GOALS).opens for key in ("g", ":", "?", "x")] == [PROMPT, PROMPT, HELP, ""]


def test_b_hides_the_belief_and_shows_it_again() -> None:
    hidden = press("b", Controls(), GOALS)
    assert (hidden.controls.heat, hidden.commands) == (False, ())
    assert press("b", hidden.controls, GOALS).controls.heat
