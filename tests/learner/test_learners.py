"""Every learner learns the maze, under one criterion; the explorers beat the paper's."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.config import LearningConfig
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent, checked
from twonav_cli.learner.goals import next_goal
from twonav_cli.learner.learners import LEARNERS, learner_settings
from twonav_cli.learner.maze_loop import STRATEGIES, MazeLoop, ways_of
from twonav_cli.learner.prioritized_sweeping import WORTH_A_BACKUP
from twonav_cli.maze import Action, Maze, distances_from
from twonav_cli.random_maze import random_maze
from twonav_cli.rng import stream

QUICK = {"consecutive_successes": 5}


def room() -> Maze:
    blocked = np.zeros((5, 6), dtype=np.bool_)
    blocked[1, 1:5] = blocked[3, 0:3] = True
    goals = {"a": Cell(4, 0), "b": Cell(0, 5), "c": Cell(2, 2)}
    return Maze(blocked, goals, {"s": Cell(0, 0), "t": Cell(4, 5)})


def learned(maze: Maze, config: LearningConfig, seed: int = 0, chunk: int | None = None) -> tuple[Agent, list[int]]:
    """Learn every goal; returns the agent and the actions of every trial."""
    agent, steps = Agent.for_maze(maze, config), []
    loop, progress = MazeLoop(agent, maze, seed), agent.progress
    while not progress.learned.all():
        assert progress.step < 2_000_000
        if progress.goal < 0:
            rng = stream(seed, "goals", int(progress.learned.sum()))
            rule = config.goal_selection
            agent.begin_goal(next_goal(rule, agent.td_error_of_goals(), progress.learned, rng))
        if chunk is None:
            rows, done = loop.run()
        else:
            advance = loop.advance(chunk)
            rows, done = advance.rows, advance.learned
        steps += rows.steps.tolist()
        if done:
            progress.finish_goal()
    loop.close()
    return agent, steps


def floor_of(maze: Maze, successes: int) -> int:
    pairs = [(start, goal) for start in maze.starts.values() for goal in maze.goals.values()]
    return successes * sum(int(maze.distances_to(goal)[start]) for start, goal in pairs)


def is_optimal_everywhere(agent: Agent, maze: Maze) -> bool:
    for goal, cell in enumerate(maze.goals.values()):
        far = maze.distances_to(cell)
        for here in maze.free_cells:
            onward = maze.moved(here, int(agent.q[(*here, slice(None), goal)].argmax()))
            if here != cell and far[onward] != far[here] - 1:
                return False
    return True


@pytest.mark.parametrize("name", LEARNERS)
def test_every_learner_meets_the_criterion_and_no_one_beats_the_floor(name: str) -> None:
    maze = random_maze(0, 0)
    agent, steps = learned(maze, learner_settings(name, **QUICK))
    assert agent.progress.learned.all()
    assert sum(steps) == agent.progress.step >= floor_of(maze, 5)


def test_the_oracle_takes_exactly_the_floor() -> None:
    maze = random_maze(0, 1)
    agent, steps = learned(maze, learner_settings("oracle", **QUICK))
    assert sum(steps) == floor_of(maze, 5)
    assert agent.progress.optimal_at == 0


def test_sharing_experience_and_exploring_well_each_save_most_of_what_learning_costs() -> None:
    maze = random_maze(0, 2)
    floor = floor_of(maze, 5)
    settings = {name: learner_settings(name, preset="maze", **QUICK) for name in LEARNERS}
    excess = {name: sum(learned(maze, settings[name])[1]) - floor for name in LEARNERS}
    assert excess["multi"] < excess["single"] / 2
    assert excess["oracle"] == 0
    for name in ("optimistic", "prioritized-sweeping", "nearest-untried"):
        assert 0 < excess[name] < excess["multi"] / 2


@pytest.mark.parametrize("name", ["optimistic", "prioritized-sweeping", "nearest-untried"])
def test_an_explorer_comes_to_walk_every_way_as_short_as_it_is(name: str) -> None:
    maze = random_maze(3, 0)
    agent, _ = learned(maze, learner_settings(name, **QUICK))
    assert 0 < agent.progress.optimal_at <= agent.progress.step


def test_the_nearest_untried_action_explores_the_maze_in_little_more_than_its_size() -> None:
    maze = random_maze(0, 3)
    agent, steps = learned(maze, learner_settings("nearest-untried", **QUICK))
    entries = 4 * len(maze.free_cells)
    assert len(agent.replay.counts) == entries
    assert steps[0] <= 1.6 * entries, "the first trial explores everything"
    assert agent.progress.optimal_at <= steps[0]
    assert is_optimal_everywhere(agent, maze)


def test_the_nearest_untried_action_never_passes_by_something_untried() -> None:
    maze = room()
    agent = Agent.for_maze(maze, learner_settings("nearest-untried"))
    agent.begin_goal(0)
    loop = MazeLoop(agent, maze, 0)
    for tried in range(1, 5):
        assert loop.advance(1).cell in (Cell(0, 0), Cell(0, 1), Cell(1, 0), Cell(2, 0), Cell(0, 2))
        assert (loop.visits() > 0).sum() == tried


@pytest.mark.parametrize("name", LEARNERS)
@pytest.mark.parametrize("chunk", [1, 7])
def test_advancing_by_single_actions_is_running_whole_trials(name: str, chunk: int) -> None:
    maze = room()
    config = learner_settings(name, consecutive_successes=3, replay_period_steps=23)
    whole, steps = learned(maze, config, seed=4)
    parts, steps_of_parts = learned(maze, config, seed=4, chunk=chunk)
    assert steps == steps_of_parts
    assert np.array_equal(whole.q, parts.q)
    assert np.array_equal(whole.td, parts.td)
    assert whole.replay.counts == parts.replay.counts
    assert whole.progress.optimal_at == parts.progress.optimal_at


def test_advance_says_where_the_agent_is() -> None:
    maze = room()
    agent = Agent.for_maze(maze, LearningConfig())
    agent.begin_goal(0)
    loop = MazeLoop(agent, maze, 0)
    before = Cell(0, 0)
    for taken in range(1, 6):
        advance = loop.advance(1)
        assert advance.steps_in_trial == taken
        assert loop.in_trial
        assert advance.cell in {maze.moved(before, action) for action in Action}
        before = advance.cell
    advance = loop.advance(100_000, trials=1)
    assert len(advance.rows.steps) == 1
    assert (advance.start, advance.cell, advance.steps_in_trial) == (Cell(4, 5), Cell(4, 5), 0)
    assert not loop.in_trial


def test_without_a_goal_the_loop_does_not_run() -> None:
    maze = room()
    with pytest.raises(TwonavError, match="no goal is chosen"):
        MazeLoop(Agent.for_maze(maze, LearningConfig()), maze, 0).run()


@pytest.mark.parametrize("exploration", ["boltzmann", "epsilon-greedy"])
def test_the_single_goal_learner_is_the_multi_goal_learner_with_one_goal_bit_for_bit(exploration: str) -> None:
    maze = room()
    config = LearningConfig(consecutive_successes=4, replay_period_steps=23, exploration=exploration)
    all_goals = replace(config, learner="single", goal_selection="sequential")
    agent = Agent.for_maze(maze, all_goals)
    loop = MazeLoop(agent, maze, seed=8)
    for goal, name in enumerate(maze.goals):
        alone = Agent.for_maze(replace(maze, goals={name: maze.goals[name]}), config)
        alone.progress.explore_state = int(loop.state[0])
        agent.begin_goal(goal)
        alone.begin_goal(0)
        lone_loop = MazeLoop(alone, replace(maze, goals={name: maze.goals[name]}), seed=99)
        rows, done = loop.run()
        lone_rows, lone_done = lone_loop.run()
        assert done
        assert lone_done
        assert rows.steps.tolist() == lone_rows.steps.tolist()
        assert np.array_equal(rows.td_errors[:, goal], lone_rows.td_errors[:, 0])
        assert np.array_equal(agent.q[..., goal], alone.q[..., 0])
        assert np.array_equal(agent.td[..., goal], alone.td[..., 0])
        agent.progress.finish_goal()


def test_the_single_goal_learner_leaves_the_other_goals_alone() -> None:
    maze = room()
    agent = Agent.for_maze(maze, LearningConfig(learner="single"))
    agent.begin_goal(1)
    MazeLoop(agent, maze, 0, trials_per_call=20).run()
    assert (agent.q[..., [0, 2]] == agent.config.initial_q).all()
    assert (agent.q[..., 1] != agent.config.initial_q).any()


def test_prioritized_sweeping_carries_a_reward_back_along_a_corridor_in_one_action() -> None:
    blocked = np.zeros((1, 6), dtype=np.bool_)
    maze = Maze(blocked, {"end": Cell(0, 5)}, {"s": Cell(0, 0)})
    config = learner_settings("prioritized-sweeping", discount=0.9, initial_q=0.0, exploration="epsilon-greedy")
    agent = Agent.for_maze(maze, replace(config, epsilon=1.0, trial_limit_steps=10_000))
    agent.begin_goal(0)
    loop = MazeLoop(agent, maze, 0)
    loop.advance(10_000, trials=1)
    right = agent.q[0, :5, Action.RIGHT, 0]
    expected = [100.0]
    for _ in range(4):
        expected.append(-0.1 + 0.9 * expected[-1])
    assert np.abs(right - expected[::-1]).max() < 10 * WORTH_A_BACKUP


def test_distances_are_those_of_a_breadth_first_search() -> None:
    maze = random_maze(1, 4)
    ways = ways_of(maze, MazeLoop(Agent.for_maze(maze, LearningConfig()), maze, 0).rules)
    for g, cell in enumerate(maze.goals.values()):
        assert np.array_equal(ways.distance[:, g].reshape(10, 10), distances_from(maze.blocked, cell))
        assert np.array_equal(
            ways.shortest[:, g], [distances_from(maze.blocked, cell)[s] for s in maze.starts.values()]
        )


def test_what_a_target_is_made_of_follows_the_rewards() -> None:
    maze = room()
    ways = ways_of(maze, MazeLoop(Agent.for_maze(maze, LearningConfig()), maze, 0).rules)
    goal, beside = 4 * 6 + 0, 4 * 6 + 1
    assert ways.next_cell[beside, Action.LEFT] == goal
    assert ways.reward[ways.reward_row[beside, Action.LEFT]].tolist() == [100.0, -0.1, -0.1]
    assert ways.discount[goal].tolist() == [0.0, 0.95, 0.95]
    assert ways.reward[ways.reward_row[goal, Action.LEFT]].tolist() == [-2.0, -2.0, -2.0]


def test_there_is_a_strategy_for_every_learner_and_a_wrong_name_lists_them() -> None:
    assert set(STRATEGIES) == set(LEARNERS)
    with pytest.raises(TwonavError, match="nearest-untried"):
        learner_settings("nearest-untired")
    with pytest.raises(TwonavError, match="optimistic"):
        checked(LearningConfig(learner="optimstic"))


def test_changes_win_over_a_learners_settings_and_those_over_the_presets() -> None:
    assert learner_settings("multi").discount == 0.99
    assert learner_settings("optimistic").discount == 0.95
    assert learner_settings("optimistic", discount=0.9).discount == 0.9


def interrupted(maze: Maze, config: LearningConfig, folder: Path, every: int) -> Agent:
    """Learn every goal, saved and loaded again every so many trials."""
    agent, seed = Agent.for_maze(maze, config), 4
    card = {"scene": "s", "scene_digest": "d", "map_digest": "m", "command": "c", "seed": seed, "metrics": {}}
    while not agent.progress.learned.all():
        assert agent.progress.step < 1_000_000
        if agent.progress.goal < 0:
            rng = stream(seed, "goals", int(agent.progress.learned.sum()))
            agent.begin_goal(next_goal(config.goal_selection, agent.td_error_of_goals(), agent.progress.learned, rng))
        loop = MazeLoop(agent, maze, seed, trials_per_call=every)
        if loop.run()[1]:
            agent.progress.finish_goal()
        loop.close()
        agent.save(folder, card)
        agent = Agent.load(folder)
    return agent


@pytest.mark.parametrize("name", LEARNERS)
@pytest.mark.parametrize("every", [1, 5])
def test_a_run_that_is_saved_and_taken_up_again_goes_on_as_if_unbroken(name: str, every: int, tmp_path: Path) -> None:
    maze = room()
    config = learner_settings(name, consecutive_successes=3, replay_period_steps=23)
    whole, _ = learned(maze, config, seed=4)
    parts = interrupted(maze, config, tmp_path / "agent", every)
    if name == "prioritized-sweeping":  # the queue is made anew, so only the outcome is the same
        assert parts.progress.optimal_at > 0
        return
    assert np.array_equal(whole.q, parts.q)
    assert np.array_equal(whole.td, parts.td)
    assert whole.progress.step == parts.progress.step
    assert whole.replay.counts == parts.replay.counts


@pytest.mark.parametrize("name", LEARNERS)
def test_a_goal_added_after_learning_is_confirmed_by_every_learner(name: str) -> None:
    maze = room()
    config = learner_settings(name, consecutive_successes=3)
    agent, _ = learned(maze, config, seed=4)
    agent.add_goal(Cell(4, 3), "late")
    agent.begin_goal(3)
    with pytest.raises(TwonavError, match="other goals"):
        agent.check_fits(maze)
    loop = MazeLoop(agent, maze.with_goal("late", Cell(4, 3)), 5)
    rows, done = loop.run()
    assert done
    assert rows.reached.all()


def test_a_loop_refuses_to_go_on_when_a_goal_was_added() -> None:
    maze = room()
    agent, _ = learned(maze, learner_settings("multi", consecutive_successes=3))
    agent.progress.learned[0] = False
    agent.begin_goal(0)
    loop = MazeLoop(agent, maze, 0)
    agent.add_goal(Cell(4, 3), "late")
    with pytest.raises(TwonavError, match="a goal was added"):
        loop.run()


def test_what_the_single_goal_learner_experienced_stays_of_use_for_a_new_goal() -> None:
    maze = room()
    agent, steps = learned(maze, learner_settings("single", consecutive_successes=3))
    assert len(agent.replay) < sum(steps)
    assert len(agent.replay) + len(agent.earlier_here) == sum(steps)
    assert agent.add_goal(Cell(4, 3)).remembered == sum(steps)


def test_the_oracle_remembers_only_what_it_did() -> None:
    maze = room()
    agent, steps = learned(maze, learner_settings("oracle", consecutive_successes=3))
    assert len(agent.replay) == sum(steps)


def test_an_agent_fits_only_its_own_walls_and_its_goals_in_their_order() -> None:
    maze = room()
    agent = Agent.for_maze(maze, LearningConfig())
    agent.check_fits(maze)
    with pytest.raises(TwonavError, match="other goals"):
        agent.check_fits(replace(maze, goals=dict(reversed(maze.goals.items()))))
    with pytest.raises(TwonavError, match="other walls"):
        agent.check_fits(replace(maze, blocked=np.zeros_like(maze.blocked)))
