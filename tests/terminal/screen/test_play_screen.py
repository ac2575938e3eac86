"""The play screen, driven by its own keys and through a pseudo-terminal."""

from __future__ import annotations

import asyncio
import os
import pty
import select
import subprocess
import sys
import time
from collections.abc import Awaitable, Callable
from pathlib import Path

import pytest
from fake_game import FakeGame
from textual.events import Key
from textual.pilot import Pilot
from textual.widgets import Input, Static

from twonav_cli.errors import TwonavError
from twonav_cli.terminal.commands import AddGoal, GoTo, Kidnap, Quit
from twonav_cli.terminal.screen.layout import layout
from twonav_cli.terminal.screen.play_screen import PlayScreen
from twonav_cli.terminal.screen.simulation_thread import SimulationThread

Body = Callable[[PlayScreen, FakeGame, "Pilot[None]"], Awaitable[None]]


def on_screen(body: Body, size: tuple[int, int] = (80, 24), keys: str | None = None, stage: str = "3d") -> FakeGame:
    """Run a body against a screen that shows the made-up game."""
    game = FakeGame(stage=stage)
    simulation = SimulationThread(game.play)
    app = PlayScreen(simulation, "twonav: test", keys)

    async def run() -> None:
        simulation.start()
        async with app.run_test(size=size) as pilot:
            await until(lambda: app.state.run is not None, pilot)
            await body(app, game, pilot)

    asyncio.run(run())
    assert simulation.result() == 7
    return game


async def until(condition: Callable[[], bool], pilot: Pilot[None]) -> None:
    """Wait up to ten seconds."""
    deadline = time.monotonic() + 10
    while not condition():
        assert time.monotonic() < deadline, "waited in vain"
        await pilot.pause(0.02)


def shown(app: PlayScreen, name: str) -> str:
    return str(app.query_one(f"#{name}", Static).render())


@pytest.mark.parametrize("size", [(80, 24), (120, 40), (200, 50), (40, 12), (20, 5)])
def test_a_goal_is_reached_and_its_number_stands_in_the_status_line_at_any_size(size: tuple[int, int]) -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await pilot.press("1")
        await until(lambda: app.state.last_trial is not None, pilot)
        await pilot.pause(0.2)
        assert "kitchen in 26 actions" in shown(app, "status")

    assert on_screen(body, size).asked[0] == GoTo("kitchen")


def test_typing_a_goal_does_not_press_keys() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await pilot.press("g", *"kitchen", "enter")
        await until(lambda: app.state.last_trial is not None, pilot)
        assert not app.query_one("#prompt", Input).display

    assert [c for c in on_screen(body).asked if not isinstance(c, Quit)] == [GoTo("kitchen")]


def test_a_wrong_goal_is_answered_in_one_line() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await pilot.press("g", *"kithcen", "enter")
        await pilot.pause(0.2)
        assert "did you mean 'kitchen'" in shown(app, "hint")

    assert on_screen(body).asked == []


def test_a_goal_is_added_drawn_listed_and_driven_to() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await pilot.press("g", *"goal add plant 0.2 7.4", "enter")
        await until(lambda: "plant" in app.state.goal_names, pilot)
        await pilot.pause(0.2)
        assert "plant: learned in" in shown(app, "hint")
        assert "plant" in shown(app, "goals")
        await pilot.press("g", *"pla", "enter")
        await until(lambda: app.state.last_trial is not None, pilot)
        await pilot.pause(0.2)
        assert "plant in " in shown(app, "status")
        drawn = "".join(app.query_one("#plan").render_line(row).text for row in range(30))
        assert "plant" in drawn

    game = on_screen(body, size=(140, 40))
    assert [c for c in game.asked if not isinstance(c, Quit)] == [AddGoal("plant", 0.2, 7.4), GoTo("plant")]


def test_scripted_keys_add_a_goal_and_drive_there_without_waiting_for_it() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await until(lambda: any(isinstance(c, Quit) for c in game.asked), pilot)
        assert app.state.outcomes == {"reached": 1}

    keys = "g goal<space>add<space>plant<space>0.2<space>7.4<enter> g plant<enter> <wait> q"
    assert on_screen(body, keys=keys).asked == [AddGoal("plant", 0.2, 7.4), GoTo("plant"), Quit()]


@pytest.mark.parametrize("size", [(80, 24), (140, 40)])
def test_the_screen_shows_the_belief_until_b_hides_it(size: tuple[int, int]) -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        def colours() -> set[str]:
            panel = app.query_one("#plan")
            rows = (panel.render_line(row) for row in range(panel.size.height))
            return {str(s.style.bgcolor.name) for row in rows for s in row if s.style and s.style.bgcolor}

        await pilot.press("1")
        await until(lambda: app.state.last_trial is not None, pilot)
        await pilot.pause(0.2)
        assert "sure   0.63" in shown(app, "pose")
        assert "or 0.27 at (11.0, 8.0)" in shown(app, "pose")
        with_heat = colours()
        await pilot.press("b")
        await pilot.pause(0.2)
        assert with_heat - colours()
        await pilot.press("b")
        await pilot.pause(0.2)
        assert colours() == with_heat

    on_screen(body, size)


async def visible_by_tabs(app: PlayScreen, pilot: Pilot[None], times: int) -> list[list[str]]:
    """Return the panels that are seen after each press of Tab."""
    visible = []
    for _ in range(times):
        await pilot.press("tab")
        await pilot.pause(0.1)
        visible.append([n for n in ("plan", "camera", "numbers") if app.query_one(f"#{n}").region.area > 0])
    return visible


