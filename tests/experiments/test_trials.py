"""The learning loops: what they learn, what they send, and that they can be stopped and go on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.config import LearningConfig
from twonav_cli.errors import TwonavError
from twonav_cli.events import (
    Clock,
    Event,
    GoalChosen,
    GoalLearned,
    QSnapshot,
    Sink,
    StepTaken,
    TrialBatch,
    TrialEnded,
    TrialStarted,
    to_nobody,
)
from twonav_cli.experiments.trials import learn_in_stage, learn_maze, run_trial
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Action, Maze, filled_where_unreachable
from twonav_cli.stages.maze_stage import MazeStage
from twonav_cli.stages.stage import BLOCKED, REACHED, TIMED_OUT, ActionResult, Observation

CONFIG = LearningConfig(consecutive_successes=50)
CARD = {"scene": "test", "scene_digest": "s", "map_digest": "m", "command": "test", "seed": 0, "metrics": {}}


def random_maze(size: int, seed: int) -> Maze:
    rng = np.random.default_rng(seed)
    blocked = rng.random((size, size)) < 0.2
    blocked[0, 0] = False
    blocked = filled_where_unreachable(blocked, Cell(0, 0))
    free = [Cell(int(r), int(c)) for r, c in np.argwhere(~blocked)]
    picked = [free[i] for i in rng.permutation(len(free))[:8]]
    goals = {f"goal {i}": cell for i, cell in enumerate(picked[:4])}
    return Maze(blocked, goals, {f"start {i}": cell for i, cell in enumerate(picked[4:])})


def greedy_lengths(agent: Agent, maze: Maze) -> list[int]:
    """Length of the greedy path for every goal and start, 999 where it never arrives."""
    lengths = []
    for goal, goal_cell in enumerate(agent.goal_cells):
        actions = agent.greedy_actions(goal)
        for cell in maze.starts.values():
            steps = 0
            while cell != goal_cell and steps < 999:
                cell, steps = maze.moved(cell, int(actions[cell])), steps + 1
            lengths.append(steps)
    return lengths


def shortest_lengths(maze: Maze) -> list[int]:
    return [int(maze.distances_to(goal)[start]) for goal in maze.goals.values() for start in maze.starts.values()]


@pytest.mark.parametrize(("size", "seed"), [(5, 1), (10, 2), (10, 3)])
def test_learned_paths_are_the_shortest_and_untrained_ones_are_not(size: int, seed: int) -> None:
    maze = random_maze(size, seed)
    agent = Agent.for_maze(maze, CONFIG)
    assert greedy_lengths(agent, maze) != shortest_lengths(maze)
    outcome = learn_maze(agent, maze, seed, to_nobody, lambda: False)
    assert outcome.outcome == "learned"
    assert greedy_lengths(agent, maze) == shortest_lengths(maze)
    assert outcome.steps >= 50 * sum(shortest_lengths(maze))
    assert min(outcome.trials_of_goal.values()) >= 50 * len(maze.starts)


def test_the_events_of_a_run_add_up() -> None:
    maze, events = random_maze(6, 4), list[Event]()
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
    maze, tables = random_maze(6, 4), []
    steps = []
    for seed in (1, 1, 2):
        agent = Agent.for_maze(maze, CONFIG, seed)
        steps.append(learn_maze(agent, maze, seed, to_nobody, lambda: False).steps)
        tables.append(agent.q)
    assert np.array_equal(tables[0], tables[1])
    assert steps[0] == steps[1]
    assert not np.array_equal(tables[0], tables[2])


def test_a_run_that_was_stopped_and_saved_goes_on_as_if_unbroken(tmp_path: Path) -> None:
    maze = random_maze(10, 2)
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
    maze = random_maze(10, 2)
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


CORRIDOR = Maze(np.zeros((1, 6), dtype=np.bool_), {"end": Cell(0, 5)}, {"begin": Cell(0, 0), "mid": Cell(0, 2)})


class MistakenStage(MazeStage):
    """A maze whose robot believes what a table says of its true cell, and whose actions are blocked on demand."""

    def __init__(self, maze: Maze, believed: dict[Cell, Cell], blocks: bool = False) -> None:
        super().__init__(maze)
        self.believed, self.blocks = believed, blocks

    def _mistaken(self, seen: Observation) -> Observation:
        return replace(seen, cell=self.believed.get(seen.true_cell, seen.true_cell))

    def place(self, cell: Cell) -> Observation:
        self._here = cell
        return self._mistaken(super().place(cell))

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        if self.blocks:
            return ActionResult(BLOCKED, self._mistaken(Observation(self._here, self._here)))
        result = super().act(action, clock, sink)
        return ActionResult(result.outcome, self._mistaken(result.observation))


def agent_that_goes(action: int, limit: int = 60) -> Agent:
    agent = Agent.for_maze(CORRIDOR, replace(CONFIG, trial_limit_steps=limit))
    agent.q[:, :, action] = 90.0
    return agent


def run(stage: MazeStage, agent: Agent, start: Cell, sink: Sink = to_nobody, learn: bool = False):
    return run_trial(stage, agent, 0, start, np.random.default_rng(0), Clock(3, 100), sink, learn, explore=False)


def test_a_greedy_trial_reaches_the_goal_and_tells_every_step() -> None:
    events = list[Event]()
    result = run(MazeStage(CORRIDOR), agent_that_goes(Action.RIGHT), Cell(0, 2), events.append)
    assert (result.outcome, result.steps, result.shortest, result.cause) == ("reached", 3, 3, "")
    assert result.clock == Clock(3, 103, 0.0)
    assert [type(e) for e in events] == [TrialStarted, StepTaken, StepTaken, StepTaken, TrialEnded]
    steps = [e for e in events if isinstance(e, StepTaken)]
    assert [e.clock.step for e in steps] == [101, 102, 103]
    assert [e.next_cell for e in steps] == [Cell(0, 3), Cell(0, 4), Cell(0, 5)]
    assert all(e.outcome == REACHED and e.greedy and e.clock.trial == 3 for e in steps)
    assert np.isclose(steps[-1].td_errors[0], 10.0**2)


def test_a_trial_that_starts_on_its_goal_takes_no_action() -> None:
    result = run(MazeStage(CORRIDOR), agent_that_goes(Action.RIGHT), Cell(0, 5))
    assert (result.outcome, result.steps, result.shortest) == ("reached", 0, 0)


def test_only_a_learning_trial_changes_the_table() -> None:
    agent = agent_that_goes(Action.RIGHT)
    before = agent.q.copy()
    run(MazeStage(CORRIDOR), agent, Cell(0, 2))
    assert np.array_equal(agent.q, before)
    run(MazeStage(CORRIDOR), agent, Cell(0, 2), learn=True)
    assert agent.q[0, 4, Action.RIGHT, 0] == 100.0
    assert len(agent.replay) == 3


def test_arrival_declared_elsewhere_is_a_false_arrival() -> None:
    stage = MistakenStage(CORRIDOR, {Cell(0, 4): Cell(0, 5)})
    result = run(stage, agent_that_goes(Action.RIGHT), Cell(0, 2))
    assert (result.outcome, result.steps, result.cause) == ("false-arrival", 2, "mislocalized")
    assert "(0, 5)" in result.evidence
    assert "(0, 4)" in result.evidence


def test_a_trial_that_ends_in_the_wrong_belief_is_mislocalized() -> None:
    stage = MistakenStage(CORRIDOR, {Cell(0, 5): Cell(0, 3)})
    result = run(stage, agent_that_goes(Action.RIGHT), Cell(0, 2))
    assert (result.outcome, result.steps, result.cause) == ("time-out", 60, "mislocalized")


def test_a_robot_that_cannot_move_is_blocked() -> None:
    agent = agent_that_goes(Action.RIGHT)
    result = run(MistakenStage(CORRIDOR, {}, blocks=True), agent, Cell(0, 2), learn=True)
    assert (result.outcome, result.cause) == ("time-out", "blocked")
    assert agent.q[0, 2, Action.RIGHT, 0] < 80.0


class LateStage(MazeStage):
    """A maze whose actions do what they say but report that they ran out of time."""

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        return replace(super().act(action, clock, sink), outcome=TIMED_OUT)


def test_an_action_that_ran_out_of_time_is_punished_like_a_bump_unless_it_enters_the_goal() -> None:
    agent = agent_that_goes(Action.RIGHT)
    run(LateStage(CORRIDOR), agent, Cell(0, 3), learn=True)
    assert agent.q[0, 3, Action.RIGHT, 0] == 90.0 + (-2.0 + 0.95 * 90.0 - 90.0)
    assert agent.q[0, 4, Action.RIGHT, 0] == 100.0


def test_a_robot_that_walks_to_and_fro_is_in_a_loop() -> None:
    agent = agent_that_goes(Action.LEFT)
    agent.q[0, 1, Action.RIGHT] = 95.0
    agent.q[0, 2, Action.LEFT] = 95.0
    result = run(MazeStage(CORRIDOR), agent, Cell(0, 2))
    assert (result.outcome, result.steps, result.cause) == ("time-out", 60, "loop")
    assert "2 cells" in result.evidence


def test_too_few_actions_are_a_time_out() -> None:
    result = run(MazeStage(CORRIDOR), agent_that_goes(Action.RIGHT, limit=3), Cell(0, 0))
    assert (result.outcome, result.steps, result.cause) == ("time-out", 3, "time-out")


def test_the_slow_loop_learns_any_stage_and_can_be_stopped_and_go_on(tmp_path: Path) -> None:
    maze = random_maze(5, 1)
    config = replace(CONFIG, consecutive_successes=5, replay_period_steps=50)
    unbroken, broken = Agent.for_maze(maze, config), Agent.for_maze(maze, config)
    whole = learn_in_stage(MazeStage(maze), unbroken, 0, to_nobody, lambda: False)
    assert whole.outcome == "learned"
    assert greedy_lengths(unbroken, maze) == shortest_lengths(maze)
    part = learn_in_stage(MazeStage(maze), broken, 0, to_nobody, lambda: broken.progress.trial >= 17)
    assert (part.outcome, part.trials) == ("stopped", 17)
    broken.save(tmp_path, CARD)
    again = Agent.load(tmp_path)
    assert learn_in_stage(MazeStage(maze), again, 0, to_nobody, lambda: False) == whole
    assert np.array_equal(again.q, unbroken.q)


def test_every_start_gets_as_many_trials_as_the_others() -> None:
    maze = random_maze(5, 1)
    config = replace(CONFIG, consecutive_successes=3, max_step_difference=0.4, temperature_decay=0.98)
    for seed in range(3):
        slow, fast = Agent.for_maze(maze, config, seed), Agent.for_maze(maze, config, seed)
        outcomes = [
            learn_in_stage(MazeStage(maze), slow, seed, to_nobody, lambda: False),
            learn_maze(fast, maze, seed, to_nobody, lambda: False),
        ]
        assert all(n % len(maze.starts) == 0 for o in outcomes for n in o.trials_of_goal.values())


def test_the_slow_loop_gives_up() -> None:
    agent = agent_that_goes(Action.LEFT, limit=2)
    outcome = learn_in_stage(MazeStage(CORRIDOR), agent, 0, to_nobody, lambda: False, trials_at_most=6)
    assert (outcome.outcome, outcome.trials, outcome.learned) == ("gave-up", 6, ())
