"""What one reads while an agent learns, as rich text: TD errors as bars, numbers, and the two lines at the bottom."""

from __future__ import annotations

import textwrap

import numpy as np
from rich.text import Text

from twonav_cli.learner.agent import Agent
from twonav_cli.learner.exploration import boltzmann_probabilities
from twonav_cli.maze import Action
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.floor_plan import goal_key
from twonav_cli.terminal.screen.game_view import ARROWS, QUIET, bar
from twonav_cli.terminal.screen.game_view import LEVELS as HEIGHTS
from twonav_cli.terminal.screen.palette import hexadecimal
from twonav_cli.terminal.screen.watch_drawing import LEVELS, Heat, scale_colour
from twonav_cli.terminal.screen.watch_keys import VISITS, WatchControls, speed_text
from twonav_cli.terminal.screen.watch_state import WatchState, called, number

AGENT = hexadecimal(palette.ESTIMATE)
KEY = hexadecimal(palette.TRUE)
BAR = hexadecimal((64, 150, 150))
DONE = hexadecimal(palette.CURRENT_GOAL)
LABEL_COLS = 9
SCALE_COLS = 6


def shown_goal(state: WatchState, controls: WatchControls) -> str:
    """Return the goal whose tables are shown: the one looked at, the current one, or the first."""
    names = state.goal_names
    return next((name for name in (controls.looked_at, state.goal, names[0]) if name in names), names[0])


def maze_titles(state: WatchState, controls: WatchControls, heat: Heat, cols: int, coloured: bool) -> tuple[str, str]:
    """Return what the colours of the maze mean: the title of its frame, and the scale below it, with markup."""
    title = "visits" if controls.heat == VISITS else f"{controls.heat} for {called(shown_goal(state, controls))}"
    untried = " · grey: untried" if coloured else " · blank: untried"
    if np.isnan(heat.low):
        return title, untried.removeprefix(" · ")
    low, high = number(heat.low), number(heat.high)
    colours = [hexadecimal(scale_colour(share)) for share in np.linspace(0, 1, SCALE_COLS).tolist()]
    blocks = "".join(f"[{colour}]█[/]" for colour in colours) if coloured else "".join(LEVELS)
    fits = len(low) + SCALE_COLS + len(high) + len(untried) + 2 <= cols
    return title, f"{low} {blocks} {high}" + untried * fits


