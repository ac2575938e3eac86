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
from textual.events import Event as TextualEvent
from textual.events import Key, Resize
from textual.suggester import SuggestFromList
from textual.widgets import Input, Static

from twonav_cli.errors import TwonavError
from twonav_cli.events import Event, GoalAdded, Note, RunStarted
from twonav_cli.terminal.commands import AddGoal, Quit
from twonav_cli.terminal.console import colour_refused
from twonav_cli.terminal.screen import game_view
from twonav_cli.terminal.screen.floor_plan import Plan
from twonav_cli.terminal.screen.game import GameState, advance
from twonav_cli.terminal.screen.halfblocks import image_picture
from twonav_cli.terminal.screen.keys import Controls, Pressed, after_commands, press
from twonav_cli.terminal.screen.layout import PANELS, layout
from twonav_cli.terminal.screen.picture_panel import PicturePanel
from twonav_cli.terminal.screen.plan_drawing import draw_plan
from twonav_cli.terminal.screen.prompt import VOCABULARY, Answer, Wait, read_keys, read_prompt
from twonav_cli.terminal.screen.simulation_thread import SimulationThread, Start

FRAMES_PER_S = 15
KEY_GAP_S = 0.05
NOTICE_S = 4.0
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
USUAL_ASPECT = 376 / 192
"""Of the apartment, until the run says what is drawn."""

HELP = """\
g or :       type a goal's name (its beginning will do) or a command
1-9, 0       pick a goal by its mark on the plan
k            kidnap the robot: carry it elsewhere without telling it
space  .     pause or go on; one step
+ -          faster, slower
b            show or hide the belief on the plan
tab          enlarge one panel after another
arrows wasd  drive by hand; then hjkl drive too, K kidnaps, esc ends it
q, ctrl-c    leave

prompt       GOAL  goals  kidnap  pause  resume  step  speed 2
             up  down  left  right  quit  help
             goal add NAME X Y: a new goal at x, y in metres, learned
             at once from what the robot remembers; without X Y: here
plan         cyan: the robot; magenta: where it believes to be;
             arrows: best action, yellow near the goal, blue far from it
             violet: where the last picture could be from, pale is likely
             ?: other places where it could be; the numbers give weights
values       ◀ the best action; bold: the one that was taken"""

PRIORITY_KEYS = ("ctrl+c", "ctrl+q", "tab", "shift+tab")
"""Keys that do the same whoever has the focus."""

