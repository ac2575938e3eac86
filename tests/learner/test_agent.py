"""The agent: its tables, and what survives being saved."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.checkpoint import ARRAYS_FILE, CARD_FILE, load_checkpoint, save_checkpoint, signed
from twonav_cli.config import LearningConfig
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import COLDEST, Agent
from twonav_cli.maze import Maze

CARD = {"scene": "test", "scene_digest": "s1", "map_digest": "m1", "command": "test", "seed": 7, "metrics": {}}


@pytest.fixture
def maze() -> Maze:
    blocked = np.zeros((2, 3), dtype=np.bool_)
    blocked[1, 1] = True
    return Maze(blocked, {"right": Cell(0, 2), "low": Cell(1, 0)}, {"corner": Cell(0, 0)})


@pytest.fixture
def agent(maze: Maze) -> Agent:
    config = LearningConfig(learning_rate=0.5, discount=0.5, initial_q=80.0, initial_td_error=1e4)
    return Agent.for_maze(maze, config)


def test_one_action_teaches_every_goal_its_own_lesson(agent: Agent) -> None:
    errors = agent.observe(Cell(0, 1), 3, Cell(0, 2), blocked=False)
    # right: target 100; low: target -0.1 + 0.5 * 80 = 39.9
    assert np.allclose(errors, [20.0**2, 40.1**2])
    assert np.allclose(agent.q[0, 1, 3], [90.0, 80 - 0.5 * 40.1])
    assert np.allclose(agent.td[0, 1, 3], errors)
    assert np.count_nonzero(agent.q != 80.0) == 2


def test_looking_at_the_td_errors_learns_nothing(agent: Agent) -> None:
    before = agent.q.copy()
    assert np.allclose(agent.td_errors(Cell(0, 0), 0, Cell(0, 0), blocked=True), [42.0**2, 42.0**2])
    assert (agent.q == before).all()
    assert len(agent.replay) == 0


def test_the_td_error_of_a_goal_is_the_mean_over_free_entries(agent: Agent) -> None:
    assert np.allclose(agent.td_error_of_goals(), 1e4)
    agent.td[0, 0, 0] = [1e4 - 20 * 7.0, 1e4]  # 5 free cells x 4 actions
    agent.td[1, 1] = 1e9  # a blocked cell does not count
    assert np.allclose(agent.td_error_of_goals(), [1e4 - 7.0, 1e4])


def test_the_buffer_is_swept_when_the_period_is_over(maze: Maze) -> None:
    agent = Agent.for_maze(maze, LearningConfig(learning_rate=1.0, discount=0.5, replay_period_steps=2))
    agent.observe(Cell(0, 0), 3, Cell(0, 1), blocked=False)
    assert np.isclose(agent.q[0, 0, 3, 0], -0.1 + 40.0)
    agent.observe(Cell(0, 1), 3, Cell(0, 2), blocked=False)
    assert np.isclose(agent.q[0, 0, 3, 0], -0.1 + 0.5 * 100.0)
    assert (agent.sweeps, agent.steps_since_sweep) == (1, 0)


def test_greedy_choices_follow_the_goal_and_say_so(agent: Agent) -> None:
    agent.q[0, 1, 3, 0] = 95.0
    agent.q[0, 1, 2, 1] = 96.0
    rng = np.random.default_rng(0)
    assert agent.choose(Cell(0, 1), 0, rng, explore=False) == (3, True)
    assert agent.choose(Cell(0, 1), 1, rng, explore=False) == (2, True)
    assert agent.greedy_actions(0)[0, 1] == 3
    assert agent.greedy_actions(1)[0, 1] == 2
    assert agent.greedy_actions(0).shape == (2, 3)
    agent.temperature = 1e3
    greedy = [agent.choose(Cell(0, 1), 0, rng)[1] for _ in range(200)]
    assert 0 < sum(greedy) < 200


def test_the_table_has_the_goals_first(agent: Agent) -> None:
    agent.q[1, 2, 3, 0] = 5.0
    assert agent.table().shape == (2, 2, 3, 4)
    assert agent.table()[0, 1, 2, 3] == 5.0
    assert agent.values(Cell(1, 2), 0).tolist() == [80.0, 80.0, 80.0, 5.0]


def test_the_temperature_decays_but_never_to_zero(agent: Agent) -> None:
    agent.end_trial()
    assert agent.temperature == 2.0 * 0.998
    agent.temperature = COLDEST
    agent.end_trial()
    assert agent.temperature == COLDEST


def test_a_new_goal_starts_warm_and_unconfirmed(agent: Agent) -> None:
    agent.end_trial()
    agent.progress.consecutive[:] = 3
    agent.begin_goal(1)
    assert agent.temperature == 2.0
    assert agent.progress.goal == 1
    assert agent.progress.consecutive.tolist() == [0]


@pytest.mark.parametrize(
    "wrong",
    [
        {"discount": 1.0},
        {"discount": -0.1},
        {"discount": float("nan")},
        {"temperature": 0.0},
        {"learning_rate": 0.0},
        {"learning_rate": 1.1},
        {"replay_learning_rate": 0.0},
        {"epsilon": 1.5},
        {"replay_period_steps": 0},
        {"exploration": "greedy"},
        {"goal_selection": "best"},
    ],
)
def test_settings_out_of_range_are_refused_by_name(maze: Maze, wrong: dict[str, object]) -> None:
    with pytest.raises(TwonavError, match=next(iter(wrong)).replace("_", " ")):
        Agent.for_maze(maze, replace(LearningConfig(), **wrong))


def test_an_agent_without_goals_is_refused() -> None:
    with pytest.raises(TwonavError, match="no goal"):
        Agent(np.ones((2, 2), dtype=np.bool_), {}, 1, LearningConfig())


def test_an_agent_says_when_a_maze_is_not_its_own(agent: Agent, maze: Maze) -> None:
    agent.check_fits(maze)
    with pytest.raises(TwonavError, match="2 x 3 cells"):
        agent.check_fits(Maze(np.zeros((3, 3), dtype=np.bool_), maze.goals, maze.starts))
    with pytest.raises(TwonavError, match="other goals"):
        agent.check_fits(Maze(maze.blocked, {"right": Cell(0, 2)}, maze.starts))
    with pytest.raises(TwonavError, match="starts"):
        agent.check_fits(Maze(maze.blocked, maze.goals, {}))


def experienced(agent: Agent) -> Agent:
    agent.observe(Cell(0, 1), 3, Cell(0, 2), blocked=False)
    agent.observe(Cell(0, 0), 0, Cell(0, 0), blocked=True)
    agent.end_trial()
    agent.progress.trial, agent.progress.explore_state = 1, 2**63 - 3
    return agent


def test_a_saved_agent_comes_back_whole(agent: Agent, tmp_path: Path) -> None:
    experienced(agent).save(tmp_path, CARD)
    again = Agent.load(tmp_path, "s1", "m1")
    for name in ("q", "td", "free"):
        assert np.array_equal(getattr(again, name), getattr(agent, name))
    assert again.config == agent.config
    assert (again.goal_names, again.goal_cells) == (agent.goal_names, agent.goal_cells)
    assert again.replay.counts == agent.replay.counts
    assert again.temperature == agent.temperature
    assert again.steps_since_sweep == 2
    assert again.progress.explore_state == 2**63 - 3


def test_settings_of_another_stage_keep_the_values_and_begin_a_new_run(agent: Agent, tmp_path: Path) -> None:
    experienced(agent).save(tmp_path, CARD)
    config = LearningConfig(learning_rate=0.8, consecutive_successes=2)
    again = Agent.load(tmp_path, config=config)
    assert np.array_equal(again.q, agent.q)
    assert again.config == config
    assert len(again.replay) == again.progress.trial == 0
    assert again.progress.window.shape == (1, 2)


def test_a_flipped_bit_is_refused(agent: Agent, tmp_path: Path) -> None:
    agent.save(tmp_path, CARD)
    content = bytearray((tmp_path / ARRAYS_FILE).read_bytes())
    content[-5] ^= 1
    (tmp_path / ARRAYS_FILE).write_bytes(content)
    with pytest.raises(TwonavError, match="damaged"):
        Agent.load(tmp_path)


def test_an_agent_of_another_scene_or_map_is_refused(agent: Agent, tmp_path: Path) -> None:
    agent.save(tmp_path, CARD)
    with pytest.raises(TwonavError, match="another scene"):
        Agent.load(tmp_path, "s2", "m1")
    with pytest.raises(TwonavError, match="another map"):
        Agent.load(tmp_path, "s1", "m2")


@pytest.mark.parametrize("name", ["q", "td"])
def test_a_table_of_the_wrong_shape_is_refused(agent: Agent, tmp_path: Path, name: str) -> None:
    agent.save(tmp_path, CARD)
    arrays, card = load_checkpoint(tmp_path, "agent")
    arrays[name] = arrays[name][:, :2]
    save_checkpoint(tmp_path, arrays, card)
    with pytest.raises(TwonavError, match="shape"):
        Agent.load(tmp_path)


def test_a_table_with_a_value_that_is_no_number_is_neither_saved_nor_read(agent: Agent, tmp_path: Path) -> None:
    agent.save(tmp_path, CARD)
    arrays, card = load_checkpoint(tmp_path, "agent")
    arrays["q"] = np.full_like(arrays["q"], np.nan)
    save_checkpoint(tmp_path, arrays, card)
    with pytest.raises(TwonavError, match="not a number"):
        Agent.load(tmp_path)
    agent.q[0, 0, 0, 0] = np.nan
    with pytest.raises(TwonavError, match="not saved"):
        agent.save(tmp_path / "other", CARD)
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize(
    ("key", "value"),
    [("goals", None), ("goals", [["right", 1, 1], ["low", 1, 0]]), ("settings", {"gamma": 1}), ("progress", {"x": 1})],
)
def test_a_card_that_does_not_describe_the_agent_is_refused(
    agent: Agent, tmp_path: Path, key: str, value: object
) -> None:
    agent.save(tmp_path, CARD)
    card = json.loads((tmp_path / CARD_FILE).read_text())
    (tmp_path / CARD_FILE).write_text(json.dumps(signed({**card, key: value})))
    with pytest.raises(TwonavError, match="incomplete"):
        Agent.load(tmp_path)


def test_the_td_table_tells_what_was_never_tried_from_what_was_right(agent: Agent) -> None:
    before = agent.td_table()
    assert before.shape == agent.table().shape
    assert np.isnan(before[:, agent.free]).all()
    cell = Cell(*(int(index) for index in np.argwhere(agent.free)[0]))
    errors = agent.observe(cell, 1, cell, blocked=True)
    after = agent.td_table()
    assert np.array_equal(after[:, cell.row, cell.col, 1], errors)
    assert np.isnan(after).sum() == np.isnan(before).sum() - len(errors)


def test_the_temperature_starts_anew_at_each_goal_unless_it_cools_once() -> None:
    for cooling, learner, expected in (("per-goal", "multi", 2.0), ("once", "multi", 0.5), ("once", "single", 2.0)):
        config = LearningConfig(cooling=cooling, learner=learner)
        agent = Agent(np.ones((2, 2), dtype=np.bool_), {"g": Cell(0, 0)}, 1, config)
        agent.temperature = 0.5
        agent.begin_goal(0)
        assert agent.temperature == expected
