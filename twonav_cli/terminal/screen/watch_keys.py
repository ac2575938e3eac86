"""What every key does while one watches, and how many actions are due: pure functions of keys, controls and time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from twonav_cli.terminal.screen.floor_plan import goal_key

SPEEDS = (1, 10, 100, 1_000, 10_000, 0)
"""Actions per second; 0 is as fast as it goes."""

USUAL_SPEED = 10
LONGEST_FRAME_S = 0.25
"""What a frame makes up for at most: a screen that was held up does not jump."""

VALUES, TD_ERRORS, VISITS = HEATS = ("values", "TD errors", "visits")
"""What the colours of the maze can show."""

TRIAL, GOAL, END = "trial", "goal", "end"
"""What can be skipped to."""

HELP, LEAVE = "help", "leave"


@dataclass(frozen=True)
class WatchControls:
    """What the person at the screen has set.

    Attributes:
        paused: Whether the agent waits.
        speed: One of `SPEEDS`.
        heat: One of `HEATS`.
        looked_at: The goal whose tables are shown, empty for the current one.
        skip: TRIAL, GOAL or END while the agent runs there as fast as it goes, else empty.
        single: Actions asked for one by one and not yet taken.
        owed: Part of an action that is due.
    """

    paused: bool = False
    speed: int = USUAL_SPEED
    heat: str = VALUES
    looked_at: str = ""
    skip: str = ""
    single: int = 0
    owed: float = 0.0

    def arrived(self) -> WatchControls:
        """Return the controls once what was skipped to is there: what held before the skip holds again."""
        return replace(self, skip="", owed=0.0)


def press(key: str, controls: WatchControls, goals: Sequence[str]) -> tuple[WatchControls, str]:
    """Return the controls after a key, and HELP, LEAVE or nothing.

    Args:
        key: A character, or the name of a key that has none ("space", "enter", "tab").
        controls: Before.
        goals: Names of the goals in table order.
    """
    if key in ("?", "q"):
        return controls, HELP if key == "?" else LEAVE
    if key in ("tab", "shift+tab"):
        places = 1 if key == "tab" else -1
        return replace(controls, heat=HEATS[(HEATS.index(controls.heat) + places) % len(HEATS)]), ""
    if key.isdigit():
        named = next((goal for at, goal in enumerate(goals) if goal_key(at) == key), controls.looked_at)
        return replace(controls, looked_at="" if named == controls.looked_at else named), ""
    return _moved_on(key, controls), ""


def _moved_on(key: str, controls: WatchControls) -> WatchControls:
    """Return the controls after a key that says how the agent goes on."""
    match key:
        case "escape":
            return replace(controls, looked_at="", skip="")
        case "space":
            skipping = bool(controls.skip)
            return replace(controls, paused=skipping or not controls.paused, skip="", single=0, owed=0.0)
        case ".":
            return replace(controls, paused=True, skip="", single=controls.single + 1)
        case "+" | "=":
            return replace(controls, speed=_faster(controls.speed, 1))
        case "-" | "_":
            return replace(controls, speed=_faster(controls.speed, -1))
        case "t":
            return replace(controls, skip=TRIAL)
        case "g":
            return replace(controls, skip=GOAL)
        case "e" | "enter":
            return replace(controls, skip=END)
    return controls


def _faster(speed: int, places: int) -> int:
    return SPEEDS[min(max(SPEEDS.index(speed) + places, 0), len(SPEEDS) - 1)]


def due(controls: WatchControls, elapsed_s: float) -> tuple[WatchControls, int | None]:
    """Return the controls after a frame, and the actions it takes: None is as many as it has time for.

    Args:
        controls: Before.
        elapsed_s: Since the frame before.
    """
    if controls.skip:
        return controls, None
    if controls.paused:
        return replace(controls, single=0), controls.single
    if controls.speed == 0:
        return controls, None
    wanted = controls.owed + controls.speed * min(elapsed_s, LONGEST_FRAME_S)
    return replace(controls, owed=wanted % 1), int(wanted)


def speed_text(controls: WatchControls) -> str:
    """Return how fast the agent goes on."""
    if controls.skip:
        return {TRIAL: "to the end of this trial", GOAL: "to the next goal", END: "to the end"}[controls.skip]
    if controls.paused:
        return "PAUSED"
    if controls.speed == 0:
        return "as fast as it goes"
    return f"{controls.speed:,} action{'s' * (controls.speed > 1)}/s"