def test_tab_enlarges_one_panel_after_another_and_comes_back() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        assert await visible_by_tabs(app, pilot, 4) == [
            ["plan"],
            ["camera"],
            ["numbers"],
            ["plan", "camera", "numbers"],
        ]

    on_screen(body)


def test_without_a_camera_its_room_is_the_plans() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        assert await visible_by_tabs(app, pilot, 3) == [["plan"], ["numbers"], ["plan", "numbers"]]
        assert app.query_one("#plan").region.width == 80

    on_screen(body, stage="2d")


def test_an_impatient_tab_leaves_no_empty_camera_behind() -> None:
    game = FakeGame(stage="2d")
    simulation = SimulationThread(game.play)
    app = PlayScreen(simulation, "twonav: test")

    async def run() -> None:
        async with app.run_test(size=(80, 24)) as pilot:
            await pilot.press("tab", "tab")  # the camera alone, before anything is known
            simulation.start()
            await until(lambda: app.state.run is not None, pilot)
            await pilot.pause(0.2)
            assert app.query_one("#plan").region.width == 80
            await pilot.press("tab")

    asyncio.run(run())
    simulation.result()


def test_scripted_keys_play_a_game_and_leave() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await until(lambda: any(isinstance(c, Quit) for c in game.asked), pilot)

    assert on_screen(body, keys="g bed<enter> <wait> k q").asked == [GoTo("bedroom"), Kidnap(), Quit()]


def test_without_colour_the_plan_is_readable_characters(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NO_COLOR", "1")

    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await pilot.press("1")
        await until(lambda: app.state.last_trial is not None, pilot)
        await pilot.pause(0.2)
        drawn = "".join(app.query_one("#plan").render_line(row).text for row in range(13))
        assert {"#", "@", "*"} <= set(drawn)
        assert "▀" not in drawn

    on_screen(body)


def test_help_opens_and_any_key_closes_it_without_doing_more() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        await pilot.press("?")
        assert app.query_one("#help").display
        await pilot.press("k")
        assert not app.query_one("#help").display

    assert on_screen(body).asked == []


def test_what_the_simulation_raises_closes_the_screen_and_comes_out() -> None:
    def start(*_: object) -> int:
        raise TwonavError("no map")

    simulation = SimulationThread(start)
    app = PlayScreen(simulation, "twonav: test")

    async def run() -> None:
        simulation.start()
        async with app.run_test():
            deadline = time.monotonic() + 10
            while app.is_running and time.monotonic() < deadline:
                await asyncio.sleep(0.02)

    asyncio.run(run())
    assert not app.is_running
    with pytest.raises(TwonavError, match="no map"):
        simulation.result()


@pytest.mark.parametrize(("cols", "rows"), [(80, 24), (120, 40), (100, 24), (60, 60)])
def test_the_panels_fill_the_terminal_and_leave_two_lines(cols: int, rows: int) -> None:
    spaces = layout(cols, rows, 376 / 192)
    assert spaces.plan[0] + spaces.camera[0] == cols
    assert spaces.plan[1] == spaces.camera[1]
    assert spaces.plan[1] + spaces.numbers_rows + 2 == rows
    assert spaces.numbers_rows >= 7
    alone = layout(cols, rows, 376 / 192, camera=False)
    assert alone.plan[0] == cols
    assert alone.plan[1] + alone.numbers_rows + 2 == rows
    assert alone.plan[1] >= spaces.plan[1]


@pytest.mark.parametrize("key", [b"\x03", b"q"])
def test_leaving_restores_the_terminal(key: bytes) -> None:
    output, code = in_terminal(key)
    assert b"\x1b[?1049h" in output, "the alternate screen was entered"
    assert output.rindex(b"\x1b[?1049l") > output.rindex(b"\x1b[?1049h"), "and left"
    assert output.rindex(b"\x1b[?25h") > output.rindex(b"\x1b[?25l"), "the cursor is back"
    assert b"exit code 7" in output[output.rindex(b"\x1b[?1049l") :]
    assert code == 0


def in_terminal(key: bytes) -> tuple[bytes, int]:
    """Run the made-up game in a pseudo-terminal, press a key once the plan is there; returns output and exit code."""
    leader, follower = pty.openpty()
    here = Path(__file__).resolve().parents[1]
    env = {**os.environ, "TERM": "xterm-256color", "COLUMNS": "80", "LINES": "24", "PYTHONPATH": str(here.parents[1])}
    game = subprocess.Popen(
        [sys.executable, str(here / "fake_game.py")],
        stdin=follower,
        stdout=follower,
        stderr=follower,
        env=env,
    )
    os.close(follower)
    output, pressed, deadline = b"", False, time.monotonic() + 30
    try:
        while time.monotonic() < deadline:
            if select.select([leader], [], [], 0.1)[0]:
                try:
                    output += os.read(leader, 65536)
                except OSError:  # the other end is closed: the game has ended
                    break
            if not pressed and b"choose a goal" in output:
                os.write(leader, key)
                pressed = True
        return output, game.wait(timeout=5)
    finally:
        game.kill()
        os.close(leader)


def test_keys_that_come_in_a_burst_lose_nothing_to_the_prompt_that_opens() -> None:
    async def body(app: PlayScreen, game: FakeGame, pilot: Pilot[None]) -> None:
        for character in "ggoal add x 1 2":
            app.post_message(Key(character, character))
        await until(lambda: app.query_one("#prompt", Input).value == "goal add x 1 2", pilot)
        await pilot.press("enter")

    assert [c for c in on_screen(body).asked if not isinstance(c, Quit)] == [AddGoal("x", 1.0, 2.0)]
