"""What every key does: a pure function from the key and the controls to new controls and commands."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from twonav_cli.maze import Action
from twonav_cli.terminal.commands import Command, GoTo, Kidnap, Move, Pause, Quit, SingleStep, Speed
from twonav_cli.terminal.screen.floor_plan import goal_key
from twonav_cli.terminal.screen.game import faster

MOVES = {
    **dict.fromkeys(("up", "w"), Action.UP),
    **dict.fromkeys(("down", "s", "j"), Action.DOWN),
    **dict.fromkeys(("left", "a", "h"), Action.LEFT),
    **dict.fromkeys(("right", "d", "l"), Action.RIGHT),
}
"""Keys that drive. `k` joins them once the player drives; before that it kidnaps."""

PROMPT, HELP = "prompt", "help"


@dataclass(frozen=True)
class Controls:
    """What the player has set."""

    paused: bool = False
    speed: float | None = None
    """Factor of real time, 0 for no limit, None when nobody has said."""
    driving: bool = False
    """The player moves the robot by hand."""
    heat: bool = True
    """The plan shows the belief."""


@dataclass(frozen=True)
class Pressed:
    """What a key did."""

    controls: Controls
    commands: tuple[Command, ...] = ()
    opens: str = ""
    """PROMPT, HELP or nothing."""


def press(key: str, controls: Controls, goals: Sequence[str]) -> Pressed:
    """Return what a key does: a character, or the name of a key that has none ("space", "up", "escape")."""
    if key in MOVES or (key == "k" and controls.driving):
        return Pressed(replace(controls, driving=True), (Move(int(MOVES.get(key, Action.UP))),))
    if key in ("k", "K"):
        return Pressed(controls, (Kidnap(),))
    if key in ("g", ":", "/", "enter"):
        return Pressed(controls, opens=PROMPT)
    if key == "?":
        return Pressed(controls, opens=HELP)
    if key == "b":
        return Pressed(replace(controls, heat=not controls.heat))
    if key == "escape":
        return Pressed(replace(controls, driving=False))
    if key.isdigit():
        chosen = [goal for index, goal in enumerate(goals) if goal_key(index) == key]
        return after_commands(controls, *(GoTo(goal) for goal in chosen))
    asked: dict[str, Command] = {
        "q": Quit(),
        "space": Pause(not controls.paused),
        ".": SingleStep(),
        "+": Speed(_speed(controls, 1)),
        "=": Speed(_speed(controls, 1)),
        "-": Speed(_speed(controls, -1)),
    }
    return after_commands(controls, asked[key]) if key in asked else Pressed(controls)


def after_commands(controls: Controls, *commands: Command) -> Pressed:
    """Return the controls as the commands set them: a goal takes the wheel from the player, a single step pauses."""
    for command in commands:
        match command:
            case GoTo():
                controls = replace(controls, driving=False)
            case Pause(on):
                controls = replace(controls, paused=on)
            case SingleStep():
                controls = replace(controls, paused=True)
            case Speed(factor):
                controls = replace(controls, speed=factor)
            case Move():
                controls = replace(controls, driving=True)
    return Pressed(controls, commands)


def _speed(controls: Controls, steps: int) -> float:
    return faster(1.0 if controls.speed is None else controls.speed, steps)
