"""When an episode in which a robot drives ends, what it earns and tells: in a stage that says what it is told."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from gymnasium.error import ResetNeeded

from twonav_cli.environments.stage_env import StageEnv
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Sink
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.navigation.outcomes import BLOCKED, REACHED, TIMED_OUT
from twonav_cli.stages.stage import ActionResult, Observation

GOAL = Cell(3, 7)
"""The stove of the kitchen; (4, 7) and (3, 6) are free, (2, 7) is not."""

BEFORE, ASIDE, WALL = Cell(4, 7), Cell(3, 6), Cell(2, 7)


class ToldStage:
    """Does nothing, and says what it was told to say: outcome, believed cell, true cell."""

    def __init__(self) -> None:
        self.next: tuple[str, Cell, Cell] = (REACHED, BEFORE, BEFORE)
        self.time_s, self.collisions, self.closed = 100.0, 7, 0
        self.refuses = False
        self.drawn_from: list[np.random.Generator] = []

    def draw_from(self, rng: np.random.Generator) -> None:
        self.drawn_from.append(rng)

    def place(self, cell: Cell) -> Observation:
        if self.refuses:
            raise TwonavError("the robot does not fit")
        return Observation(cell, cell, Pose(0.0, 0.0, 0.0))

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        outcome, believed, true = self.next
        self.time_s, self.collisions = self.time_s + 0.3, self.collisions + (outcome == BLOCKED)
        return ActionResult(outcome, Observation(believed, true, Pose(1.0, 2.0, 0.5)))

    def close(self) -> None:
        self.closed += 1


class ToldEnv(StageEnv):
    """The kitchen, in a stage that is told what to say."""

    def __init__(self, render_mode: str | None = None, goal: Any = "stove") -> None:
        super().__init__("kitchen", goal, "omni", None, render_mode)
        self.opened: list[Any] = []

    def _opened(self) -> Any:
        self.opened.append(ToldStage())
        return self.opened[-1]


def begun(**settings: Any) -> tuple[ToldEnv, ToldStage]:
    """Return an environment whose robot was put one cell below the goal, and its stage."""
    env = ToldEnv(**settings)
    env.reset(seed=0, options={"start": BEFORE, "goal": "stove"})
    return env, env.opened[0]


@pytest.mark.parametrize(
    ("outcome", "believed", "true", "reward", "terminated", "blocked", "false_arrival"),
    [
        (REACHED, GOAL, GOAL, 100.0, True, False, False),
        (BLOCKED, GOAL, GOAL, 100.0, True, True, False),
        (REACHED, ASIDE, ASIDE, -0.1, False, False, False),
        (REACHED, BEFORE, BEFORE, -2.0, False, True, False),
        (BLOCKED, ASIDE, ASIDE, -2.0, False, True, False),
        (TIMED_OUT, ASIDE, ASIDE, -2.0, False, True, False),
        (REACHED, GOAL, ASIDE, -2.0, True, False, True),
        (REACHED, GOAL, WALL, -2.0, True, False, True),
        (REACHED, ASIDE, GOAL, -0.1, False, False, False),
    ],
)
def test_belief_ends_an_episode_and_truth_rewards_it(
    outcome: str, believed: Cell, true: Cell, reward: float, terminated: bool, blocked: bool, false_arrival: bool
) -> None:
    env, stage = begun()
    stage.next = outcome, believed, true
    observation, *earned, truncated, info = env.step(0)
    assert earned == [reward, terminated]
    assert not truncated
    assert observation == believed.row * env.maze.cols + believed.col
    assert (info["blocked"], info["false_arrival"], info["outcome"]) == (blocked, false_arrival, outcome)
    assert (info["cell"], info["cell_true"]) == (tuple(believed), tuple(true))


def test_the_shortest_way_is_counted_from_where_the_robot_truly_is() -> None:
    env, stage = begun()
    for true, length in ((BEFORE, 1), (GOAL, 0), (WALL, 0), (Cell(5, 7), 2)):
        stage.next = REACHED, ASIDE, true
        assert env.step(0)[-1]["shortest_way"] == length


def test_time_and_collisions_are_those_of_the_episode() -> None:
    env, stage = begun()
    stage.next = BLOCKED, BEFORE, BEFORE
    told = [(info["time_s"], info["collisions"]) for info in (env.step(0)[-1] for _ in range(3))]
    assert told == [(0.3, 1), (0.6, 2), (0.9, 3)]
    _, info = env.reset()
    assert (info["time_s"], info["collisions"], info["outcome"], info["pose"]) == (0.0, 0, None, (0.0, 0.0, 0.0))


def test_everything_random_is_drawn_from_the_environments_own_stream() -> None:
    env, stage = begun()
    env.reset(seed=4)
    env.reset()
    assert stage.drawn_from[-2] is stage.drawn_from[-1] is env.np_random


def test_drawn_goals_are_named_beside_the_cell() -> None:
    env = ToldEnv(goal=None)
    observation, info = env.reset(seed=0, options={"start": BEFORE, "goal": "shelf"})
    assert observation.tolist() == [4 * env.maze.cols + 7, 4]
    assert info["goal"] == "shelf"


def test_the_stage_is_opened_by_the_first_reset_and_closed_once() -> None:
    env = ToldEnv()
    env.close()
    assert env.opened == []
    for _ in range(2):
        env.reset()
    for _ in range(2):
        env.close()
    assert [stage.closed for stage in env.opened] == [1]
    env.reset()
    assert len(env.opened) == 2


def test_a_start_that_the_stage_refuses_leaves_goal_and_robot_as_they_were() -> None:
    env, stage = begun()
    stage.refuses = True
    with pytest.raises(TwonavError, match="does not fit"):
        env.reset(options={"goal": "shelf"})
    stage.next = REACHED, GOAL, GOAL
    assert env.step(0)[1:3] == (100.0, True)


def test_an_environment_that_was_not_reset_or_is_closed_says_so() -> None:
    env = ToldEnv(render_mode="ansi")
    for attempt in (lambda: env.step(0), env.render):
        with pytest.raises(ResetNeeded):
            attempt()
    env.reset()
    env.close()
    for attempt in (lambda: env.step(0), env.render):
        with pytest.raises(ResetNeeded):
            attempt()


def test_a_picture_shows_the_robot_where_it_truly_is() -> None:
    env, stage = begun(render_mode="ansi")
    stage.next = REACHED, ASIDE, BEFORE
    env.step(0)
    rows = env.render().splitlines()
    assert (rows[4][7], rows[3][7], rows[3][6]) == ("@", "G", ".")
    picture, _ = begun(render_mode="rgb_array")
    assert picture.render().shape == (360, 480, 3)


@pytest.mark.parametrize("action", [-1, 4, None])
def test_an_action_that_there_is_not_is_refused_before_anything_moves(action: Any) -> None:
    env, stage = begun()
    with pytest.raises(TwonavError, match="there is no action"):
        env.step(action)
    assert stage.time_s == 100.0
