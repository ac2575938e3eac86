"""Actions per second in each stage, and what recording costs, both sides alternating in one run.

    python benchmarks/bench_actions.py [actions per round] [rounds]

Wall time (the recorder writes in a thread of its own), camera-only poses in 3D; while recording, the
controller is traced as in `play`.
"""

from __future__ import annotations

import copy
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from twonav_cli.events import Clock, RunStarted, Sink, to_nobody
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.experiments.predecessors import load_agent, load_localize, make_stage
from twonav_cli.experiments.trials import run_trial
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.recording.recorder import Recorder
from twonav_cli.stages.sim3d_stage import Sim3dOptions
from twonav_cli.stages.stage import Stage


def drive(stage: Stage, agent: Agent, sink: Sink, actions: int, seed: int) -> tuple[int, float]:
    """Run trials until `actions` are done, the same ones for the same seed; return the actions and the seconds."""
    agent, rng = copy.deepcopy(agent), np.random.default_rng(seed)
    starts, taken, trial = list(stage.maze.starts.values()), 0, 0
    begun_s = time.perf_counter()
    while taken < actions:
        goal = trial % len(agent.goal_names)
        clock = Clock(trial, taken, stage.time_s)
        taken += run_trial(stage, agent, goal, starts[trial % len(starts)], rng, clock, sink, True, True).steps
        trial += 1
    return taken, time.perf_counter() - begun_s


def learning_in_maze(floor: Floor) -> float:
    """Return the actions per second of the compiled loop, learning ten goals."""
    from twonav_cli.config import learning_preset

    learn_maze(Agent.for_maze(floor.maze, learning_preset("maze")), floor.maze, 0, to_nobody, lambda: False)
    begun_s, steps = time.perf_counter(), 0
    for seed in range(5):
        agent = Agent.for_maze(floor.maze, learning_preset("maze"), seed)
        steps += learn_maze(agent, floor.maze, seed, to_nobody, lambda: False).steps
    return steps / (time.perf_counter() - begun_s)


def main() -> None:
    """Print the table."""
    given = [int(argument) for argument in sys.argv[1:3]]
    actions, rounds = (*given, *(60, 5)[len(given) :])
    floor = read_floor("apartment")
    print(f"maze, compiled learning loop: {learning_in_maze(floor):,.0f} actions/s")
    taken, spent_s = drive(make_stage(floor, "maze", None, 0), load_agent(floor, "maze"), to_nobody, 2000, 0)
    print(f"maze, through the stage protocol: {taken / spent_s:,.0f} actions/s")
    agent, localize = load_agent(floor, "3d"), load_localize(floor)
    plain = make_stage(floor, "3d", localize, 0, Sim3dOptions())
    traced = make_stage(floor, "3d", localize, 0, Sim3dOptions(trace=True))
    begun = RunStarted(
        Clock(), "play", "3d", "apartment", 0, {}, floor.maze, floor.maze_frame, floor.map.occupied, floor.map.frame
    )
    drive(plain, agent, to_nobody, 20, 0)
    ratios, costs = [], []
    with tempfile.TemporaryDirectory() as folder, Recorder(Path(folder) / "bench.rrd", "3d") as recorder:
        recorder(begun)
        drive(traced, agent, recorder, 20, 0)
        for seed in range(rounds):
            bare_taken, bare_s = drive(plain, agent, to_nobody, actions, seed)
            taken, spent_s = drive(traced, agent, recorder, actions, seed)
            costs.append((bare_taken / bare_s, taken / spent_s))
            ratios.append(costs[-1][0] / costs[-1][1] - 1)
    bare, recorded = np.median(costs, axis=0)
    print(f"3d, camera only: {bare:.1f} actions/s; with recording {recorded:.1f} actions/s")
    print(
        f"recording costs {np.median(ratios):.1%} (median of {rounds} rounds; {min(ratios):.1%} to {max(ratios):.1%})"
    )


if __name__ == "__main__":
    main()
