"""Actions per second of the 2D simulator against the 3D one, and its control periods against ir-sim's steps.

    python benchmarks/bench_2d.py [rounds]

All sides take turns in one process and are timed by its CPU time. The agent drives the same trials in both stages; 3D
looks through its camera and asks the localizer at every action. ir-sim (`pip install ir-sim`) takes part where it is
installed: one robot with 180 beams cut at half a metre between eleven boxes, without drawing.
"""

from __future__ import annotations

import copy
import importlib.util
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from twonav_cli.events import Clock, to_nobody
from twonav_cli.experiments.predecessors import load_agent, load_localize, make_stage
from twonav_cli.experiments.trials import run_trial
from twonav_cli.geometry import Twist
from twonav_cli.learner.agent import Agent
from twonav_cli.mapping.floor import read_floor
from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage
from twonav_cli.stages.sim3d_stage import Sim3dOptions
from twonav_cli.stages.stage import Stage

FLAT_ACTIONS, FLAT_STEPS, DEEP_ACTIONS, IR_STEPS = 1000, 3000, 80, 300
TICK_S = 0.1

IR_WORLD = """
world: {height: 9, width: 14, step_time: 0.1, collision_mode: 'unobstructed'}
robot:
  kinematics: {name: 'diff'}
  shape: {name: 'rectangle', length: 0.5, width: 0.38}
  state: [1.5, 1.5, 0]
  goal: [13, 8, 0]
  behavior: {name: 'dash'}
  sensors:
    - {type: 'lidar2d', range_min: 0, range_max: 0.5, angle_range: 3.14159, number: 180}
obstacle:
  - number: 11
    distribution: {name: 'random', range_low: [2, 2, -3.14], range_high: [13, 8, 3.14]}
    shape:
      - {name: 'rectangle', length: 1.0, width: 0.6}
"""


def actions_per_s(stage: Stage, agent: Agent, actions: int, seed: int) -> tuple[float, int]:
    """Return how many actions of exploring trials are done per second of CPU time, and how many there were."""
    agent, rng = copy.deepcopy(agent), np.random.default_rng(seed)
    starts, taken, trial = list(stage.maze.starts.values()), 0, 0
    begun_s = time.process_time()
    while taken < actions:
        goal, start = trial % len(agent.goal_names), starts[trial % len(starts)]
        taken += run_trial(stage, agent, goal, start, rng, Clock(trial, taken), to_nobody, True, True).steps
        trial += 1
    return taken / (time.process_time() - begun_s), taken


def steps_per_s(stage: Sim2dStage) -> float:
    """Return how many single steps of motion, collision check and range finder are done per second of CPU time."""
    body, turn = stage.body, Twist(0.1, 0.0, 0.5)
    begun_s = time.process_time()
    for _ in range(FLAT_STEPS):
        body.drive(turn, TICK_S)
        body.scan()
    return FLAT_STEPS / (time.process_time() - begun_s)


def ir_sim() -> Callable[[], float] | None:
    """Return what measures steps per second of ir-sim; None where it is not installed."""
    if importlib.util.find_spec("irsim") is None:
        return None
    import irsim

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "world.yaml"
        path.write_text(IR_WORLD)
        world = irsim.make(str(path), display=False)

    def measure() -> float:
        begun_s = time.process_time()
        for _ in range(IR_STEPS):
            world.step()
        return IR_STEPS / (time.process_time() - begun_s)

    return measure


def main() -> None:
    """Print the figures and their ratios."""
    rounds = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    floor = read_floor("apartment")
    agent, theirs = load_agent(floor, "3d"), ir_sim()
    for base in ("omni", "differential"):
        flat = Sim2dStage(floor, 0, Sim2dOptions(base=base))
        deep = make_stage(floor, "3d", load_localize(floor), 0, Sim3dOptions(base=base))
        actions_per_s(flat, agent, 50, 0), actions_per_s(deep, agent, 20, 0)
        figures = []
        for seed in range(rounds):
            begun_s, (ended, taken) = flat.time_s, actions_per_s(flat, agent, FLAT_ACTIONS, seed)
            periods = (flat.time_s - begun_s) / TICK_S / taken
            camera, _ = actions_per_s(deep, agent, DEEP_ACTIONS, seed)
            figures.append((ended, camera, periods, steps_per_s(flat), theirs() if theirs else np.nan))
        flat_s, deep_s, periods, alone, ir_s = np.median(figures, axis=0)
        ratios = [row[0] / row[1] for row in figures]
        print(
            f"{base}: 2D {flat_s:,.0f} actions/s, 3D by camera {deep_s:,.0f}; ratio {np.median(ratios):.1f} "
            f"({min(ratios):.1f} to {max(ratios):.1f}, {rounds} rounds)"
        )
        if theirs is not None:
            print(
                f"{base}: a step of motion and range finder, one by one from Python {alone:,.0f}/s, "
                f"with the controller in a compiled action {flat_s * periods:,.0f}/s; ir-sim {ir_s:,.0f}/s; "
                f"ratios {alone / ir_s:.1f} and {flat_s * periods / ir_s:.1f}"
            )
        deep.close()
    if theirs is None:
        print("ir-sim is not installed: pip install ir-sim to compare with it")


if __name__ == "__main__":
    main()
