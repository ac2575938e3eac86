"""A goal that a person adds on the way: where it lies, and what the agent learns of it at once."""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import Maze

if TYPE_CHECKING:  # the screen needs the wish before anything slow is loaded
    from twonav_cli.learner.agent import Agent


@dataclass(frozen=True)
class GoalWish:
    """A goal that is to be added."""

    name: str
    place_m: tuple[float, float] | None = None
    """(x, y) in the map frame; None for where the robot believes to be."""


def cell_at_place(maze: Maze, frame: GridFrame, x_m: float, y_m: float) -> Cell:
    """Return the free cell at a place in the map frame, metres.

    Raises:
        TwonavError: It is outside the map, or on no free floor; then the message says where the nearest free cell is.
    """
    if not frame.contains(x_m, y_m):
        raise TwonavError(
            f"({x_m:g}, {y_m:g}) m is outside the map: choose x from {frame.x_min_m:.1f} to {frame.x_max_m:.1f} "
            f"and y from {frame.y_min_m:.1f} to {frame.y_max_m:.1f}"
        )
    cell = frame.cell_at(x_m, y_m)
    if maze.blocked[cell]:
        centres = np.array([frame.centre_of(free) for free in maze.free_cells])
        near_x_m, near_y_m = centres[np.hypot(*(centres - (x_m, y_m)).T).argmin()]
        raise TwonavError(
            f"the robot cannot stand at ({x_m:g}, {y_m:g}) m: the nearest free cell is at "
            f"({near_x_m:.2f}, {near_y_m:.2f})"
        )
    return cell


def add_goal(agent: Agent, maze: Maze, frame: GridFrame, wish: GoalWish, believed: Cell) -> tuple[Maze, str]:
    """Add a goal to an agent, which learns it from what it remembers.

    Args:
        agent: Changed in place.
        maze: The agent's.
        frame: Where the maze lies.
        wish: What the person wants.
        believed: Where the robot believes to be.

    Returns:
        The maze with the goal, and a sentence about what it cost.

    Raises:
        TwonavError: The name is taken or odd, or nobody can stand in that place.
    """
    from twonav_cli.learner.relabel import compile_now

    cell = believed if wish.place_m is None else cell_at_place(maze, frame, *wish.place_m)
    compile_now()
    begun_s = time.thread_time()  # the screen draws in a thread of its own meanwhile
    added = agent.add_goal(cell, wish.name)
    spent_ms = 1e3 * (time.thread_time() - begun_s)
    # What a narrow screen cuts off comes last.
    sentence = (
        f"{added.name}: learned in {spent_ms:.1f} ms, no step taken; {len(added.without_way)} of "
        f"{int(agent.free.sum())} cells without a known way; from {added.remembered:,} remembered actions"
    )
    return maze.with_goal(added.name, cell), sentence
