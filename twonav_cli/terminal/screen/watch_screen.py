"""The screen on which one watches an agent learn: the maze, the TD errors, the numbers."""

from __future__ import annotations

import asyncio
import signal
import time
from typing import ClassVar

from textual.app import App, ComposeResult
from textual.binding import Binding, BindingType
from textual.events import Key, Resize
from textual.widget import Widget
from textual.widgets import Static

from twonav_cli.events import Event, RunStarted
from twonav_cli.terminal.console import colour_refused
from twonav_cli.terminal.screen import watch_view
from twonav_cli.terminal.screen.picture_panel import PicturePanel
from twonav_cli.terminal.screen.play_screen import FRAMES_PER_S, SIGNALS
from twonav_cli.terminal.screen.watch_drawing import Heat, Sight, draw_sight, framed, heat_of
from twonav_cli.terminal.screen.watch_keys import HELP, LEAVE, WatchControls, due, press
from twonav_cli.terminal.screen.watch_layout import Box, WatchLayout, watch_layout
from twonav_cli.terminal.screen.watch_state import WatchState, advance, first_state
from twonav_cli.terminal.screen.watch_walk import Walk

BUDGET_S = 0.04
"""Time of a frame that learning may take: the rest is for drawing and for keys."""

HELP_TEXT = """\
The agent learns to reach every goal from every start. Each action teaches
it something about all goals at once (learner single: about its own goal).
A goal is learned when the agent has reached it 50 times in a row from every
start, in much the same number of actions.

space  .    pause or go on; one action
+ -         faster, slower: from 1 action a second to as fast as it goes
t  g  e     to the end of this trial, to the next goal, to the end (enter)
tab         what the colours show: values, TD errors, visits
1-9, 0      look at another goal's table; the key again, or esc: back
q, ctrl-c   stop and save; train --resume goes on from there

"""

HELP_IN_COLOUR = """\
maze        ● (or a white square) the agent, behind it its trail; S where
            the trial began; 1 2 3 the goals, the current one on white;
            arrows: the best action known so far
"""

HELP_IN_CHARACTERS = """\
maze        # walls; @ the agent, * its trail; S where the trial began; 1 2 3
            the goals; . : - = + the scale from low to high; blank: untried;
            ^ v < >: the best action known so far, where there is room
"""

HELP_NUMBERS = """\
TD error    how far the values were off at the latest visit, squared, mean
            over the maze; the agent turns to the goal that is furthest off
floor       what it costs to prove all goals learned if every way is known"""

STYLE = """
Screen { background: #0d1117; color: #d4dbe4; layers: below above; overflow: hidden; }
#maze, #errors, #numbers {
    position: absolute; border: round #3a4656; border-title-color: #8fa1b8; border-title-style: none;
    border-subtitle-color: #6e7a8c; background: #0d1117;
}
#errors, #numbers { padding: 0 1; }
#hint, #status { position: absolute; height: 1; width: 100%; }
#status { background: #1c2530; }
#help {
    layer: above; display: none; width: 80; height: auto; max-height: 100%; padding: 0 1;
    border: round #3cdcf0; background: #161c24; border-title-color: #3cdcf0;
}
"""


