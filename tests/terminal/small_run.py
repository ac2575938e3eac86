"""A small maze and a learning run in it: what the tests of watching look at."""

from __future__ import annotations

import numpy as np

from twonav_cli.config import LearningConfig
from twonav_cli.events import Clock, RunStarted, Sink, to_nobody
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Maze
from twonav_cli.terminal.screen.watch_state import WatchState, advance, first_state
from twonav_cli.terminal.screen.watch_walk import Walk

CONFIG = LearningConfig(consecutive_successes=5)
GOALS = {"sofa": Cell(4, 0), "bed": Cell(0, 5), "desk": Cell(2, 2)}
STARTS = {"s1": Cell(0, 0), "s2": Cell(4, 5)}


def small_maze() -> Maze:
    blocked = np.zeros((5, 6), dtype=np.bool_)
    blocked[1, 1:5] = blocked[3, 0:3] = True
    return Maze(blocked, dict(GOALS), dict(STARTS))


def small_run(maze: Maze | None = None) -> RunStarted:
    return RunStarted(Clock(), "train", "maze", "cabin", 0, {}, maze or small_maze())


def small_walk(config: LearningConfig = CONFIG, seed: int = 0, sink: Sink = to_nobody) -> Walk:
    maze = small_maze()
    return Walk(Agent.for_maze(maze, config, seed), maze, seed, sink)


def after(walk: Walk, actions: int, state: WatchState | None = None) -> WatchState:
    """Return what the screen would know after so many actions, taken one by one."""
    state = state or first_state(small_run(), walk.agent)
    for _ in range(actions):
        for event in walk.take(1):
            state = advance(state, event)
    return state
