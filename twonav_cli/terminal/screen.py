"""The play screen: floor plan, camera and numbers, a prompt and a status line."""

from __future__ import annotations

import asyncio
import signal
import time
from collections import deque
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.events import Key, Resize
from textual.suggester import SuggestFromList
from textual.widgets import Input, Static

from twonav_cli.errors import TwonavError
from twonav_cli.events import RunStarted
from twonav_cli.maze import Action
from twonav_cli.terminal import game_view
from twonav_cli.terminal.commands import Command, GoTo, Kidnap, Move, Pause, Quit, SingleStep, Speed
from twonav_cli.terminal.console import colour_refused
from twonav_cli.terminal.game import GameState, advance, faster
from twonav_cli.terminal.game_view import Controls
from twonav_cli.terminal.halfblocks import image_picture
from twonav_cli.terminal.picture_panel import PicturePanel
from twonav_cli.terminal.plan import GOAL_KEYS, Plan
from twonav_cli.terminal.plan_drawing import draw_plan
from twonav_cli.terminal.prompt import VOCABULARY, Answer, Press, Wait, read_keys, read_prompt
from twonav_cli.terminal.screen_layout import FRAME, PANELS, layout
from twonav_cli.terminal.simulation_thread import SimulationThread, Start

FRAMES_PER_S = 15
KEY_GAP_S = 0.05
NOTICE_S = 4.0
USUAL_ASPECT = 376 / 192
"""Of the apartment, until the run says what is drawn."""

MOVES = {
    **{key: Action.UP for key in ("up", "w")},
    **{key: Action.DOWN for key in ("down", "s", "j")},
    **{key: Action.LEFT for key in ("left", "a", "h")},
    **{key: Action.RIGHT for key in ("right", "d", "l")},
}
"""Keys that drive; `k` joins them once the player drives, before that it kidnaps."""

HELP = """\
 g or :      type a goal's name (the beginning will do), or a command
 1-9, 0      pick a goal by its mark on the plan
 k           kidnap the robot: carry it elsewhere without telling it
 space       pause, go on                . one step
 + -         faster, slower              tab enlarge one panel after another
 arrows wasd drive by hand; then hjkl drive too, K kidnaps, esc hands back
 q, ctrl-c   leave

 The prompt knows: GOAL, goals, kidnap, pause, resume, step,
 speed 2, up, down, left, right, quit, help

 plan    [cyan] the robot   [magenta] where it believes to be
         arrows: the best action in each cell, from dark (far) to yellow (near)
 values  ◀ the best action; bold the one that was taken"""

STYLE = """
Screen { background: #0d1117; color: #d4dbe4; layers: below above; overflow: hidden; }
PicturePanel, #numbers {
    border: round #3a4656; border-title-color: #8fa1b8; border-title-style: none; background: #0d1117;
}
#top { height: auto; }
#numbers { padding: 0 1; }
#numbers Static { height: 100%; margin-right: 2; }
#q { width: 3fr; }  #pose { width: 31; }  #goals { width: 3fr; }  #log { width: 5fr; margin-right: 0; }
#hint, #prompt, #status { height: 1; }
#prompt { border: none; padding: 0 1; background: #1c2530; color: #ffffff; display: none; }
#prompt:focus { border: none; }
#status { background: #1c2530; }
#help {
    layer: above; display: none; width: 78; height: auto; max-height: 100%; offset: 1 1; padding: 0 1;
    border: round #3cdcf0; background: #161c24; border-title-color: #3cdcf0;
}
"""


