"""A made-up apartment and a made-up run in it: what the play screen's tests show. Run it to look at the screen."""

from __future__ import annotations

import math
import queue
import sys
import threading
import time
from collections.abc import Iterator

import numpy as np

from twonav_cli.belief import Belief
from twonav_cli.events import (
    Clock,
    Event,
    GoalAdded,
    GoalChosen,
    GoalLearned,
    Kidnapped,
    Note,
    QSnapshot,
    RunEnded,
    RunStarted,
    Sink,
    StepTaken,
    Tick,
    TrialEnded,
    TrialStarted,
)
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.maze import OFFSETS, Maze
from twonav_cli.terminal.commands import AddGoal, Command, GoTo, Kidnap, Move, Quit

FRAME = GridFrame(-2.4, -0.1, 0.05, 192, 376)
MAZE_FRAME = FRAME.coarser(0.4)
GOALS = {
    "kitchen": Cell(4, 5),
    "bathroom": Cell(4, 18),
    "study": Cell(4, 29),
    "bedroom": Cell(5, 42),
    "sofa": Cell(18, 8),
    "table": Cell(19, 18),
    "balcony": Cell(20, 30),
    "wardrobe": Cell(19, 42),
    "hall": Cell(12, 23),
    "front-door": Cell(11, 3),
}


def fake_maze() -> Maze:
    """Eight rooms above and below a corridor, 24 x 47 cells."""
    blocked = np.zeros((24, 47), dtype=bool)
    blocked[[0, -1], :] = blocked[:, [0, -1]] = True
    blocked[[9, 14], :] = True
    for col in (12, 24, 35):
        blocked[:9, col] = blocked[15:, col] = True
    for col in (6, 18, 30, 41):
        blocked[9, col : col + 2] = blocked[14, col : col + 2] = False
    blocked[2:4, 8:11] = blocked[17:20, 4:6] = blocked[5:7, 38:40] = blocked[20:22, 20:22] = True
    return Maze(blocked, dict(GOALS), {"hall": Cell(12, 23)})


def fake_map(maze: Maze) -> np.ndarray:
    """The maze as a 5 cm map, [192, 376]."""
    occupied = np.zeros(FRAME.shape, dtype=bool)
    for row, col in np.argwhere(maze.blocked):
        thin_row, thin_col = row in (0, 9, 14, 23), col in (0, 12, 24, 35, 46)
        rows = slice(8 * row + 3, 8 * row + 6) if thin_row and not thin_col else slice(8 * row, 8 * row + 8)
        cols = slice(8 * col + 3, 8 * col + 6) if thin_col and not thin_row else slice(8 * col, 8 * col + 8)
        occupied[rows, cols] = True
    return occupied


def fake_q(maze: Maze) -> np.ndarray:
    """Values [G, R, C, A] that are exact for a discount of 0.95."""
    q = np.full((len(maze.goals), maze.rows, maze.cols, 4), -2.0)
    for index, goal in enumerate(maze.goals.values()):
        distance = maze.distances_to(goal)
        for cell in maze.free_cells:
            for action in range(4):
                after = maze.moved(cell, action)
                q[index, cell.row, cell.col, action] = 100 * 0.95 ** int(distance[after]) - 2 * (after == cell)
    return q