def errors_text(state: WatchState, controls: WatchControls, cols: int, rows: int) -> Text:
    """Return the TD error of every goal as a bar beside its key and name; ▶ the current goal, ✓ the learned ones."""
    names, errors = state.goal_names, state.td_errors
    if errors is None:
        return Text("")
    current = names.index(state.goal) if state.goal in names else 0
    first = min(max(current - rows // 2, 0), max(len(names) - rows, 0))
    widest = min(max(len(called(name)) for name in names), max(cols - 18, 4))
    largest = max(float(errors.max()), 1e-300)
    lines = []
    for at, name in list(enumerate(names))[first : first + rows]:
        is_current = name == state.goal
        style = "bold" if is_current else "underline" if name == controls.looked_at else ""
        label = f"{goal_key(at) or '·'} {called(name)[:widest]:<{widest}} "
        figure = f"{number(float(errors[at])):>8}"
        room = max(cols - len(label) - len(figure) - 3, 0)
        line = Text("▶" if is_current else " ", style="bold").append(label, style)
        line.append("✓ " if name in state.learned else "  ", DONE)
        line.append(bar(float(errors[at]) / largest, room), AGENT if is_current else BAR)
        lines.append(line.append(figure, style or QUIET))
    return Text("\n", no_wrap=True).join(lines)


def numbers_text(state: WatchState, agent: Agent, cols: int, rows: int) -> Text:
    """Return the numbers as labelled lines, what matters most first, as many as fit."""
    room = max(cols - LABEL_COLS, 10)
    of = "1 trial" if len(state.recent) == 1 else f"the last {len(state.recent)} trials"
    happening = f"{sum(state.recent)} of {of}" if state.recent else "no trial has ended yet"
    learned = f"{len(state.learned)} of {len(state.goal_names)} goals in {state.clock.step:,} actions"
    lines = [
        ("goal", f"{called(state.goal)}: {state.why}" if state.goal else state.ended or "none chosen yet"),
        ("trial", trial_sentence(state)),
        ("success", f"{happening}; temperature {state.temperature:.3g}"),
        ("learned", f"{learned}; floor {state.floor_steps:,} (the proof alone)"),
        ("trend", trend(state, room)),
        ("next", next_action(state, agent)),
        ("so far", spent(state, agent)),
    ]
    text: list[Text] = []
    for label, value in lines:
        for at, part in enumerate(textwrap.wrap(value, room)):
            text.append(Text.assemble((("" if at else label).ljust(LABEL_COLS), QUIET), part))
    return Text("\n", no_wrap=True).join(text[:rows])


def spent(state: WatchState, agent: Agent) -> str:
    """Return the actions that each learned goal took, in the order of learning."""
    steps = dict(zip(agent.goal_names, agent.progress.steps_of_goal, strict=True))
    return ", ".join(f"{called(name)} {steps[name]:,}{' actions' * (at == 0)}" for at, name in enumerate(state.learned))


def trial_sentence(state: WatchState) -> str:
    """Return what the trial under way, or the last one, has come to."""
    last = state.last_trial
    if state.between and last is not None:
        outcome = f"reached {called(state.goal)} in" if last.reached else "gave up after"
        begun = f"{state.clock.trial:,} from {called(last.start, 'start')}"
        return f"{begun} {outcome} {_actions(last.steps)}, shortest way {last.shortest}"
    if state.start is None or state.goal not in state.maze.goals:
        return "none yet"
    shortest = int(state.maze.distances_to(state.maze.goals[state.goal])[state.start])
    begun = f"{state.clock.trial + 1:,} from {called(state.start_name, 'start')}"
    return f"{begun}: {_actions(state.steps_in_trial)}, shortest way {shortest}"


def trend(state: WatchState, cols: int) -> str:
    """Return the actions per trial of the current goal as a line of blocks, each as high as its logarithm.

    A block is the mean over one round or more, a trial from every start: the starts are not equally far away.
    """
    rounds = rounds_of(state)
    if not rounds:
        return "actions per trial, once one has ended"
    if len(rounds) == 1:
        return f"{rounds[0]:.0f} actions a trial in the first round"
    words = f" {rounds[0]:.0f} to {rounds[-1]:.0f} actions a trial"
    pieces = np.array_split(np.array(rounds), min(max(cols - len(words), 1), len(rounds)))
    heights = np.log([max(float(piece.mean()), 1.0) for piece in pieces])
    shares = (heights - heights.min()) / max(float(np.ptp(heights)), 1e-9)
    return "".join(HEIGHTS[int(share * (len(HEIGHTS) - 1))] for share in shares) + words


def rounds_of(state: WatchState) -> list[float]:
    """Return the mean actions per trial of every round at the current goal; an unfinished one only if it is alone."""
    size = len(state.maze.starts)
    whole = [state.curve[at : at + size] for at in range(0, len(state.curve) - size + 1, size)]
    return [sum(trials) / len(trials) for trials in whole or [state.curve] if trials]


def next_action(state: WatchState, agent: Agent) -> str:
    """Return how likely the agent takes each action next, empty where its values do not decide."""
    config = agent.config
    if state.goal not in agent.goal_names or state.cell is None or config.learner == "nearest-untried":
        return ""
    if state.cell == agent.goal_cells[agent.goal_names.index(state.goal)]:
        return "arrived"
    values = agent.values(state.cell, agent.goal_names.index(state.goal))
    if config.exploration == "boltzmann":
        chances = boltzmann_probabilities(values, agent.temperature)
    else:
        best = values == values.max()
        chances = config.epsilon / len(values) + (1 - config.epsilon) * best / best.sum()
    shown = "  ".join(f"{ARROWS[action]} {chances[action]:.0%}" for action in Action)
    return f"{shown}  how likely each action is"


def status_text(state: WatchState, controls: WatchControls, title: str, cols: int) -> Text:
    """Return the last line of the screen: how many goals are learned at the left; run and speed at the right."""
    left = Text(f" {headline(state)}", style="bold")
    right = [title, "ended" if state.ended else speed_text(controls)]
    while len(right) > 1 and len(left) + len(" · ".join(right)) + 3 > cols:
        right.pop(0)
    end = Text(" · ".join(right) + " ", style="bold" if controls.paused else "")
    return left.append(" " * max(cols - len(left) - len(end), 1)).append_text(end)


def headline(state: WatchState) -> str:
    """Return the one sentence with the number that counts."""
    learned, goals, steps = len(state.learned), len(state.goal_names), state.clock.step
    if state.ended == "learned":
        share = f", {steps / state.floor_steps:.2f} times the floor" if state.floor_steps else ""
        return f"all {goals} goals learned in {steps:,} actions{share}"
    if state.ended:
        return f"gave up after {steps:,} actions: {learned} of {goals} goals learned"
    return f"{learned} of {goals} goals learned"


def hint_text(state: WatchState, controls: WatchControls, cols: int) -> Text:
    """Return what the keys do now, as many of them as fit."""
    leave = [("?", "help"), ("q", "leave" if state.ended else "stop")]
    pairs = [("tab", "colours"), ("1-9", "goals")]
    if not state.ended:
        run = [("space", "go on" if controls.paused else "pause"), (".", "step"), ("+ -", "speed")]
        pairs = [*run, ("t", "trial"), ("g", "goal"), ("e", "end"), *pairs]
    while pairs and sum(len(key) + len(meaning) + 3 for key, meaning in pairs + leave) > cols:
        pairs.pop()
    text = Text(" ")
    for key, meaning in pairs + leave:
        text.append(key, f"bold {KEY}").append(f" {meaning}  ", QUIET)
    return text


def _actions(count: int) -> str:
    return f"{count} action" if count == 1 else f"{count} actions"