STYLE = """
Screen { background: #0d1117; color: #d4dbe4; layers: below above; overflow: hidden; }
PicturePanel, #numbers {
    border: round #3a4656; border-title-color: #8fa1b8; border-title-style: none; background: #0d1117;
}
#top { height: auto; }
#numbers { padding: 0 1; }
#numbers Static { height: 100%; margin-right: 2; }
#q { width: 1fr; max-width: 34; }  #pose { width: 25; }  #goals { width: 22; }  #log { width: 1fr; margin-right: 0; }
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
    AUTO_FOCUS = None
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
        self.title = title
        self._script = deque(read_keys(keys or ""))
        self._stay = stay
        self._coloured = not colour_refused()
        self._plan: Plan | None = None
        self._alone = ""
        self._notice: tuple[str, bool, float] = ("", False, 0.0)
        self._new_goals: list[str] = []
        """Names of goals that the simulation was asked to add, so that they can be asked for at once."""
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
        yield Static(HELP, id="help", markup=False)

    def on_mount(self) -> None:
        """Start drawing, and catch the signals that would leave the terminal as it is."""
        self.query_one("#numbers").border_title = "values · poses · goals"
        self.query_one("#help").border_title = "help: any key closes it"
        self.set_focus(None)
        self.set_interval(1 / FRAMES_PER_S, self._frame)
        loop = asyncio.get_running_loop()
        for number in SIGNALS:
            loop.add_signal_handler(number, self._leave_by, int(number))
        if self._script:
            self.run_worker(self._press_script(), exit_on_error=True)

    def on_resize(self, _: Resize) -> None:
        """Share the new space."""
        self._share_space()

    @property
    def _has_camera(self) -> bool:
        """Whether there is a picture to show: in 3D; before the run begins nobody knows."""
        return self.state.run is None or self.state.run.stage == "3d"

    def _share_space(self) -> None:
        aspect = self._plan.aspect if self._plan else USUAL_ASPECT
        spaces = layout(self.size.width, self.size.height, aspect, self._alone, self._has_camera)
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
            self._take_over(event)
        if self._simulation.finished and (self._simulation.error is not None or not self._stay):
            self.exit()
        text, _, until = self._notice
        if text and time.monotonic() > until:
            self._notice = ("", False, 0.0)
            self._stale = True
        if events or self._stale:
            self._draw()

    def _take_over(self, event: Event) -> None:
        """Bring up to date what depends on more than the state: the plan, the prompt's suggestions, the notice."""
        if isinstance(event, Note):
            self._notify(event.text, bad=event.level != "INFO")
        elif isinstance(event, RunStarted | GoalAdded):
            self._plan = game_view.plan_of_game(self.state)
            if self._alone == "camera" and not self._has_camera:
                self._alone = ""
            words = [*self.state.goal_names, *VOCABULARY]
            self.query_one("#prompt", Input).suggester = SuggestFromList(words, case_sensitive=False)
            self._share_space()

    def _notify(self, text: str, bad: bool = False) -> None:
        """Show a sentence in the place of the hints for a while."""
        self._notice = (text, bad, time.monotonic() + NOTICE_S)
        self._stale = True

    def _draw(self) -> None:
        self._stale = False
        state = self.state
        plan_panel, camera = self.query_one("#plan", PicturePanel), self.query_one("#camera", PicturePanel)
        if self._plan is not None and plan_panel.display:
            marks = game_view.marks_of_game(state, self.controls.heat)
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
        pose.update(game_view.pose_text(state, rows))
        goals.update(game_view.goals_text(state, goals.size.width, rows))
        log.update(game_view.log_text(state, log.size.width, rows))

    def _draw_lines(self) -> None:
        cols = self.size.width
        text, bad, _ = self._notice
        hint = game_view.notice_text(text, bad, cols) if text else game_view.hint_text(self.state, self.controls, cols)
        self.query_one("#hint", Static).update(hint)
        self.query_one("#status", Static).update(game_view.status_text(self.state, self.controls, self.title, cols))

    async def on_event(self, event: TextualEvent) -> None:
        """Read a key that no widget has the focus for at once: the next may be for the prompt that it opens.

        Otherwise keys that come in a burst are on their way through the screen while the prompt takes the focus, and
        the first of them are lost.
        """
        read_here = isinstance(event, Key) and not event.is_forwarded and event.key not in PRIORITY_KEYS
        if read_here and self.focused is None:
            assert isinstance(event, Key)
            self.on_key(event)
        else:
            await super().on_event(event)

    def on_key(self, event: Key) -> None:
        """Do what a key asks for, unless the prompt has it."""
        prompt, help_ = self.query_one("#prompt", Input), self.query_one("#help")
        if prompt.display:
            if event.key == "escape":
                self._close_prompt()
            return
        if help_.display:
            help_.display = False
            return
        printable = event.character is not None and event.character.isprintable() and event.character != " "
        self._apply(press(str(event.character) if printable else event.key, self.controls, self.state.goal_names))

    def _apply(self, pressed: Pressed) -> None:
        """Take over new controls, pass the commands on, open what is to be opened."""
        self.controls = pressed.controls
        self._stale = True
        for command in pressed.commands:
            self._simulation.commands.put(command)
            if isinstance(command, Quit):
                self.exit()
            elif isinstance(command, AddGoal):
                self._new_goals.append(command.name)
        if pressed.opens == "help":
            self.query_one("#help").display = True
        elif pressed.opens == "prompt":
            prompt = self.query_one("#prompt", Input)
            prompt.value = ""
            prompt.display = True
            self.query_one("#hint").display = False
            self.screen.set_focus(prompt)

    def _close_prompt(self) -> None:
        self.set_focus(None)
        self.query_one("#prompt").display = False
        self.query_one("#hint").display = True

    def on_input_submitted(self, event: Input.Submitted) -> None:
        """Read what was typed."""
        self._close_prompt()
        goals = self.state.goal_names
        try:
            asked = read_prompt(event.value, goals, self._new_goals)
        except TwonavError as error:
            self._notify(str(error), bad=True)
            return
        if not isinstance(asked, Answer):
            self._apply(after_commands(self.controls, asked))
        elif asked.topic == "help":
            self._apply(Pressed(self.controls, opens="help"))
        elif asked.topic == "goals":
            self._notify("goals: " + ", ".join(goals))

    def action_cycle(self, places: int) -> None:
        """Enlarge the next panel; in the prompt, take what it suggests."""
        prompt = self.query_one("#prompt", Input)
        if prompt.display:
            prompt.action_cursor_right()
            return
        order = ("", *(panel for panel in PANELS if panel != "camera" or self._has_camera))
        self._alone = order[(order.index(self._alone) + places) % len(order)]
        self._share_space()

    def action_leave(self) -> None:
        """Leave, whatever is open."""
        self._simulation.commands.put(Quit())
        self.exit()

    def _leave_by(self, number: int) -> None:
        self.left_by_signal = number
        self.action_leave()

    async def _press_script(self) -> None:
        """Press the scripted keys one after the other, once the run has begun."""
        while self.state.run is None and not self._simulation.finished:
            await asyncio.sleep(KEY_GAP_S)
        for key in self._script:
            if isinstance(key, Wait):
                await self._wait(key.seconds)
                continue
            await asyncio.sleep(KEY_GAP_S)
            character = {"space": " "}.get(key.key, key.key if len(key.key) == 1 else None)
            self.post_message(Key(key.key, character))
            await self._settled()

    async def _settled(self) -> None:
        """Wait until a key and what follows from it is done: it goes to the prompt, and from there back to the app.

        While the simulation loads, the screen may come late; the next key would go where this one was still awaited.
        """
        for place in (self, self.query_one("#prompt"), self.screen, self):
            done = asyncio.Event()
            place.call_later(done.set)
            await done.wait()

    async def _wait(self, seconds: float | None) -> None:
        """Wait some seconds, or until one more trial than at the last wait has ended."""
        if seconds is not None:
            await asyncio.sleep(seconds)
            return
        while self._trials_ended() <= self._trials_seen and not self._simulation.finished:
            await asyncio.sleep(KEY_GAP_S)
        self._trials_seen = self._trials_ended()

    def _trials_ended(self) -> int:
        return sum(self.state.outcomes.values())