def fake_image(pose: Pose) -> np.ndarray:
    """A horizon, a floor and a door that move with the heading, [84, 84, 3]."""
    rows, cols = np.mgrid[0:84, 0:84]
    angle = pose.theta_rad + (42 - cols) / 84
    wall = 0.5 + 0.3 * np.sin(7 * angle) + 0.1 * np.sin(40 * angle)
    image = np.stack([200 * wall, 180 * wall, 120 + 60 * wall], axis=-1)
    floor = rows > 50
    image[floor] = np.stack([90 + rows, 60 + rows // 2, 40 + 0 * rows], axis=-1)[floor] * 0.8
    door = (np.abs(np.sin(2 * angle + pose.x_m)) < 0.2) & (rows > 15) & (rows < 58)
    image[door] = (160, 60, 40)
    return np.clip(image, 0, 255).astype(np.uint8)


def fake_belief(*places: tuple[float, float, float], lost: float = 0.1) -> Belief:
    """What a picture says: weight, x_m, y_m of every place, likeliest first; each fills 5 x 5 bins of 0.27 m."""
    frame = GridFrame(-0.3, -0.2, 0.27, 37, 54)
    grid = np.zeros(frame.shape, dtype=np.float32)
    for weight, x_m, y_m in places:
        row, col = frame.cell_at(x_m, y_m)
        grid[row - 2 : row + 3, col - 2 : col + 3] += 0.03 * weight
        grid[row, col] += 0.25 * weight
    rows = np.array([(*place, 0.1) for place in places])
    return Belief(rows, np.array([(1.0, 0.0, 0.1)]), lost, 60.0, grid, frame)


class FakeGame:
    """Walks the shortest way to every goal that is asked for; `pause_s` is the time between ticks."""

    def __init__(self, pause_s: float = 0.0, stage: str = "3d") -> None:
        self.stage = stage
        self.maze = fake_maze()
        self.q = fake_q(self.maze)
        self.cell = Cell(12, 23)
        self.clock = Clock()
        self.pause_s = pause_s
        self.asked: list[Command] = []

    def began(self) -> list[Event]:
        started = RunStarted(
            self.clock, "play", self.stage, "apartment", 1, {}, self.maze, MAZE_FRAME, fake_map(self.maze), FRAME
        )
        return [started, QSnapshot(self.clock, self.q)]

    def walk(self, goal: str) -> Iterator[Event]:
        """Yield the events of one trial."""
        index = self.maze.goal_names.index(goal)
        start, shortest = self.cell, int(self.maze.distances_to(self.maze.goals[goal])[self.cell])
        self.clock = Clock(self.clock.trial + 1, self.clock.step, self.clock.time_s)
        yield GoalChosen(self.clock, goal, "the player asked for it", np.linspace(0, 9, len(self.maze.goals)))
        yield TrialStarted(self.clock, goal, start, self.pose(0))
        steps = 0
        while self.cell != self.maze.goals[goal]:
            action = int(self.q[index, self.cell.row, self.cell.col].argmax())
            yield from self.step(goal, index, action)
            steps += 1
        yield TrialEnded(self.clock, goal, start, "reached", steps, shortest)
        yield GoalLearned(self.clock, goal)

    def step(self, goal: str, index: int, action: int) -> Iterator[Event]:
        """Yield the ticks and the end of one action."""
        before, after = self.cell, self.maze.moved(self.cell, action)
        for part in range(1, 5):
            self.clock = Clock(self.clock.trial, self.clock.step, self.clock.time_s + 0.2)
            pose = self.pose(action, before, after, part / 4)
            scan = np.minimum(0.35 + 0.2 * np.sin(np.arange(180) / 20) ** 2, 0.5)
            yield Tick(self.clock, pose, off(pose, 0.2), scan, None, fake_image(pose))
        self.cell = after
        self.clock = Clock(self.clock.trial, self.clock.step + 1, self.clock.time_s)
        td = 40 * np.abs(np.sin(np.arange(len(self.maze.goals)) + self.clock.step)) ** 8
        pose = self.pose(action)
        outcome = "reached" if after != before else "blocked"
        values = self.q[index, before.row, before.col]
        yield StepTaken(
            self.clock, goal, before, action, after, outcome, values, td, True, after, pose, off(pose, 0.06),
            belief=fake_belief((0.7, *off(pose, 0.06)[:2]), (0.3, 11.0, 8.0)),
        )  # fmt: skip

    def pose(self, action: int, before: Cell | None = None, after: Cell | None = None, share: float = 1.0) -> Pose:
        ends = [np.array(MAZE_FRAME.centre_of(cell)) for cell in (before or self.cell, after or self.cell)]
        x_m, y_m = (1 - share) * ends[0] + share * ends[1]
        return Pose(float(x_m), float(y_m), math.atan2(-OFFSETS[action][0], OFFSETS[action][1]))

    def play(self, sink: Sink, commands: queue.Queue[Command], stop: threading.Event) -> int:
        """Do what the commands ask until Quit; the exit code is 7, so that it is told from every other."""
        for event in self.began():
            sink(event)
        while not stop.is_set():
            try:
                command = commands.get(timeout=0.02)
            except queue.Empty:
                continue
            self.asked.append(command)
            for event in self.answer(command):
                sink(event)
                if isinstance(event, Tick):
                    time.sleep(self.pause_s)
                if stop.is_set():
                    break
            if isinstance(command, Quit):
                break
        sink(RunEnded(self.clock, "left"))
        return 7

    def answer(self, command: Command) -> Iterator[Event]:
        match command:
            case GoTo(goal):
                yield from self.walk(goal)
            case AddGoal(name, x_m, y_m):
                cell = self.cell if x_m is None or y_m is None else MAZE_FRAME.cell_at(x_m, y_m)
                self.maze = self.maze.with_goal(name, cell)
                self.q = fake_q(self.maze)
                yield GoalAdded(self.clock, name, cell)
                yield QSnapshot(self.clock, self.q)
                yield Note(self.clock, "INFO", f"{name}: learned in 1.3 ms, no step taken")
            case Kidnap():
                before = self.pose(0)
                self.cell = Cell(19, 40)
                yield Kidnapped(self.clock, before, self.pose(0))
            case Move(action):
                yield from self.step("kitchen", 0, action)
            case other:
                yield Note(self.clock, "INFO", f"asked: {other}")


def off(pose: Pose, by_m: float) -> Pose:
    """A believed pose that is wrong by some metres."""
    return Pose(pose.x_m + by_m, pose.y_m - by_m / 2, pose.theta_rad + by_m)


if __name__ == "__main__":
    from twonav_cli.terminal.screen.play_screen import run_screen

    game = FakeGame(pause_s=0.05)
    code = run_screen(game.play, "twonav: apartment, 3d", keys=sys.argv[1] if len(sys.argv) > 1 else None)
    print(f"exit code {code}")
