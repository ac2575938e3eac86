"""A new goal for an agent that has experience, and what still works afterwards."""

from __future__ import annotations

import copy
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.config import LearningConfig, learning_preset
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import NAME_LETTERS, Agent
from twonav_cli.learner.maze_loop import MazeLoop
from twonav_cli.maze import Action, Maze
from twonav_cli.paths import checkpoints_dir

CARD = {"scene": "test", "scene_digest": "s1", "map_digest": "m1", "command": "test", "seed": 7, "metrics": {}}
BLOCKED = np.array([[False, False, False], [False, True, False], [False, False, False]])
MAZE = Maze(BLOCKED, {"right": Cell(0, 2), "low": Cell(2, 0)}, {"corner": Cell(0, 0)})
NEW = Cell(2, 2)


@pytest.fixture
def agent() -> Agent:
    """Return an agent that tried every action of the upper row once."""
    agent = Agent.for_maze(MAZE, LearningConfig(initial_td_error=1e4))
    for col in range(3):
        for action in Action:
            cell = Cell(0, col)
            after = MAZE.moved(cell, action)
            agent.observe(cell, action, after, after == cell)
    return agent


@pytest.fixture(scope="module")
def trained() -> Agent:
    """Return the agent that is shipped for the apartment's maze."""
    return Agent.load(checkpoints_dir() / "apartment" / "maze")


def test_a_goal_is_added_at_the_end_of_every_table(agent: Agent) -> None:
    before = agent.table()
    added = agent.add_goal(Cell(0, 1), "middle")
    assert (added.index, added.name, added.remembered) == (2, "middle", 12)
    assert (agent.goal_names[2], agent.goal_cells[2]) == ("middle", Cell(0, 1))
    assert agent.q.shape == agent.td.shape == (3, 3, 4, 3)
    assert np.array_equal(agent.table()[:2], before)
    assert agent.q[0, 0, Action.RIGHT, 2] == 100.0
    assert agent.progress.learned.tolist() == [False] * 3
    assert agent.progress.trials_of_goal == agent.progress.steps_of_goal == [0, 0, 0]


def test_it_says_where_no_way_is_known_and_what_was_never_tried(agent: Agent) -> None:
    added = agent.add_goal(Cell(0, 1))
    assert added.without_way == added.untried == (Cell(1, 0), Cell(1, 2), Cell(2, 0), Cell(2, 1), Cell(2, 2))


def test_its_td_error_is_zero_where_an_action_was_tried(agent: Agent) -> None:
    agent.add_goal(NEW)
    assert (agent.td[0, :, :, 2] == 0).all()
    assert (agent.td[1, 1, :, 2] == 0).all()
    assert (agent.td[2, :, :, 2] == 1e4).all()
    assert agent.td_error_of_goals()[2] == 1e4 * 5 / 8


def test_no_step_is_taken(agent: Agent) -> None:
    replay, progress = agent.replay.to_array(), copy.deepcopy(agent.progress)
    agent.add_goal(NEW)
    assert np.array_equal(agent.replay.to_array(), replay)
    now = agent.progress
    assert (now.step, now.trial, now.goal) == (progress.step, progress.trial, progress.goal)
    assert agent.steps_since_sweep == 12


def test_the_agent_acts_and_learns_on_with_it(agent: Agent) -> None:
    goal = agent.add_goal(NEW, "new").index
    assert agent.td_errors(Cell(1, 2), Action.DOWN, NEW, blocked=False).shape == (3,)
    errors = agent.observe(Cell(1, 2), Action.DOWN, NEW, blocked=False)
    assert errors[goal] == (100.0 - 80.0) ** 2
    assert agent.choose(Cell(1, 2), goal, np.random.default_rng(0), explore=False) == (Action.DOWN, True)


def test_the_compiled_loop_learns_it_from_then_on(agent: Agent) -> None:
    maze = MAZE.with_goal("new", NEW)
    agent.add_goal(NEW, "new")
    agent.check_fits(maze)
    agent.begin_goal(2)
    loop = MazeLoop(agent, maze, seed=0)
    for _ in range(5):
        rows, learned = loop.run()
    loop.close()
    assert learned
    assert rows.td_errors.shape[1] == 3
    assert rows.steps[-1] == 4
    assert agent.progress.trials_of_goal[2] > 0


