"""The watching screen, driven by its own keys and through a pseudo-terminal."""

from __future__ import annotations

import asyncio
import json
import os
import pty
import select
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import numpy as np
import pytest
from small_run import CONFIG, GOALS, small_maze, small_run, small_walk
from textual.pilot import Pilot
from textual.widgets import Static

from twonav_cli.errors import TwonavError
from twonav_cli.events import to_nobody
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.learner.agent import Agent
from twonav_cli.terminal.screen.watch_keys import WatchControls
from twonav_cli.terminal.screen.watch_screen import WatchScreen
from twonav_cli.terminal.screen.watch_walk import Walk

Body = Callable[[WatchScreen, "Pilot[None]"], Awaitable[None]]
PAUSED = WatchControls(paused=True)


def on_screen(body: Body, size: tuple[int, int] = (80, 24), controls: WatchControls = PAUSED) -> Walk:
    """Run a body against a screen that shows a learning run in the small maze."""
    walk = small_walk()
    app = WatchScreen(walk, small_run(), controls)

    async def run() -> None:
        async with app.run_test(size=size) as pilot:
            await until(lambda: app.state.goal != "", pilot)
            await body(app, pilot)

    asyncio.run(run())
    assert app.error is None
    return walk


async def until(condition: Callable[[], bool], pilot: Pilot[None]) -> None:
    """Wait up to thirty seconds: the loop may have to be compiled first."""
    deadline = time.monotonic() + 30
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        await pilot.pause(0.02)


def shown(app: WatchScreen, name: str) -> str:
    return str(app.query_one(f"#{name}", Static).render())


@pytest.mark.parametrize("size", [(80, 24), (120, 40)])
def test_goals_reason_and_numbers_are_on_the_screen(size: tuple[int, int]) -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press(".")
        await until(lambda: app.state.clock.step == 1, pilot)
        await pilot.pause(0.2)
        assert all(name in shown(app, "errors") for name in GOALS)
        numbers = " ".join(shown(app, "numbers").split())  # however they are wrapped
        for part in ("sofa: its TD error is the largest (10,000)", "1 from s1: 1 action", "0 of 3 goals", "floor 165"):
            assert part in numbers
        assert "0 of 3 goals learned" in shown(app, "status")
        panel = app.query_one("#maze")
        drawn = "".join(panel.render_line(row).text for row in range(panel.size.height))
        assert {"1", "2", "3", "S", "●"} <= set(drawn)
        assert panel.border_title == "values for sofa"

    on_screen(body, size)


@pytest.mark.parametrize("size", [(200, 50), (40, 12), (20, 5), (10, 3)])
def test_any_size_is_drawn(size: tuple[int, int]) -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press("t")
        await until(lambda: app.state.clock.trial == 1, pilot)
        await pilot.pause(0.2)
        assert "0 of 3" in shown(app, "status")

    on_screen(body, size)


def test_a_paused_run_moves_by_single_actions_only() -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.pause(0.3)
        assert app.state.clock.step == 0
        await pilot.press(".", ".", ".")
        await until(lambda: app.state.clock.step == 3, pilot)
        await pilot.pause(0.3)
        assert app.state.clock.step == 3
        assert "PAUSED" in shown(app, "status")

    assert on_screen(body).agent.progress.step == 3


def test_space_lets_it_run_at_the_speed_that_plus_and_minus_set() -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press("-", "space")
        assert not app.controls.paused
        await pilot.pause(0.5)
        slowly = app.state.clock.step
        await pilot.press("+", "+")
        await until(lambda: app.state.clock.step > 20, pilot)
        assert slowly <= 3
        assert "100 actions/s" in shown(app, "status")

    on_screen(body)


def test_skips_go_to_the_end_of_the_trial_then_of_the_goal_and_pause_there_again() -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press("t")
        await until(lambda: app.state.clock.trial == 1, pilot)
        assert app.state.between
        await pilot.press("g")
        await until(lambda: len(app.state.learned) == 1, pilot)
        await pilot.pause(0.3)
        assert len(app.state.learned) == 1
        assert app.controls == PAUSED
        assert "✓" in shown(app, "errors")

    on_screen(body)


@pytest.mark.parametrize("key", ["e", "enter"])
def test_the_end_is_what_an_unwatched_run_comes_to_and_stays_on_the_screen(key: str) -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press(key)
        await until(lambda: app.state.ended == "learned", pilot)
        await pilot.pause(0.2)
        assert "all 3 goals learned in" in shown(app, "status")
        assert app.is_running
        await pilot.press(".", "space", "g")
        await pilot.pause(0.2)
        assert app.is_running
        await pilot.press("q")
        await until(lambda: not app.is_running, pilot)

    walk = on_screen(body)
    alone = Agent.for_maze(small_maze(), CONFIG)
    assert walk.close() == learn_maze(alone, small_maze(), 0, to_nobody, lambda: False)
    assert np.array_equal(walk.agent.q, alone.q)
    assert np.array_equal(walk.agent.td, alone.td)


@pytest.mark.parametrize("key", ["q", "ctrl+c"])
def test_leaving_early_stops_the_run_at_the_end_of_its_trial(key: str) -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press(".", ".")
        await until(lambda: app.state.clock.step == 2, pilot)
        await pilot.press(key)
        await until(lambda: not app.is_running, pilot)

    walk = on_screen(body)
    outcome = walk.close()
    assert (outcome.outcome, outcome.trials) == ("stopped", 1)


def test_tab_and_digits_change_what_the_colours_show() -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        titles = []
        for key in ("2", "tab", "tab", "tab", "2"):
            await pilot.press(key)
            await pilot.pause(0.2)
            titles.append(app.query_one("#maze").border_title)
        assert titles == ["values for bed", "TD errors for bed", "visits", "values for bed", "values for sofa"]

    on_screen(body)


