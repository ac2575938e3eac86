"""Actions per second in the maze while ten goals are learned from every action, against loops that others write.

    python benchmarks/bench_maze.py [rounds]

One core, CPU time, all sides taking turns in one run, medians. The bar is 10 million actions/s and 200 times the
FrozenLake loop; the goal is 25 million. twonav and the floors do the same: a random maze, ten goals for 500 trials each
(50 from every start), the temperature starting anew with every goal, preset paper-maze; no goal meets the criterion.
The floors keep no TD errors and record nothing.
"""

from __future__ import annotations

import random
import sys
import time
from collections.abc import Callable

import gymnasium
import numpy as np
from maze_floor import TRIALS_PER_GOAL, floor_of

from twonav_cli.config import LearningConfig, learning_preset
from twonav_cli.environments.registration import EPISODE_STEPS_AT_MOST
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.maze_loop import MazeLoop
from twonav_cli.maze import Maze
from twonav_cli.random_maze import random_maze

NEVER = 10**9
TRIALS = 20_000
TUTORIAL_STEPS = 30_000
Work = Callable[[], tuple[int, int]]
"""Does a share of the work and returns the actions taken and the trials begun."""


def twonav_loop(maze: Maze, config: LearningConfig, trials: int = TRIALS) -> Work:
    """Return the work of the compiled loop of this project."""
    agent = Agent.for_maze(maze, config)
    loop = MazeLoop(agent, maze, 0, TRIALS_PER_GOAL)

    def work() -> tuple[int, int]:
        steps = 0
        for turn in range(trials // TRIALS_PER_GOAL):
            agent.begin_goal(turn % len(maze.goals))
            rows, learned = loop.run()
            assert not learned
            steps += int(rows.steps.sum())
        return steps, trials

    work()  # compiles
    return work


def floor(maze: Maze, config: LearningConfig) -> Work:
    """Return the work of a bare numba loop."""
    run_trials = floor_of(maze, config)

    def work() -> tuple[int, int]:
        return run_trials(TRIALS), TRIALS

    work()  # compiles
    return work


def tutorial(env: gymnasium.Env[int, int], epsilon: float = 0.1, rate: float = 0.1, discount: float = 0.99) -> Work:
    """Return the work of Q-learning for one goal, written as tutorials do it: a Python loop over step().

    As fast as such a loop gets: lists, several times faster here than NumPy, and no wrappers around the environment.
    """
    env, rng = env.unwrapped, random.Random(0)
    q = [[0.0] * 4 for _ in range(env.observation_space.n)]
    env.reset(seed=0)

    def work() -> tuple[int, int]:
        taken = episodes = 0
        while taken < TUTORIAL_STEPS:
            state, done, left = env.reset()[0], False, EPISODE_STEPS_AT_MOST
            episodes += 1
            while not done and left > 0:
                values = q[state]
                action = rng.randrange(4) if rng.random() < epsilon else one_of_the_largest(values, rng)
                state, reward, done, _, _ = env.step(action)
                target = reward + (0.0 if done else discount * max(q[state]))
                values[action] += rate * (target - values[action])
                left, taken = left - 1, taken + 1
        return taken, episodes

    work()  # until it has found the goal
    return work


def one_of_the_largest(values: list[float], rng: random.Random) -> int:
    """Return an action of largest value, ties broken at random."""
    best = max(values)
    if values.count(best) == 1:
        return values.index(best)
    return rng.choice([action for action, value in enumerate(values) if value == best])


def rate_of(work: Work) -> tuple[float, float]:
    """Return actions per CPU second, and actions per trial."""
    begun_s = time.process_time()
    steps, trials = work()
    return steps / (time.process_time() - begun_s), steps / trials


def contestants() -> dict[str, Work]:
    """Return every side by name."""
    maze = random_maze(0, 0)
    # One success in a row more than a goal's 500 trials have from each start: it never counts as learned.
    never_learned = TRIALS_PER_GOAL // len(maze.starts) + 1
    swept = learning_preset("paper-maze", consecutive_successes=never_learned)
    plain = learning_preset("paper-maze", consecutive_successes=never_learned, replay_period_steps=NEVER)
    greedy = learning_preset("paper-maze", exploration="epsilon-greedy")
    return {
        "twonav, ten goals, Boltzmann": twonav_loop(maze, plain),
        "twonav, the same with replay sweeps": twonav_loop(maze, swept),
        "numba floor, ten goals, Boltzmann": floor(maze, plain),
        "numba floor, ten goals, epsilon-greedy": floor(maze, greedy),
        "FrozenLake-v1, Python loop, one goal": tutorial(
            gymnasium.make("FrozenLake-v1", map_name="8x8", is_slippery=False)
        ),
        "twonav/Maze-v0, the same loop, one goal": tutorial(gymnasium.make("twonav/Maze-v0", maze="random")),
    }


def main() -> None:
    """Print the ratios and the table."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 7
    sides = contestants()
    measured = {name: [] for name in sides}
    for _ in range(rounds):
        for name, work in sides.items():
            measured[name].append(rate_of(work))
    rates = {name: np.array(pairs)[:, 0] for name, pairs in measured.items()}
    plain, swept, bare, _, lake, own = rates.values()
    print(f"twonav over the FrozenLake loop: {np.median(plain / lake):,.0f} (bar 200)")
    print(f"twonav over the numba floor: {np.median(plain / bare):.2f}; with sweeps {np.median(swept / bare):.2f}")
    print(f"twonav/Maze-v0 over FrozenLake-v1, same loop: {np.median(own / lake):.2f}")
    print(f"twonav: {np.median(plain) / 1e6:.1f} million actions/s (bar 10, goal 25)\n")
    for name, pairs in measured.items():
        each, length = np.median(pairs, axis=0)
        print(f"{name:40} {each:14,.0f} actions/s {1e9 / each:10,.1f} ns  {length:6.1f} actions per trial")
    print(f"\n{rounds} rounds, every side once in each; ratios are medians of the rounds' ratios")


if __name__ == "__main__":
    main()
