"""The loop over trials of any stage: what it sends, why a trial failed, and that it can be stopped and go on."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from scattered_maze import greedy_lengths, scattered_maze, shortest_lengths

from twonav_cli.belief import Belief
from twonav_cli.config import LearningConfig
from twonav_cli.events import Clock, Event, Looked, Sink, StepTaken, TrialEnded, TrialStarted, to_nobody
from twonav_cli.experiments.maze_learning import learn_maze
from twonav_cli.experiments.trials import learn_in_stage, run_trial
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Action, Maze
from twonav_cli.navigation.outcomes import BLOCKED, REACHED, TIMED_OUT
from twonav_cli.stages.maze_stage import MazeStage
from twonav_cli.stages.stage import ActionResult, Observation

CONFIG = LearningConfig(consecutive_successes=50)
CARD = {"scene": "test", "scene_digest": "s", "map_digest": "m", "command": "test", "seed": 0, "metrics": {}}
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


class WedgedStage(MistakenStage):
    """A maze whose robot has a pose, and cannot move it."""

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        result = super().act(action, clock, sink)
        return replace(result, observation=replace(result.observation, pose_true=Pose(1.0, 2.0, 0.0)))


def test_a_robot_that_stays_where_it_is_for_ten_blocked_actions_is_stuck() -> None:
    result = run(WedgedStage(CORRIDOR, {}, blocks=True), agent_that_goes(Action.RIGHT), Cell(0, 2), learn=True)
    assert (result.outcome, result.cause) == ("time-out", "stuck")
    assert "0.00 m" in result.evidence


class JumpingStage(MazeStage):
    """A maze in which every action to the right ends one cell too far."""

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        if action == Action.RIGHT:
            super().act(action, clock, sink)
        return super().act(action, clock, sink)


def test_actions_that_end_in_another_cell_than_they_should_are_counted() -> None:
    assert run(JumpingStage(CORRIDOR), agent_that_goes(Action.RIGHT), Cell(0, 1)).wrong_cells == 2
    assert run(MazeStage(CORRIDOR), agent_that_goes(Action.RIGHT), Cell(0, 1)).wrong_cells == 0


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
    maze = scattered_maze(5, 1)
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
    maze = scattered_maze(5, 1)
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


class SeeingStage(MistakenStage):
    """A maze with a camera and a localizer that is sure of a place."""

    def _mistaken(self, seen: Observation) -> Observation:
        pose = Pose(0.4 * seen.true_cell.col, 0.0, 0.0)
        return replace(
            super()._mistaken(seen),
            pose_true=pose,
            pose_estimate=pose._replace(x_m=pose.x_m + 0.5),
            image=np.zeros((84, 84, 3), dtype=np.uint8),
            belief=Belief(
                np.array([(1.0, pose.x_m + 0.5, 0.0, 0.1)]), np.array([(1.0, 0.0, 0.1)]), 0.2, 60.0,
                np.zeros((1, 1), dtype=np.float32), GridFrame(0.0, 0.0, 1.0, 1, 1),
            ),
        )  # fmt: skip


def test_the_first_look_of_a_trial_and_every_action_tell_what_is_believed() -> None:
    events = list[Event]()
    run(SeeingStage(CORRIDOR, {}), agent_that_goes(Action.RIGHT), Cell(0, 3), events.append)
    assert [type(e) for e in events] == [TrialStarted, Looked, StepTaken, StepTaken, TrialEnded]
    looked, step = events[1], events[2]
    assert isinstance(looked, Looked)
    assert isinstance(step, StepTaken)
    assert looked.clock == Clock(3, 100)
    assert looked.pose_true == Pose(0.4 * 3, 0.0, 0.0)
    assert looked.belief is not None
    assert looked.belief.pose == looked.pose_estimate == Pose(0.4 * 3 + 0.5, 0.0, 0.0)
    assert step.belief is not None
    assert step.belief.pose == step.pose_estimate


def test_a_mislocalized_trial_says_how_sure_the_robot_was() -> None:
    stage = SeeingStage(CORRIDOR, {Cell(0, 4): Cell(0, 5)})
    result = run(stage, agent_that_goes(Action.RIGHT), Cell(0, 2))
    assert result.evidence.startswith(
        "Arrival was declared in (0, 5), but the robot stands in (0, 4). It was 0.80 sure"
    )
