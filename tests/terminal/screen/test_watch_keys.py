"""What the keys do while one watches, and how many actions are due."""

from __future__ import annotations

import pytest

from twonav_cli.terminal.screen.watch_keys import (
    HEATS,
    HELP,
    LEAVE,
    SPEEDS,
    WatchControls,
    due,
    press,
    speed_text,
)

GOALS = ["sofa", "bed", "desk"]


def pressed(keys: list[str], controls: WatchControls | None = None) -> WatchControls:
    controls = controls or WatchControls()
    for key in keys:
        controls, _ = press(key, controls, GOALS)
    return controls


def test_space_pauses_and_goes_on() -> None:
    assert pressed(["space"]).paused
    assert not pressed(["space", "space"]).paused


def test_a_dot_pauses_and_asks_for_one_action_each_time() -> None:
    controls = pressed([".", "."])
    assert controls.paused
    controls, actions = due(controls, 0.1)
    assert actions == 2
    assert due(controls, 0.1)[1] == 0


def test_speeds_go_from_one_action_a_second_to_as_fast_as_it_goes_and_stop_there() -> None:
    assert pressed(["-"] * 10).speed == SPEEDS[0] == 1
    fastest = pressed(["+"] * 10)
    assert fastest.speed == SPEEDS[-1]
    assert due(fastest, 0.1)[1] is None
    assert speed_text(fastest) == "as fast as it goes"
    assert [speed_text(WatchControls(speed=s)) for s in (1, 1000)] == ["1 action/s", "1,000 actions/s"]


@pytest.mark.parametrize(("speed", "frames"), [(1, 45), (10, 30), (1000, 15)])
def test_as_many_actions_are_due_as_the_speed_says(speed: int, frames: int) -> None:
    controls, taken = WatchControls(speed=speed), 0
    for _ in range(frames):
        controls, actions = due(controls, 1 / 15)
        assert actions is not None
        taken += actions
    assert taken == pytest.approx(speed * frames / 15, abs=1)


def test_a_screen_that_was_held_up_does_not_jump() -> None:
    assert due(WatchControls(speed=100), 60.0)[1] == 25


@pytest.mark.parametrize(("key", "skip"), [("t", "trial"), ("g", "goal"), ("e", "end"), ("enter", "end")])
def test_a_skip_runs_as_fast_as_it_goes_and_then_what_held_before_holds_again(key: str, skip: str) -> None:
    for before in (WatchControls(), WatchControls(paused=True, speed=100)):
        controls = pressed([key], before)
        assert controls.skip == skip
        assert due(controls, 0.1)[1] is None
        assert controls.arrived() == before


def test_space_ends_a_skip_in_a_pause_and_escape_ends_it_without() -> None:
    assert pressed(["e", "space"]) == WatchControls(paused=True)
    assert pressed(["e", "escape"]) == WatchControls()


def test_tab_goes_round_what_the_colours_show_both_ways() -> None:
    assert [pressed(["tab"] * n).heat for n in range(4)] == [*HEATS, HEATS[0]]
    assert pressed(["shift+tab"]).heat == HEATS[-1]


def test_a_digit_looks_at_a_goal_and_the_same_again_or_escape_looks_back() -> None:
    assert pressed(["2"]).looked_at == "bed"
    assert pressed(["2", "3"]).looked_at == "desk"
    assert pressed(["2", "2"]).looked_at == pressed(["2", "escape"]).looked_at == ""
    assert pressed(["9"]).looked_at == ""


def test_help_and_leaving_change_no_control() -> None:
    for key, opens in (("?", HELP), ("q", LEAVE), ("x", "")):
        assert press(key, WatchControls(), GOALS) == (WatchControls(), opens)