def test_a_saved_agent_comes_back_with_it(agent: Agent, tmp_path: Path) -> None:
    agent.add_goal(NEW, "new")
    agent.save(tmp_path, CARD)
    again = Agent.load(tmp_path, "s1", "m1")
    assert again.goal_names == ["right", "low", "new"]
    assert again.goal_cells[2] == NEW
    assert np.array_equal(again.q, agent.q)
    assert np.array_equal(again.td, agent.td)
    assert again.progress.trials_of_goal == [0, 0, 0]
    assert again.add_goal(Cell(1, 0), "more").index == 3


def test_after_a_change_of_stage_the_experience_is_still_good_for_a_new_goal(agent: Agent, tmp_path: Path) -> None:
    agent.save(tmp_path, CARD)
    again = Agent.load(tmp_path, config=learning_preset("3d"))
    assert len(again.replay) == 0
    assert again.add_goal(Cell(0, 1)).remembered == 12
    agent.add_goal(Cell(0, 1))
    assert np.array_equal(again.q[..., 2], agent.q[..., 2])
    assert len(again.replay) == 0


def test_what_this_stage_has_shown_counts_instead_of_what_the_one_before_had(agent: Agent, tmp_path: Path) -> None:
    agent.save(tmp_path, CARD)
    again = Agent.load(tmp_path, config=learning_preset("3d"))
    again.observe(Cell(0, 0), Action.RIGHT, Cell(0, 0), blocked=True)
    assert Cell(0, 0) in again.add_goal(Cell(0, 1)).without_way
    again.earlier_here, again.earlier_elsewhere = again.earlier_elsewhere, again.earlier_here
    assert Cell(0, 0) not in again.add_goal(Cell(0, 1)).without_way


def test_goals_without_a_name_are_numbered_and_may_share_a_cell(agent: Agent) -> None:
    assert [agent.add_goal(Cell(0, 2)).name for _ in range(2)] == ["goal-3", "goal-4"]
    assert np.array_equal(agent.q[..., 2], agent.q[..., 3])


@pytest.mark.parametrize("cell", [Cell(1, 1), Cell(-1, 0), Cell(0, 3)])
def test_a_cell_where_nobody_can_be_is_refused(agent: Agent, cell: Cell) -> None:
    with pytest.raises(TwonavError, match="choose a free one"):
        agent.add_goal(cell, "new")
    assert agent.q.shape[3] == len(agent.goal_names) == 2


@pytest.mark.parametrize("name", ["", " ", "a\nb", "a/b", "-a", "a" * (NAME_LETTERS + 1), "[red]"])
def test_a_name_that_cannot_be_typed_or_shown_is_refused(agent: Agent, name: str) -> None:
    with pytest.raises(TwonavError, match="no name for a goal"):
        agent.add_goal(NEW, name)


def test_a_name_that_is_taken_is_refused_in_any_case(agent: Agent) -> None:
    with pytest.raises(TwonavError, match="already"):
        agent.add_goal(NEW, "Right")


def test_an_agent_without_experience_is_refused() -> None:
    with pytest.raises(TwonavError, match="experienced nothing"):
        Agent.for_maze(MAZE, LearningConfig()).add_goal(NEW)


def test_from_every_cell_of_the_apartment_the_greedy_way_to_any_new_goal_is_a_shortest_one(trained: Agent) -> None:
    agent = copy.deepcopy(trained)
    maze = Maze(~agent.free, {}, {})
    chosen = np.random.default_rng(5).choice(len(maze.free_cells), 20, replace=False)
    moved = np.array([[maze.moved(cell, action) for action in Action] for cell in maze.free_cells])  # (F, A, 2)
    rows, cols = np.array(maze.free_cells).T
    for cell in (maze.free_cells[i] for i in chosen):
        added = agent.add_goal(cell)
        assert added.without_way == added.untried == ()
        distance = maze.distances_to(cell)
        best = agent.greedy_actions(added.index)[rows, cols]
        after = moved[np.arange(len(rows)), best]
        nearer = distance[after[:, 0], after[:, 1]] == distance[rows, cols] - 1
        assert nearer[distance[rows, cols] > 0].all()


def test_a_goal_that_was_learned_by_trials_gets_the_values_it_has(trained: Agent) -> None:
    agent = copy.deepcopy(trained)
    again = agent.add_goal(agent.goal_cells[0], "again").index
    assert np.abs(agent.q[..., again] - agent.q[..., 0]).max() < 1e-6