def test_help_opens_and_any_key_closes_it_without_doing_more() -> None:
    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press("?")
        assert app.query_one("#help").display
        await pilot.pause(0.1)
        assert app.query_one("#help").region.height <= 24
        await pilot.press("e")
        await pilot.pause(0.2)
        assert not app.query_one("#help").display
        assert app.state.clock.step == 0

    on_screen(body)


def test_without_colour_the_maze_is_readable_characters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")

    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        await pilot.press(".", ".")
        await until(lambda: app.state.clock.step == 2, pilot)
        await pilot.pause(0.2)
        panel = app.query_one("#maze")
        drawn = "".join(panel.render_line(row).text for row in range(panel.size.height))
        assert {"#", "@", "S", "1"} <= set(drawn)
        assert not {"▀", "●"} & set(drawn)

    on_screen(body)


def test_what_the_learning_raises_closes_the_screen_and_comes_out(monkeypatch: pytest.MonkeyPatch) -> None:
    walk = small_walk()
    app = WatchScreen(walk, small_run(), PAUSED)

    async def run() -> None:
        async with app.run_test() as pilot:
            await until(lambda: app.state.goal != "", pilot)
            monkeypatch.setattr(walk, "take", broken)
            await pilot.press(".")
            await until(lambda: not app.is_running, pilot)

    def broken(actions: int) -> None:
        raise TwonavError("the maze is gone")

    asyncio.run(run())
    assert str(app.error) == "the maze is gone"


# In a terminal


@pytest.mark.parametrize("key", [b"\x03", b"q"])
def test_stopping_restores_the_terminal_saves_and_ends_with_130(key: bytes, tmp_path: Path) -> None:
    output, code = in_terminal(key, b"10 actions/s", tmp_path)
    assert b"\x1b[?1049h" in output, "the alternate screen was entered"
    assert output.rindex(b"\x1b[?1049l") > output.rindex(b"\x1b[?1049h"), "and left"
    assert output.rindex(b"\x1b[?25h") > output.rindex(b"\x1b[?25l"), "the cursor is back"
    assert b"--resume" in output[output.rindex(b"\x1b[?1049l") :]
    assert code == 130
    card = json.loads((tmp_path / "agent" / "card.json").read_text())
    assert card["metrics"]["goals_learned"] == 0
    assert card["metrics"]["trials"] >= 1


def in_terminal(key: bytes, when: bytes, folder: Path) -> tuple[bytes, int]:
    """Watch the kitchen's agent learn in a pseudo-terminal, press a key once `when` is there; output and exit code."""
    leader, follower = pty.openpty()
    env = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "80", "LINES": "24", "TWONAV_RUNS": str(folder / "runs")}
    watch = ["train", "--stage", "maze", "--watch", "--scene", "kitchen", "--no-record", "--out"]
    command = subprocess.Popen(
        [sys.executable, "-m", "twonav_cli", *watch, str(folder / "agent")],
        stdin=follower,
        stdout=follower,
        stderr=follower,
        env=env,
    )
    os.close(follower)
    output, seen_at, deadline = b"", 0.0, time.monotonic() + 60
    try:
        while time.monotonic() < deadline:
            if select.select([leader], [], [], 0.1)[0]:
                try:
                    output += os.read(leader, 65536)
                except OSError:  # the other end is closed: the command has ended
                    break
            if not seen_at and when in output and b"1 from s1" in output:
                seen_at = time.monotonic()
            elif seen_at and time.monotonic() - seen_at > 1.0:
                os.write(leader, key)
                seen_at = deadline
        return output, command.wait(timeout=10)
    finally:
        command.kill()
        os.close(leader)


def test_a_watched_run_that_is_killed_was_saved_on_the_way(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from twonav_cli.checkpoint import read_card
    from twonav_cli.terminal import train_agent
    from twonav_cli.terminal.interrupt import StopOnInterrupt
    from twonav_cli.terminal.learning_place import place_of_random_maze
    from twonav_cli.terminal.screen import watch_screen
    from twonav_cli.terminal.train import TrainRequest
    from twonav_cli.terminal.train_maze import train_maze

    def killed(walk: Walk, begun: object) -> None:
        walk.run("trial", 10.0)
        card = read_card(tmp_path)
        assert card["metrics"] == {"unfinished": True}
        monkeypatch.setattr(train_agent, "SAVE_EVERY_S", 1e9)
        walk.run("end", 60.0)
        assert read_card(tmp_path)["metrics"]["goals_learned"] == 10
        raise KeyboardInterrupt

    monkeypatch.setattr(train_agent, "SAVE_EVERY_S", 0.0)
    monkeypatch.setattr(watch_screen, "run_watch", killed)
    request = TrainRequest("maze", random_maze=0, watch=True, recording=False, out=tmp_path)
    with pytest.raises(KeyboardInterrupt):
        train_maze(request, place_of_random_maze(0, 0), tmp_path, StopOnInterrupt())
    assert Agent.load(tmp_path).progress.learned.all()


@pytest.mark.parametrize("coloured", [True, False])
def test_the_help_describes_what_the_terminal_shows(coloured: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "" if coloured else "1")

    async def body(app: WatchScreen, pilot: Pilot[None]) -> None:
        assert ("# walls; @ the agent, * its trail" in shown(app, "help")) != coloured
        assert ("●" in shown(app, "help")) == coloured
        await pilot.press("?")
        await pilot.pause(0.1)
        assert app.query_one("#help").region.height <= 24

    on_screen(body)