class PlayScreen(App[None], inherit_bindings=False):
    """Shows what the simulation does and passes on what the player wants."""

    CSS = STYLE
    ENABLE_COMMAND_PALETTE = False
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+c,ctrl+q", "leave", priority=True, show=False),
        Binding("tab", "cycle(1)", priority=True, show=False),
        Binding("shift+tab", "cycle(-1)", priority=True, show=False),
    ]

    def __init__(
        self,
        simulation: SimulationThread,
        title: str,
        keys: str | None = None,
        stay: bool = True,
        speed: float | None = None,
    ) -> None:
        super().__init__()
        self.state = GameState()
        self.controls = Controls(speed=speed)
        self.left_by_signal: int | None = None
        self._simulation = simulation
        self._name = title
        self._script = deque(read_keys(keys or ""))
        self._stay = stay
        self._coloured = not colour_refused()
        self._plan: Plan | None = None
        self._alone = ""
        self._notice: tuple[str, bool, float] = ("", False, 0.0)
        self._stale = True
        self._trials_seen = 0

    def compose(self) -> ComposeResult:
        """Lay out the widgets."""
        with Horizontal(id="top"):
            yield PicturePanel("plan", "reading the map", "plan")
            yield PicturePanel("camera", "no image yet", "camera")
        with Horizontal(id="numbers"):
            for name in ("q", "pose", "goals", "log"):
                yield Static(id=name)
        yield Static(id="hint")
        yield Input(id="prompt", placeholder="a goal or a command; esc closes", select_on_focus=False)
        yield Static(id="status")
        yield Static(HELP.replace("[cyan]", "cyan:").replace("[magenta]", "magenta:"), id="help", markup=False)

    def on_mount(self) -> None:
        """Start drawing, and catch the signals that would leave the terminal as it is."""
        self.query_one("#numbers").border_title = "values · poses · goals"
        self.query_one("#help").border_title = "help: any key closes it"
        self.set_focus(None)
        self.set_interval(1 / FRAMES_PER_S, self._frame)
        loop = asyncio.get_running_loop()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            loop.add_signal_handler(number, self._leave_by, int(number))
        if self._script:
            self.run_worker(self._press_script(), exit_on_error=True)

    def on_resize(self, _: Resize) -> None:
        """Share the new space."""
        self._share_space()

    def _share_space(self) -> None:
        aspect = self._plan.aspect if self._plan else USUAL_ASPECT
        spaces = layout(self.size.width, self.size.height, aspect, self._alone)
        for name, (cols, rows) in (("plan", spaces.plan), ("camera", spaces.camera)):
            widget = self.query_one(f"#{name}")
            widget.display = rows > 0
            widget.styles.width, widget.styles.height = cols, rows
        numbers = self.query_one("#numbers")
        numbers.display = spaces.numbers_rows > 0
        numbers.styles.height = spaces.numbers_rows
        self.query_one("#top").display = self._alone != "numbers"
        for name, least in (("goals", 3), ("log", 4)):
            self.query_one(f"#{name}").display = spaces.columns >= least
        self._stale = True
        self.call_after_refresh(self._draw)

    def _frame(self) -> None:
        """Take the events that came and draw what they changed."""
        events = self._simulation.feed.take()
        for event in events:
            self.state = advance(self.state, event)
            if isinstance(event, RunStarted):
                self._plan = game_view.plan_of_game(self.state)
                names = self.state.goal_names
                self.query_one("#prompt", Input).suggester = SuggestFromList([*names, *VOCABULARY], case_sensitive=False)
                self._share_space()
        if self._simulation.finished and (self._simulation.error is not None or not self._stay):
            self.exit()
        text, _, until = self._notice
        if text and time.monotonic() > until:
            self._notice = ("", False, 0.0)
            self._stale = True
        if events or self._stale:
            self._draw()

    def _draw(self) -> None:
        self._stale = False
        state = self.state
        plan_panel, camera = self.query_one("#plan", PicturePanel), self.query_one("#camera", PicturePanel)
        if self._plan is not None and plan_panel.display:
            marks = game_view.marks_of_game(state)
            plan_panel.show(draw_plan(self._plan, marks, *_space(plan_panel), self._coloured))
        if state.image is not None and camera.display:
            rows, cols = _space(camera)
            high = max(min(rows, cols // 2), 1)
            camera.show(image_picture(state.image, high, 2 * high, self._coloured))
        if self.query_one("#numbers").display:
            self._draw_numbers()
        self._draw_lines()

    def _draw_numbers(self) -> None:
        state = self.state
        q, pose, goals, log = (self.query_one(f"#{name}", Static) for name in ("q", "pose", "goals", "log"))
        rows = q.size.height
        q.update(game_view.values_text(state, q.size.width))
        pose.update(game_view.pose_text(state))
        goals.update(game_view.goals_text(state, goals.size.width, rows))
        log.update(game_view.log_text(state, log.size.width, rows))

    def _draw_lines(self) -> None:
        cols = self.size.width
        text, bad, _ = self._notice
        hint = game_view.notice_text(text, bad, cols) if text else game_view.hint_text(self.state, self.controls, cols)
        self.query_one("#hint", Static).update(hint)
        self.query_one("#status", Static).update(
            game_view.status_text(self.state, self.controls, self._name, cols)
        )
