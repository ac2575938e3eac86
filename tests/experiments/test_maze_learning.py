"""Learning in the maze: what is learned, what is sent, that it can be stopped and go on, and cut into any pieces."""

from collections.abc import Iterable
from dataclasses import replace
from itertools import cycle
from pathlib import Path

import numpy as np
import pytest
from scattered_maze import greedy_lengths, scattered_maze, shortest_lengths

from twonav_cli.config import LearningConfig
from twonav_cli.errors import TwonavError
from twonav_cli.events import Event, GoalChosen, GoalLearned, QSnapshot, Sink, TrialBatch, to_nobody
from twonav_cli.experiments.learning_progress import LearningOutcome
from twonav_cli.experiments.maze_learning import EARLY_SNAPSHOTS, MazeLearning, learn_maze
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.learners import LEARNERS, learner_settings
from twonav_cli.maze import Maze

CONFIG = LearningConfig(consecutive_successes=50)
CARD = {"scene": "test", "scene_digest": "s", "map_digest": "m", "command": "test", "seed": 0, "metrics": {}}


@pytest.mark.parametrize(("size", "seed"), [(5, 1), (10, 2), (10, 3)])
def test_learned_paths_are_the_shortest_and_untrained_ones_are_not(size: int, seed: int) -> None:
    maze = scattered_maze(size, seed)
    agent = Agent.for_maze(maze, CONFIG)
    assert greedy_lengths(agent, maze) != shortest_lengths(maze)
    outcome = learn_maze(agent, maze, seed, to_nobody, lambda: False)
    assert outcome.outcome == "learned"
    assert greedy_lengths(agent, maze) == shortest_lengths(maze)
    assert outcome.steps >= 50 * sum(shortest_lengths(maze))
    assert min(outcome.trials_of_goal.values()) >= 50 * len(maze.starts)


def test_the_events_of_a_run_add_up() -> None:
    maze, events = scattered_maze(6, 4), list[Event]()
    agent = Agent.for_maze(maze, CONFIG)
    outcome = learn_maze(agent, maze, 0, events.append, lambda: False)
    batches = [e for e in events if isinstance(e, TrialBatch)]
    steps = np.concatenate([b.steps for b in batches])
    reached = np.concatenate([b.reached for b in batches])
    shortest = np.concatenate([b.shortest for b in batches])
    assert steps.sum() == outcome.steps == batches[-1].clock.step == batches[-1].last_step[-1]
    assert len(steps) == outcome.trials
    assert (steps[reached] >= shortest[reached]).all()
    assert np.array_equal(np.concatenate([b.last_step for b in batches]), np.cumsum(steps))
    chosen = [e.goal for e in events if isinstance(e, GoalChosen)]
    learned = [e.goal for e in events if isinstance(e, GoalLearned)]
    assert chosen == learned
    assert sorted(learned) == sorted(outcome.learned) == sorted(maze.goals)
    assert np.array_equal([e for e in events if isinstance(e, QSnapshot)][-1].q, agent.table())


def test_the_same_seed_gives_the_same_run_and_another_seed_another() -> None:
    maze, states, steps = scattered_maze(6, 4), [], []
    for seed in (1, 1, 2):
        agent, batches = Agent.for_maze(maze, CONFIG, seed), list[Event]()
        learn_maze(agent, maze, seed, batches.append, lambda: False)
        states.append((agent.q.tobytes(), agent.td.tobytes(), agent.progress.explore_state))
        steps.append([event.steps.tolist() for event in batches if isinstance(event, TrialBatch)])
    assert states[0] == states[1]
    assert steps[0] == steps[1]
    assert steps[0] != steps[2]


def test_a_run_that_was_stopped_and_saved_goes_on_as_if_unbroken(tmp_path: Path) -> None:
    maze = scattered_maze(10, 2)
    unbroken = Agent.for_maze(maze, CONFIG)
    whole = learn_maze(unbroken, maze, 0, to_nobody, lambda: False)
    broken = Agent.for_maze(maze, CONFIG)
    part = learn_maze(broken, maze, 0, to_nobody, lambda: broken.progress.trial >= 300)
    assert part.outcome == "stopped"
    assert 300 <= part.trials < whole.trials
    broken.save(tmp_path, CARD)
    again = Agent.load(tmp_path)
    assert learn_maze(again, maze, 0, to_nobody, lambda: False) == whole
    assert np.array_equal(again.q, unbroken.q)
    assert np.array_equal(again.td, unbroken.td)
    assert again.replay.counts == unbroken.replay.counts


def test_a_run_that_cannot_succeed_gives_up() -> None:
    maze = scattered_maze(10, 2)
    agent = Agent.for_maze(maze, replace(CONFIG, trial_limit_steps=1))
    assert learn_maze(agent, maze, 0, to_nobody, lambda: False, steps_at_most=2000).outcome == "gave-up"


def test_a_goal_that_is_cut_off_and_a_maze_without_starts_are_refused() -> None:
    blocked = np.zeros((3, 3), dtype=np.bool_)
    blocked[:, 1] = True
    cut = Maze(blocked, {"g": Cell(0, 2)}, {"s": Cell(0, 0)})
    with pytest.raises(TwonavError, match="'g' cannot be reached from start 's'"):
        learn_maze(Agent.for_maze(cut, CONFIG), cut, 0, to_nobody, lambda: False)
    lonely = Maze(blocked, {"g": Cell(0, 2)}, {})
    with pytest.raises(TwonavError, match="no start"):
        learn_maze(Agent.for_maze(lonely, CONFIG), lonely, 0, to_nobody, lambda: False)


