"""A maze with obstacles strewn over it, and how long an agent's ways through it are."""

import numpy as np

from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Maze, filled_where_unreachable


def scattered_maze(size: int, seed: int) -> Maze:
    rng = np.random.default_rng(seed)
    blocked = rng.random((size, size)) < 0.2
    blocked[0, 0] = False
    blocked = filled_where_unreachable(blocked, Cell(0, 0))
    free = [Cell(int(r), int(c)) for r, c in np.argwhere(~blocked)]
    picked = [free[i] for i in rng.permutation(len(free))[:8]]
    goals = {f"goal {i}": cell for i, cell in enumerate(picked[:4])}
    return Maze(blocked, goals, {f"start {i}": cell for i, cell in enumerate(picked[4:])})


def greedy_lengths(agent: Agent, maze: Maze) -> list[int]:
    """Length of the greedy path for every goal and start, 999 where it never arrives."""
    lengths = []
    for goal, goal_cell in enumerate(agent.goal_cells):
        actions = agent.greedy_actions(goal)
        for cell in maze.starts.values():
            steps = 0
            while cell != goal_cell and steps < 999:
                cell, steps = maze.moved(cell, int(actions[cell])), steps + 1
            lengths.append(steps)
    return lengths


def shortest_lengths(maze: Maze) -> list[int]:
    return [int(maze.distances_to(goal)[start]) for goal in maze.goals.values() for start in maze.starts.values()]
