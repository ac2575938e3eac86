"""A made-up run with every kind of event in its real size: for the recorder's tests and its benchmark.

The rooms, the poses and the Q-table mean nothing; how many there are and how large they are is what a run has.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from twonav_cli import events
from twonav_cli.belief import Belief
from twonav_cli.events import Clock, DriveTrace, Event
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import OFFSETS, Maze

MAP_FRAME = GridFrame(-2.4, -0.1, 0.05, 192, 376)
TICKS_PER_ACTION = 12
TICK_S = 0.1
CANDIDATES = 105
CANDIDATE_POSES = 12
COST_CELLS = 48
BELIEF_FRAME = GridFrame(-0.27, -0.37, 0.27, 37, 54)
PARTICLES = 100
GOALS = ("kitchen", "sofa", "bed", "desk", "bath", "hall", "balcony", "wardrobe", "table", "shelf")


def rooms() -> tuple[Maze, GridFrame, NDArray[np.bool_]]:
    """Return a maze of 24 x 47 cells with ten goals, its frame, and a 5 cm map [192, 376] of the same walls."""
    frame = MAP_FRAME.coarser(0.40)
    blocked = np.zeros(frame.shape, dtype=np.bool_)
    blocked[[0, -1]] = blocked[:, [0, -1]] = True
    blocked[11, :] = True
    for col in (12, 23, 35):
        blocked[:, col] = True
    for row, col in ((5, 12), (17, 12), (6, 23), (18, 23), (4, 35), (16, 35), (11, 6), (11, 29), (11, 41)):
        blocked[max(row - 1, 1) : row + 1, col : col + 2] = False
        blocked[row, col] = False
    occupied = np.ones(MAP_FRAME.shape, dtype=np.bool_)
    wide = np.kron(blocked, np.ones((8, 8), dtype=np.bool_))[: MAP_FRAME.rows, : MAP_FRAME.cols]
    occupied[: wide.shape[0], : wide.shape[1]] = wide
    cells = [(3, 4), (8, 9), (3, 18), (9, 27), (2, 40), (20, 4), (14, 18), (21, 28), (20, 44), (8, 33)]
    goals = {name: Cell(*cell) for name, cell in zip(GOALS, cells, strict=True)}
    return Maze(blocked, goals, {"door": Cell(20, 10), "window": Cell(3, 30)}), frame, occupied


def q_table(maze: Maze, share: float) -> NDArray[np.float64]:
    """Return a table [G, R, C, A] of which a share of the cells is learned; the rest has its initial value."""
    table = np.full((len(maze.goals), maze.rows, maze.cols, 4), 80.0)
    for index, goal in enumerate(maze.goals.values()):
        distance = maze.distances_to(goal)
        reach = distance.max() * share
        for action in range(4):
            for cell in maze.free_cells:
                if distance[cell] <= reach:
                    table[index, cell.row, cell.col, action] = 100 * 0.95 ** distance[maze.moved(cell, action)]
    return table


def td_table(q: NDArray[np.float64], rng: np.random.Generator) -> NDArray[np.float64]:
    """Return TD errors [G, R, C, A] of a table: a random one where it is learned, else not a number."""
    return np.where(q == 80.0, np.nan, 10.0 ** rng.uniform(-2.0, 3.0, q.shape))


def shortest_way(maze: Maze, start: Cell, goal: Cell) -> list[int]:
    """Return the actions of a shortest way."""
    distance, cell, way = maze.distances_to(goal), start, []
    while cell != goal:
        action = min(range(4), key=lambda a: int(distance[maze.moved(cell, a)]))
        cell = maze.moved(cell, action)
        way.append(action)
    return way


def trace(pose: Pose, rng: np.random.Generator) -> DriveTrace:
    """Return what a controller weighs: arcs from the pose, their costs, a cost map of 2.4 x 2.4 m."""
    turns = np.linspace(-2.0, 2.0, CANDIDATES)[:, None]
    along = np.linspace(0.05, 0.6, CANDIDATE_POSES)[None]
    angle = pose.theta_rad + turns * along
    path = np.stack([pose.x_m + along * np.cos(angle), pose.y_m + along * np.sin(angle)], axis=-1)
    costs = (np.abs(turns[:, 0]) + rng.random(CANDIDATES)).astype(np.float32)
    costs[:8] = np.inf
    half = COST_CELLS // 2 * 0.05
    frame = GridFrame(pose.x_m - half, pose.y_m - half, 0.05, COST_CELLS, COST_CELLS)
    xs, ys = frame.centres()
    wall = np.abs(xs - pose.x_m - 0.9)[None, :] + 0 * ys[:, None]
    return DriveTrace(
        path.astype(np.float32), costs, int(costs.argmin()), np.clip(1 - wall / 0.5, 0, 1).astype(np.float32), frame
    )


def picture(pose: Pose) -> NDArray[np.uint8]:
    """Return a camera image [84, 84, 3] of floor, wall and a few boxes that turn with the robot."""
    image = np.empty((84, 84, 3), dtype=np.uint8)
    image[:46] = (205, 200, 190)
    image[46:] = (140, 110, 80)
    for index in range(5):
        left = int((index * 31 + math.degrees(pose.theta_rad) * 1.5 + pose.x_m * 20) % 110) - 20
        colour = ((index * 60) % 255, 90 + index * 30, 200 - index * 35)
        image[30 + index * 3 : 58, max(left, 0) : max(left + 15, 0)] = colour
    return image


def belief_about(pose: Pose, share: float) -> Belief:
    """Return what a picture says that fits a pose and, with the rest of the probability, one two metres to the left."""
    xs, ys = BELIEF_FRAME.centres()
    places = np.array([(share, pose.x_m, pose.y_m, 0.08), (1.0 - share, pose.x_m - 2.0, pose.y_m, 0.2)])
    grid = sum(
        weight * np.exp(-((xs[None] - x_m) ** 2 + (ys[:, None] - y_m) ** 2) / (2 * (sigma_m + 0.1) ** 2))
        for weight, x_m, y_m, sigma_m in places
    )
    grid = (grid / max(float(np.sum(grid)), 1e-12)).astype(np.float32)
    return Belief(places, np.array([(1.0, pose.theta_rad, 0.03)]), 0.02, 60.0, grid, BELIEF_FRAME)


def filtered_about(pose: Pose, rng: np.random.Generator) -> events.Filtered:
    """Return what a filter makes of it: particles about the pose, and one other place."""
    particles = (np.array(pose) + rng.normal(0, 0.08, (PARTICLES, 3))).astype(np.float32)
    return events.Filtered(0.9, 0.11, 0.08, particles, np.array([(0.08, pose.x_m - 2.0, pose.y_m)]))


def started(seed: int = 0, stage: str = "3d") -> events.RunStarted:
    """Return the first event of a run."""
    maze, frame, occupied = rooms()
    settings = {"localizer": "inception-9", "exploration": "epsilon-greedy", "learning rate": "0.8"}
    return events.RunStarted(Clock(), "play", stage, "apartment", seed, settings, maze, frame, occupied, MAP_FRAME)


def driven_trial(
    trial: int, clock: Clock, rng: np.random.Generator, outcome: str = "reached", cause: str = ""
) -> Iterator[Event]:
    """Yield the events of one trial in the 3D stage; the last one is TrialEnded."""
    maze, frame, _ = rooms()
    goal = GOALS[trial % len(GOALS)]
    start = list(maze.starts.values())[trial % 2]
    errors = np.abs(rng.normal(0, 1, len(GOALS))) * 10.0 ** (2 - trial / 8)
    errors[trial % len(GOALS)] = errors.max() * 2
    now = Clock(trial, clock.step, clock.time_s)
    yield events.GoalChosen(now, goal, "largest TD error of the goals not learned yet", errors)
    at = Pose(*frame.centre_of(start), 0.0)
    yield events.TrialStarted(now, goal, start, at)
    way = shortest_way(maze, start, maze.goals[goal])
    way = way if outcome == "reached" else way[: max(2, len(way) * 2 // 3)]
    believed, cell = at, start
    for count, action in enumerate(way):
        drift = 0.05 if cause != "mislocalized" or count < len(way) // 2 else 0.9
        nearest = Pose(*frame.centre_of(maze.moved(cell, action)), math.atan2(-OFFSETS[action][0], OFFSETS[action][1]))
        for tick in range(TICKS_PER_ACTION):
            part = (tick + 1) / TICKS_PER_ACTION
            centre = frame.centre_of(cell)
            x_m, y_m = (centre[i] + part * (nearest[i] - centre[i]) for i in (0, 1))
            at = Pose(x_m, y_m, nearest.theta_rad)
            off = rng.normal(0, 0.01, 3) + np.array((drift * part, drift * 0.6 * part, drift * 0.2))
            believed = Pose(at.x_m + off[0], at.y_m + off[1], at.theta_rad + off[2])
            now = Clock(trial, now.step, now.time_s + TICK_S)
            scan = np.minimum(0.3 + np.abs(np.sin(np.linspace(0, 9, 180) + at.x_m)), 0.5)
            yield events.Tick(now, at, believed, scan, trace(believed, rng))
        now = Clock(trial, now.step + 1, now.time_s)
        before, cell = cell, maze.moved(cell, action)
        seen = frame.cell_at(believed.x_m, believed.y_m)
        yield events.StepTaken(
            now, goal, before, action, seen, "reached", rng.random(4) * 20 + 60, np.abs(errors), True, cell, at,
            believed, picture(at), belief_about(at, 0.8), filtered_about(believed, rng),
        )  # fmt: skip
    shortest = int(maze.distances_to(maze.goals[goal])[start])
    evidence = f"the estimate was {drift:.2f} m off for the last {len(way) // 2} actions" if cause else ""
    yield events.TrialEnded(now, goal, start, outcome, len(way), shortest, cause, evidence, at, believed)


def driven_run(trials: int, seed: int = 0) -> Iterator[Event]:
    """Yield a run of several trials in the 3D stage; every fourth one fails."""
    rng = np.random.default_rng(seed)
    yield started(seed)
    maze, _, _ = rooms()
    clock = Clock()
    for trial in range(1, trials + 1):
        if trial % 5 == 1:
            q = q_table(maze, trial / (trials + 1))
            yield events.QSnapshot(Clock(trial, clock.step, clock.time_s), q, td_table(q, rng))
        bad = trial % 4 == 3
        outcome, cause = (
            (("false-arrival", "mislocalized") if trial % 8 == 3 else ("time-out", "loop")) if bad else ("reached", "")
        )
        for event in driven_trial(trial, clock, rng, outcome, cause):
            clock = event.clock
            yield event
    yield events.RunEnded(clock, "all trials done")


def compiled_batches(trials: int, rng: np.random.Generator, per_batch: int = 500) -> Iterator[events.TrialBatch]:
    """Yield the batches of a compiled run in the maze."""
    maze, _, _ = rooms()
    step = 0
    for first in range(0, trials, per_batch):
        count = min(per_batch, trials - first)
        index = np.arange(first, first + count)
        progress = np.exp(-index / (trials / 6))
        shortest = rng.integers(8, 50, count)
        steps = np.minimum((shortest * (1 + 12 * progress * rng.random(count))).astype(np.int64), 500)
        last_step = step + np.cumsum(steps)
        step = int(last_step[-1])
        yield events.TrialBatch(
            Clock(first + count, step),
            goal=index % len(maze.goals),
            start=index % len(maze.starts),
            steps=steps,
            reached=steps < 500,
            shortest=shortest,
            td_errors=np.abs(rng.normal(0, 1, (count, len(maze.goals)))) * 1e3 * progress[:, None] ** 2,
            last_step=last_step,
        )