class WatchScreen(App[None], inherit_bindings=False):
    """Shows a walk and lets the person at the screen say how it goes on."""

    CSS = STYLE
    ENABLE_COMMAND_PALETTE = False
    AUTO_FOCUS = None
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+c,ctrl+q", "leave", priority=True, show=False),
        Binding("tab", "press('tab')", priority=True, show=False),
        Binding("shift+tab", "press('shift+tab')", priority=True, show=False),
    ]

    def __init__(self, walk: Walk, begun: RunStarted, controls: WatchControls | None = None) -> None:
        super().__init__()
        self.state: WatchState = first_state(begun, walk.agent)
        self.controls = controls or WatchControls()
        self.error: BaseException | None = None
        self.title = f"{begun.scene}, {walk.agent.config.learner}"
        self._walk = walk
        self._coloured = not colour_refused()
        self._spaces: WatchLayout | None = None
        self._begun = False
        self._stale = True
        self._seen_at = time.monotonic()

    def compose(self) -> ComposeResult:
        """Lay out the widgets."""
        yield PicturePanel("maze", "preparing the learning loop (once, up to a minute)", "maze")
        yield Static(id="errors")
        yield Static(id="numbers")
        yield Static(id="hint")
        yield Static(id="status")
        maze = HELP_IN_COLOUR if self._coloured else HELP_IN_CHARACTERS
        yield Static(HELP_TEXT + maze + HELP_NUMBERS, id="help", markup=False)

    def on_mount(self) -> None:
        """Begin, and catch the signals that would leave the terminal as it is."""
        self.query_one("#errors").border_title = "TD error of every goal"
        self.query_one("#numbers").border_title = "learning"
        self.query_one("#help").border_title = "help: any key closes it"
        loop = asyncio.get_running_loop()
        for number in SIGNALS:
            loop.add_signal_handler(number, self.action_leave)
        self.run_worker(self._begin(), exit_on_error=False)

    async def _begin(self) -> None:
        """Choose the first goal in a thread, for that compiles the loop, and let the frames come."""
        try:
            self._follow(await asyncio.to_thread(self._walk.take, 0) if not self._walk.over else [])
        except Exception as error:  # handed to the caller of `run_watch`, once the terminal is as it was
            self._fail(error)
            return
        self._begun, self._seen_at = True, time.monotonic()
        self._draw()
        self.set_interval(1 / FRAMES_PER_S, self._frame)

    def on_resize(self, _: Resize) -> None:
        """Share the new space."""
        rows, cols = framed(self._sight(None)).blocked.shape
        self._spaces = watch_layout(self.size.width, self.size.height, rows, cols, len(self.state.goal_names))
        for name, box in (
            ("maze", self._spaces.maze),
            ("errors", self._spaces.errors),
            ("numbers", self._spaces.numbers),
        ):
            _place(self.query_one(f"#{name}"), box)
        _place(self.query_one("#hint"), Box(0, self.size.height - 2, self.size.width, 1))
        _place(self.query_one("#status"), Box(0, self.size.height - 1, self.size.width, 1))
        self.call_after_refresh(self._draw)

    def _frame(self) -> None:
        """Let the agent go on as far as is due, and draw what changed."""
        now = time.monotonic()
        elapsed_s, self._seen_at = now - self._seen_at, now
        try:
            events = self._moved_on(elapsed_s)
        except Exception as error:  # as in _begin
            self._fail(error)
            return
        self._follow(events)
        if events or self._stale:
            self._draw()

    def _moved_on(self, elapsed_s: float) -> list[Event]:
        """Take the actions that are due."""
        if self._walk.over:
            return []
        skip = self.controls.skip
        self.controls, actions = due(self.controls, elapsed_s)
        if actions is None:
            events = self._walk.run(skip, BUDGET_S)
            if self._walk.has_ended(skip, events):
                self.controls = self.controls.arrived()
            return events
        return self._walk.take(actions) if actions else []

    def _follow(self, events: list[Event]) -> None:
        for event in events:
            self.state = advance(self.state, event)

    def _fail(self, error: BaseException) -> None:
        self.error = error
        self.exit()

    def _heat(self) -> Heat:
        agent, names = self._walk.agent, self.state.goal_names
        goal = names.index(watch_view.shown_goal(self.state, self.controls))
        return heat_of(
            self.controls.heat, agent.q[..., goal], agent.td[..., goal], self._walk.learning.loop.visits(),
            agent.config.initial_q, agent.config.initial_td_error,
        )  # fmt: skip

    def _sight(self, heat: Heat | None) -> Sight:
        state, maze = self.state, self.state.maze
        return Sight(
            maze.blocked, heat or self._heat(), maze.goals, state.goal, state.start, state.cell, state.trail
        )  # fmt: skip

    def _draw(self) -> None:
        if self._spaces is None:
            return
        self._stale = False
        if self._begun:
            heat = self._heat()
            panel = self.query_one("#maze", PicturePanel)
            rows, cols = max(panel.size.height, 1), max(panel.size.width, 1)
            panel.show(draw_sight(framed(self._sight(heat)), self._spaces.zoom, rows, cols, self._coloured))
            titles = watch_view.maze_titles(self.state, self.controls, heat, cols - 2, self._coloured)
            panel.border_title, panel.border_subtitle = titles
        errors, numbers = self.query_one("#errors", Static), self.query_one("#numbers", Static)
        errors.update(watch_view.errors_text(self.state, self.controls, errors.size.width, errors.size.height))
        numbers.update(watch_view.numbers_text(self.state, self._walk.agent, numbers.size.width, numbers.size.height))
        cols = self.size.width
        self.query_one("#hint", Static).update(watch_view.hint_text(self.state, self.controls, cols))
        self.query_one("#status", Static).update(watch_view.status_text(self.state, self.controls, self.title, cols))

    def on_key(self, event: Key) -> None:
        """Do what a key asks for; while the help is open, any key closes it."""
        printable = event.character is not None and event.character.isprintable() and event.character != " "
        self.action_press(str(event.character) if printable else event.key)

    def action_press(self, key: str) -> None:
        """Do what a key asks for."""
        help_ = self.query_one("#help")
        if help_.display:
            help_.display = False
            return
        self.controls, opens = press(key, self.controls, self.state.goal_names)
        self._stale = True
        if opens == HELP:
            help_.display = True
        elif opens == LEAVE:
            self.exit()

    def action_leave(self) -> None:
        """Leave, whatever is open."""
        self.exit()


def _place(widget: Widget, box: Box) -> None:
    """Put a widget where its box is; one without rows is hidden."""
    widget.display = box.rows > 0
    widget.styles.offset = (box.left, box.top)
    widget.styles.width, widget.styles.height = box.cols, box.rows


def run_watch(walk: Walk, begun: RunStarted) -> None:
    """Show a walk until it is over and the person at the screen leaves, or only the latter.

    Raises:
        BaseException: What the learning raised; the terminal is restored by then.
    """
    app = WatchScreen(walk, begun)
    before = {number: signal.getsignal(number) for number in SIGNALS}
    try:
        app.run(mouse=False)
    finally:
        for number, action in before.items():
            signal.signal(number, action)
    if app.error is not None:
        raise app.error
