"""The compiled loop learns exactly what the agent learns action by action."""

from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.config import LearningConfig
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.draws import boltzmann, epsilon_greedy, first_state, gumbel_noise
from twonav_cli.learner.maze_loop import MazeLoop
from twonav_cli.maze import Maze


def small_maze() -> Maze:
    blocked = np.zeros((5, 6), dtype=np.bool_)
    blocked[1, 1:5] = blocked[3, 0:3] = True
    goals = {"a": Cell(4, 0), "b": Cell(0, 5), "c": Cell(2, 2)}
    return Maze(blocked, goals, {"s": Cell(0, 0), "t": Cell(4, 5)})


def learned_action_by_action(agent: Agent, maze: Maze, loop: MazeLoop, trials: int, seed: int) -> list[int]:
    """Do the loop's trials with `Agent.observe`, with the loop's own draws from the agent's table."""
    state, starts = np.array([first_state(seed)], dtype=np.uint64), list(maze.starts.values())
    goal, steps = agent.progress.goal, []
    tables = agent.q.reshape(-1, 4, len(maze.goals))
    for trial in range(trials):
        cell, taken = starts[trial % len(starts)], 0
        while cell != agent.goal_cells[goal] and taken < agent.config.trial_limit_steps:
            number = cell.row * maze.cols + cell.col
            if agent.config.exploration == "boltzmann":
                action = int(boltzmann(tables, number, goal, 1.0 / agent.temperature, gumbel_noise(), state))
            else:
                action = int(epsilon_greedy(tables, number, goal, agent.config.epsilon, state))
            next_cell = maze.moved(cell, action)
            agent.observe(cell, action, next_cell, blocked=next_cell == cell)
            cell, taken = next_cell, taken + 1
        agent.end_trial()
        steps.append(taken)
    return steps


@pytest.mark.parametrize("exploration", ["boltzmann", "epsilon-greedy"])
@pytest.mark.parametrize(("learning_rate", "sweep_rate"), [(1.0, None), (0.3, None), (0.8, 0.1)])
def test_the_loop_leaves_the_tables_that_observe_leaves(
    exploration: str, learning_rate: float, sweep_rate: float | None
) -> None:
    maze = small_maze()
    config = LearningConfig(
        learning_rate=learning_rate, exploration=exploration, replay_period_steps=37, trial_limit_steps=60,
        replay_learning_rate=sweep_rate,
    )  # fmt: skip
    fast, slow = Agent.for_maze(maze, config), Agent.for_maze(maze, config)
    fast.progress.begin_goal(1)
    slow.progress.begin_goal(1)
    loop = MazeLoop(fast, maze, seed=5, trials_per_call=12)
    rows, learned = loop.run()
    loop.close()
    steps = learned_action_by_action(slow, maze, loop, 12, seed=5)
    assert not learned
    assert sum(steps) > 3 * 37
    assert rows.steps.tolist() == steps
    assert np.allclose(fast.q, slow.q, rtol=1e-12, atol=1e-9)
    assert np.allclose(fast.td, slow.td, rtol=1e-9, atol=1e-6)
    assert fast.replay.counts == slow.replay.counts
    assert (fast.sweeps, fast.steps_since_sweep) == (slow.sweeps, slow.steps_since_sweep)
    assert fast.temperature == slow.temperature
    assert np.allclose(rows.td_errors[-1], slow.td_error_of_goals())


def test_without_sweeps_the_two_agree_bit_for_bit() -> None:
    maze, config = small_maze(), LearningConfig(replay_period_steps=10**9, trial_limit_steps=60)
    fast, slow = Agent.for_maze(maze, config), Agent.for_maze(maze, config)
    fast.progress.begin_goal(0)
    slow.progress.begin_goal(0)
    loop = MazeLoop(fast, maze, seed=5, trials_per_call=20)
    loop.run()
    learned_action_by_action(slow, maze, loop, 20, seed=5)
    assert np.array_equal(fast.q, slow.q)
    assert np.array_equal(fast.td, slow.td)


def test_starts_take_turns_and_a_goal_that_is_a_start_takes_no_action() -> None:
    maze = small_maze()
    maze = replace(maze, starts={**maze.starts, "on the goal": Cell(2, 2)})
    agent = Agent.for_maze(maze, LearningConfig())
    agent.progress.begin_goal(2)
    loop = MazeLoop(agent, maze, seed=0, trials_per_call=7)
    rows, _ = loop.run()
    assert rows.start.tolist() == [0, 1, 2, 0, 1, 2, 0]
    assert rows.steps[rows.start == 2].tolist() == [0, 0]
    assert rows.reached.all()
    assert loop.run()[0].start.tolist() == [1, 2, 0, 1, 2, 0, 1]


def test_a_trial_fails_at_its_limit() -> None:
    maze = small_maze()
    agent = Agent.for_maze(maze, LearningConfig(trial_limit_steps=3))
    agent.progress.begin_goal(0)
    rows, _ = MazeLoop(agent, maze, seed=0, trials_per_call=4).run()
    assert rows.steps.tolist() == [3, 3, 3, 3]
    assert not rows.reached.any()
    assert agent.progress.consecutive.tolist() == [0, 0]
