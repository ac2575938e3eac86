"""The figures of navigation, and an evaluation that leaves no trace."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.config import learning_preset
from twonav_cli.events import Event, TrialEnded, to_nobody
from twonav_cli.experiments.evaluation import (
    PairResult,
    PairTable,
    evaluate_pairs,
    figures,
    pairs_of,
    success_weighted_path_length,
)
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Action, Maze
from twonav_cli.stages.maze_stage import MazeStage

WON = PairResult("bed", "s1", True, "reached", 10, 8, "")
DETOUR = PairResult("bed", "s2", True, "reached", 6, 3, "")
LOST = PairResult("desk", "s1", False, "time-out", 500, 12, "loop", collisions=4, wrong_cells=2, sim_s=645.0)
AT_HOME = PairResult("desk", "s2", True, "reached", 0, 0, "")


def test_spl_weighs_success_by_shortest_over_taken() -> None:
    assert success_weighted_path_length([WON, DETOUR, LOST]) == pytest.approx((0.8 + 0.5 + 0.0) / 3)


def test_a_pair_without_a_way_to_go_counts_full() -> None:
    assert success_weighted_path_length([AT_HOME]) == 1.0


def test_a_way_that_is_shorter_than_the_shortest_does_not_count_more_than_full() -> None:
    assert success_weighted_path_length([PairResult("a", "b", True, "reached", 7, 8, "")]) == 1.0


def test_figures_compare_actions_and_shortest_ways_of_the_same_pairs() -> None:
    assert figures([WON, DETOUR, LOST]) == {
        "pairs": 3,
        "successes": 2,
        "success_rate": pytest.approx(2 / 3),
        "actions_mean": 8.0,
        "actions_std": None,
        "shortest_mean": 5.5,
        "ratio": pytest.approx(8.0 / 5.5),
        "spl": pytest.approx(1.3 / 3),
        "collisions_per_100_actions": pytest.approx(400 / 516),
        "wrong_cells_per_100_actions": pytest.approx(200 / 516),
        "sim_s_per_action": pytest.approx(1.25),
        "actions_per_s": None,
    }


def test_the_deviation_is_that_of_a_pair_from_repeat_to_repeat() -> None:
    longer = [replace(WON, actions=14, repeat=1), replace(DETOUR, actions=6, repeat=1)]
    assert figures([WON, DETOUR, *longer])["actions_std"] == pytest.approx((np.sqrt(8) + 0.0) / 2)


@pytest.mark.parametrize("pairs", [[], [LOST], [AT_HOME]])
def test_figures_that_do_not_exist_are_none_and_not_a_division_by_zero(pairs: list[PairResult]) -> None:
    assert figures(pairs)["ratio"] is None


def test_the_report_counts_causes_and_collisions_and_lists_goals_in_order() -> None:
    report = PairTable([WON, LOST, DETOUR, AT_HOME]).report()
    assert report["causes"] == {"loop": 1}
    assert report["collisions"] == 4
    assert list(report["per_goal"]) == ["bed", "desk"]
    assert report["per_goal"]["desk"] == figures([LOST, AT_HOME])
    assert report["pairs"] == 4


@pytest.fixture(scope="module")
def maze() -> Maze:
    blocked = np.zeros((4, 5), dtype=np.bool_)
    blocked[1, 1:4] = True
    goals = {"top": Cell(0, 2), "bottom": Cell(3, 2)}
    return Maze(blocked, goals, {"s1": Cell(2, 2), "s2": Cell(0, 4), "s3": Cell(3, 2)})


@pytest.fixture
def learned(maze: Maze) -> Agent:
    agent = Agent.for_maze(maze, learning_preset("maze"))
    assert learn_maze(agent, maze, 1, to_nobody, lambda: False).outcome == "learned"
    return agent


def never() -> bool:
    return False


def test_every_goal_is_driven_from_every_start_by_the_shortest_way(maze: Maze, learned: Agent) -> None:
    events: list[Event] = []
    pairs: list[PairResult] = []
    table = evaluate_pairs(MazeStage(maze), learned, 0, events.append, pairs.append, never)
    assert [(pair.goal, pair.start) for pair in pairs] == list(itertools.product(maze.goals, maze.starts))
    assert pairs == table.pairs
    for pair in pairs:
        shortest = int(maze.distances_to(maze.goals[pair.goal])[maze.starts[pair.start]])
        assert (pair.actions, pair.shortest, pair.outcome) == (shortest, shortest, "reached")
    ended = [event for event in events if isinstance(event, TrialEnded)]
    assert [event.clock.trial for event in ended] == list(range(6))
    assert ended[-1].clock.step == sum(pair.actions for pair in pairs)


def test_the_agent_is_the_same_afterwards(maze: Maze, learned: Agent) -> None:
    learned.q[2, 2] = learned.q[2, 2, ::-1]  # something to learn on the way
    q, td, replay = learned.q.copy(), learned.td.copy(), learned.replay.to_array().copy()
    state = (learned.temperature, learned.steps_since_sweep, learned.sweeps, learned.progress.trial)
    evaluate_pairs(MazeStage(maze), learned, 0, to_nobody, lambda pair: None, never)
    assert np.array_equal(learned.q, q)
    assert np.array_equal(learned.td, td)
    assert np.array_equal(learned.replay.to_array(), replay)
    assert (learned.temperature, learned.steps_since_sweep, learned.sweeps, learned.progress.trial) == state


def test_within_a_trial_a_blocked_way_loses_its_value(maze: Maze, learned: Agent) -> None:
    learned.q[2, 2, Action.UP, 0] = learned.q[2, 2, :, 0].max() + 0.1  # into the wall
    table = evaluate_pairs(MazeStage(maze), learned, 0, to_nobody, lambda pair: None, never)
    first = table.pairs[0]
    assert first.start == "s1"
    assert first.success
    assert first.actions == first.shortest + 1


def test_a_pair_does_not_depend_on_the_pairs_before_it(maze: Maze) -> None:
    untrained = Agent.for_maze(maze, learning_preset("maze"))
    all_pairs = evaluate_pairs(MazeStage(maze), untrained, 5, to_nobody, lambda pair: None, never).pairs
    again = evaluate_pairs(MazeStage(maze), untrained, 5, to_nobody, lambda pair: None, never).pairs
    other = evaluate_pairs(MazeStage(maze), untrained, 6, to_nobody, lambda pair: None, never).pairs
    assert all_pairs == again
    assert all_pairs != other


def test_every_pair_is_driven_as_often_as_asked_and_each_time_anew(maze: Maze) -> None:
    untrained, pairs = Agent.for_maze(maze, learning_preset("maze")), pairs_of(maze, 3)
    found = evaluate_pairs(MazeStage(maze), untrained, 5, to_nobody, lambda pair: None, never, pairs).pairs
    assert [pair.repeat for pair in found] == [0] * 6 + [1] * 6 + [2] * 6
    assert [pair.actions for pair in found[:6]] != [pair.actions for pair in found[6:12]]


def test_an_evaluation_that_is_stopped_keeps_what_was_driven(maze: Maze, learned: Agent) -> None:
    pairs: list[PairResult] = []
    table = evaluate_pairs(MazeStage(maze), learned, 0, to_nobody, pairs.append, lambda: len(pairs) == 2)
    assert len(table.pairs) == 2


class BumpingStage(MazeStage):
    """Touches something once per placing."""

    collisions = 0

    def place(self, cell: Cell):  # type: ignore[no-untyped-def]  # as the stage's
        self.collisions += 1
        return super().place(cell)


def test_collisions_are_counted_for_the_pair_they_happened_in(maze: Maze, learned: Agent) -> None:
    table = evaluate_pairs(BumpingStage(maze), learned, 0, to_nobody, lambda pair: None, never)
    assert [pair.collisions for pair in table.pairs] == [1] * 6
