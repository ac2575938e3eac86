"""A new goal from remembered experience, beside learning the same goal from scratch, both sides in one run.

    python benchmarks/bench_add_goal.py [goals]

The agent is the one that is shipped for the apartment's maze; the goals are random free cells. `add_goal` is timed
whole (its tables grow too), and both sides are compiled before the clock runs. From scratch means a fresh agent with
this one goal and the settings of the shipped one, the compiled loop, and the paper's criterion: 50 successes from each
start.
"""

from __future__ import annotations

import copy
import sys
import time
from typing import NamedTuple

import numpy as np

from twonav_cli.events import to_nobody
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.experiments.predecessors import load_agent
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import read_floor
from twonav_cli.maze import Maze

ROUNDS = 20
"""Times that each goal is added."""


class Cost(NamedTuple):
    """What one goal cost on either side, and whether the first one's ways are shortest."""

    added_ms: float
    scratch_ms: float
    scratch_steps: int
    shortest: bool


def added_ms(agent: Agent, cell: Cell) -> float:
    """Return the median time to add a goal."""
    spent_s = []
    for _ in range(ROUNDS):
        copied = copy.deepcopy(agent)
        begun_s = time.perf_counter()
        copied.add_goal(cell)
        spent_s.append(time.perf_counter() - begun_s)
    return 1e3 * float(np.median(spent_s))


def from_scratch(agent: Agent, maze: Maze, cell: Cell, seed: int) -> tuple[float, int]:
    """Return milliseconds and actions until a fresh agent has learned the goal."""
    alone = Maze(maze.blocked, {"goal": cell}, maze.starts)
    fresh = Agent.for_maze(alone, agent.config, seed)
    begun_s = time.perf_counter()
    steps = learn_maze(fresh, alone, seed, to_nobody, lambda: False).steps
    return 1e3 * (time.perf_counter() - begun_s), steps


def ways_are_shortest(agent: Agent, maze: Maze, cell: Cell) -> bool:
    """Return whether the greedy way to an added goal is a shortest one from every free cell."""
    agent = copy.deepcopy(agent)
    best = agent.greedy_actions(agent.add_goal(cell).index)
    distance = maze.distances_to(cell)
    return all(distance[maze.moved(c, int(best[c]))] == distance[c] - 1 for c in maze.free_cells if c != cell)


def main() -> None:
    """Print the table."""
    goals = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    floor = read_floor("apartment")
    agent, maze = load_agent(floor, "maze"), floor.maze
    cells = [maze.free_cells[i] for i in np.random.default_rng(0).choice(len(maze.free_cells), goals, replace=False)]
    added_ms(agent, cells[0]), from_scratch(agent, maze, cells[0], 0)
    costs = [
        Cost(added_ms(agent, cell), *from_scratch(agent, maze, cell, seed), ways_are_shortest(agent, maze, cell))
        for seed, cell in enumerate(cells)
    ]
    ratios = [cost.scratch_ms / cost.added_ms for cost in costs]
    print(
        f"add_goal: median {np.median([cost.added_ms for cost in costs]):.2f} ms, 0 steps, shortest ways from every "
        f"cell for {sum(cost.shortest for cost in costs)} of {goals} goals"
    )
    print(
        f"from scratch: median {np.median([cost.scratch_ms for cost in costs]):.0f} ms, "
        f"{np.median([cost.scratch_steps for cost in costs]):,.0f} steps"
    )
    print(f"from scratch takes {np.median(ratios):.0f} times as long ({min(ratios):.0f} to {max(ratios):.0f})")


if __name__ == "__main__":
    main()