def _space(panel: PicturePanel) -> tuple[int, int]:
    """Return the (rows, columns) inside a panel's frame."""
    return max(panel.size.height, 1), max(panel.size.width, 1)


def run_screen(start: Start, title: str, keys: str | None = None, stay: bool = True, speed: float | None = None) -> int:
    """Show a simulation until the player leaves.

    Args:
        start: Runs the simulation, in a thread of its own.
        title: Shown in the status line.
        keys: Keys that are pressed once the run has begun, as `prompt.read_keys` reads them.
        stay: Whether the screen waits for the player when the simulation has returned.
        speed: Factor the simulation begins with; + and - count from it.

    Returns:
        The simulation's exit code; 128 + the signal's number when a signal ended it.

    Raises:
        TwonavError: The keys cannot be read, or the simulation does not stop.
        BaseException: What the simulation raised; the terminal is restored by then.
    """
    simulation = SimulationThread(start)
    app = PlayScreen(simulation, title, keys, stay, speed)
    before = {number: signal.getsignal(number) for number in SIGNALS}
    simulation.start()
    try:
        app.run(mouse=False)
    finally:
        for number, action in before.items():
            signal.signal(number, action)
        simulation.stop.set()
        simulation.feed.close()
    code = simulation.result()
    if app.left_by_signal is not None:
        return 128 + app.left_by_signal
    return code or (app.return_code or 0)