def watched(agent: Agent, maze: Maze, seed: int, sizes: Iterable[int], sink: Sink = to_nobody) -> LearningOutcome:
    """Learn a maze in pieces of so many actions, in turn."""
    learning, size = MazeLearning(agent, maze, seed, sink), cycle(sizes)
    while not learning.outcome:
        learning.advance(next(size))
    return learning.close()


@pytest.mark.parametrize("sizes", [(1, 2, 97), (10_000,), (333, 1)])
@pytest.mark.parametrize("learner", list(LEARNERS))
def test_action_by_action_the_same_is_learned_and_sent_as_in_batches(learner: str, sizes: tuple[int, ...]) -> None:
    maze = scattered_maze(6, 4)
    config = learner_settings(learner, "maze", consecutive_successes=20, goal_selection="random")
    agents, events = [Agent.for_maze(maze, config, 1) for _ in range(2)], ([], [])
    outcomes = [
        learn_maze(agents[0], maze, 1, events[0].append, lambda: False),
        watched(agents[1], maze, 1, sizes, events[1].append),
    ]
    assert outcomes[0] == outcomes[1]
    assert outcomes[0].outcome == "learned"
    for name in ("q", "td"):
        assert np.array_equal(getattr(agents[0], name), getattr(agents[1], name))
    assert agents[0].replay.counts == agents[1].replay.counts
    assert agents[0].progress.explore_state == agents[1].progress.explore_state
    assert [type(e) for e in events[0]] == [type(e) for e in events[1]]
    for one, other in zip(*events, strict=True):
        assert one.clock == other.clock
        if isinstance(one, TrialBatch):
            assert np.array_equal(one.steps, other.steps)
            assert np.array_equal(one.last_step, other.last_step)


def test_a_run_that_gives_up_does_so_at_the_same_action_however_it_is_cut() -> None:
    maze, config = scattered_maze(10, 2), replace(CONFIG, trial_limit_steps=3)
    whole, pieces = Agent.for_maze(maze, config), Agent.for_maze(maze, config)
    outcome = learn_maze(whole, maze, 0, to_nobody, lambda: False, steps_at_most=2000)
    learning = MazeLearning(pieces, maze, 0, to_nobody, steps_at_most=2000)
    while not learning.outcome:
        learning.advance(7)
    assert learning.close() == outcome
    assert outcome.outcome == "gave-up"


def test_a_run_that_was_stopped_inside_a_trial_goes_on_as_if_unbroken(tmp_path: Path) -> None:
    maze = scattered_maze(10, 2)
    unbroken, broken = Agent.for_maze(maze, CONFIG), Agent.for_maze(maze, CONFIG)
    whole, batches = learn_maze(unbroken, maze, 0, to_nobody, lambda: False), list[TrialBatch]()
    learning = MazeLearning(broken, maze, 0, lambda e: batches.append(e) if isinstance(e, TrialBatch) else None)
    while broken.progress.step < 3000 or not learning.loop.in_trial:
        learning.advance(11)
    learning.finish_trial()
    assert learning.close().outcome == "stopped"
    assert sum(batch.steps.sum() for batch in batches) == broken.progress.step
    broken.save(tmp_path, CARD)
    again = Agent.load(tmp_path)
    assert learn_maze(again, maze, 0, to_nobody, lambda: False) == whole
    assert np.array_equal(again.q, unbroken.q)


def test_going_on_with_nothing_left_to_learn_chooses_no_goal() -> None:
    maze, events = scattered_maze(5, 1), list[Event]()
    agent = Agent.for_maze(maze, CONFIG)
    learn_maze(agent, maze, 0, to_nobody, lambda: False)
    learning = MazeLearning(agent, maze, 0, events.append)
    learning.choose_goal()
    assert learning.outcome == "learned"
    assert not events


def test_the_tables_are_sent_often_at_first_and_say_what_was_never_tried() -> None:
    maze, events = scattered_maze(10, 2), list[Event]()
    agent = Agent.for_maze(maze, CONFIG)
    learn_maze(agent, maze, 0, events.append, lambda: False)
    sent = [event for event in events if isinstance(event, QSnapshot)]
    early = [trial for trial in EARLY_SNAPSHOTS if trial < agent.progress.trial]
    assert [event.clock.trial for event in sent][: len(early[:6]) + 1] == [0, *early[:6]]
    tables = [event.td_errors for event in sent if event.td_errors is not None]
    assert len(tables) == len(sent)
    untried = [int(np.isnan(table[:, ~maze.blocked]).sum()) for table in tables]
    assert untried[0] == 4 * len(maze.goals) * len(maze.free_cells)
    assert untried == sorted(untried, reverse=True)
    assert untried[3] < untried[0]


def test_a_choice_says_which_goals_were_learned_already() -> None:
    maze, events = scattered_maze(5, 1), list[Event]()
    agent = Agent.for_maze(maze, CONFIG)
    learn_maze(agent, maze, 0, events.append, lambda: False)
    choices = [event for event in events if isinstance(event, GoalChosen)]
    done = [event.learned for event in choices if event.learned is not None]
    assert [int(learned.sum()) for learned in done] == list(range(len(maze.goals)))
    assert not any(learned[agent.goal_names.index(choice.goal)] for learned, choice in zip(done, choices, strict=True))
