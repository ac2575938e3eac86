"""What a player typed, as a command or an answer; and scripted keys. No terminal library is needed for either."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from twonav_cli.errors import TwonavError, unknown_name
from twonav_cli.learner.agent import NAME_LETTERS
from twonav_cli.maze import Action
from twonav_cli.terminal.commands import AddGoal, Command, GoTo, Kidnap, Move, Pause, Quit, SingleStep, Speed

SLOWEST, FASTEST = 0.125, 64.0

WORDS: dict[str, Command] = {
    "kidnap": Kidnap(),
    "pause": Pause(True),
    "resume": Pause(False),
    "step": SingleStep(),
    "up": Move(Action.UP),
    "down": Move(Action.DOWN),
    "left": Move(Action.LEFT),
    "right": Move(Action.RIGHT),
    "quit": Quit(),
    "exit": Quit(),
}
"""Commands of one word."""

VOCABULARY = (*WORDS, "speed", "goals", "goal add", "help")

GOING = ("go", "goto", "goal")

GOAL_NAME = re.compile(rf"(?=.{{1,{NAME_LETTERS}}}$)\w(?:[\w-]*\w)?")
"""What `Agent.add_goal` takes, but that a space ends a word here."""


@dataclass(frozen=True)
class Answer:
    """Something the prompt answers itself; `topic` is "help", "goals" or "" for nothing typed."""

    topic: str


def read_prompt(typed: str, goals: Sequence[str], new_goals: Sequence[str] = ()) -> Command | Answer:
    """Return what a line of the prompt asks for.

    Args:
        typed: A goal's name (or its beginning), `go <goal>`, or a word of `VOCABULARY`; `speed` takes a factor, `goal
            add` a name and a place in metres.
        goals: Names of the goals of this run.
        new_goals: Names of goals that the run was asked to add; it knows whether it could.

    Raises:
        TwonavError: It is none of these; the message names the nearest one.
    """
    words = typed.strip().lower().split()
    if words[:2] == ["goal", "add"]:
        return _new_goal(typed.replace(",", " ").split()[2:], goals)
    if not words:
        return Answer("")
    if words[0] in ("help", "?", "goals") and len(words) == 1:
        return Answer("goals" if words[0] == "goals" else "help")
    if words[0] == "speed":
        return Speed(_factor(words[1:]))
    goals = [*goals, *(name for name in new_goals if name not in goals)]
    goal = _goal_named(" ".join(words), goals)
    if goal is None and words[0] in GOING:
        wanted = " ".join(words[2:] if words[1:2] == ["to"] else words[1:])
        goal = _goal_named(wanted, goals)
        if goal is None:
            raise _unknown("goal", wanted, goals)
    if goal is not None:
        return GoTo(goal)
    if len(words) == 1 and words[0] in WORDS:
        return WORDS[words[0]]
    raise _unknown("goal or command", typed.strip(), (*goals, *VOCABULARY))


def _unknown(kind: str, typed: str, known: Sequence[str]) -> TwonavError:
    """Return the error for a word that is none of the known; what was typed comes last, for a narrow screen cuts it."""
    by_name = {_plain(word): word for word in known}
    begun = [name for name in by_name if typed and name.startswith(_plain(typed))]
    near = begun or difflib.get_close_matches(_plain(typed), by_name, n=1, cutoff=0.5)
    advice = (
        f"did you mean {' or '.join(repr(by_name[name]) for name in near)}?"
        if near
        else "type `goals` or `help` to see what there is:"
    )
    return TwonavError(f"{advice} no {kind} is called {typed!r}")


def _new_goal(words: Sequence[str], goals: Sequence[str]) -> AddGoal:
    """Return the goal of `goal add <name>`, here, or `goal add <name> <x> <y>`."""
    if len(words) not in (1, 3):
        raise TwonavError(
            "goal add takes a name and, unless it is here, x and y in metres: type `goal add plant 3.2 1.5`"
        )
    name = words[0]
    if name.lower() in {word.split()[0] for word in (*VOCABULARY, *GOING)}:
        raise TwonavError(f"a goal cannot be called as a command is: choose another name than {name!r}")
    if _plain(name) in {_plain(goal) for goal in goals}:
        raise TwonavError(f"there is such a goal already: choose another name than {name!r}")
    if not GOAL_NAME.fullmatch(name):
        raise TwonavError(f"a goal's name has up to {NAME_LETTERS} letters and digits, - or _ between: not {name!r}")
    return AddGoal(name, *(_metres(word) for word in words[1:]))


def _metres(word: str) -> float:
    try:
        metres = float(word)
    except ValueError:
        metres = math.nan
    if not math.isfinite(metres):
        raise TwonavError(f"x and y are numbers of metres, as in `goal add plant 3.2 1.5`: not {word!r}")
    return metres


def _factor(words: Sequence[str]) -> float:
    """Return the factor of `speed <factor>`; `2x` and `x2` are 2."""
    try:
        factor = float(words[0].strip("x")) if len(words) == 1 else math.nan
    except ValueError:
        factor = math.nan
    if not SLOWEST <= factor <= FASTEST:
        raise TwonavError(f"speed takes a factor from {SLOWEST:g} to {FASTEST:g}: type `speed 2`")
    return factor


def _plain(name: str) -> str:
    return re.sub(r"[\s_-]+", " ", name.lower()).strip()


def _goal_named(typed: str, goals: Iterable[str]) -> str | None:
    """Return the goal of that name, else the only one that begins so; a command's word is never a beginning."""
    wanted = _plain(typed)
    by_name = {_plain(goal): goal for goal in goals}
    if wanted in by_name:
        return by_name[wanted]
    starting = [goal for name, goal in by_name.items() if wanted and name.startswith(wanted)]
    return starting[0] if len(starting) == 1 and wanted not in VOCABULARY else None


@dataclass(frozen=True)
class Press:
    """One scripted key: a character, or a name of `NAMED_KEYS`."""

    key: str


@dataclass(frozen=True)
class Wait:
    """A scripted pause: `seconds`, or until the trial under way has ended when None."""

    seconds: float | None = None


NAMED_KEYS = ("enter", "escape", "tab", "space", "backspace", "up", "down", "left", "right", "ctrl+c")


def read_keys(script: str) -> list[Press | Wait]:
    """Return the keys of a script such as `g kitchen<enter> <wait> k q`.

    Blanks only separate. Every character is a key; `<enter>`, `<space>` and the other `NAMED_KEYS` are keys by
    name; `<wait>` waits until the trial under way has ended, `<wait:2>` waits two seconds.

    Raises:
        TwonavError: A name in angle brackets is unknown or a bracket is not closed.
    """
    keys: list[Press | Wait] = []
    for token in re.findall(r"<[^>\s]*>?|\S", script):
        name = token[1:-1].lower()
        if len(token) == 1 and token != "<":
            keys.append(Press(token))
        elif re.fullmatch(r"wait(:\d+(\.\d+)?)?", name):
            keys.append(Wait(float(name[5:]) if len(name) > 4 else None))
        elif token.endswith(">") and name in NAMED_KEYS:
            keys.append(Press(name))
        else:
            raise unknown_name("key", token, [f"<{key}>" for key in (*NAMED_KEYS, "wait", "wait:2")])
    return keys
