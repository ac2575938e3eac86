"""Goals one after another, with a person who changes their mind."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.config import learning_preset
from twonav_cli.errors import TwonavError
from twonav_cli.events import (
    Clock,
    Event,
    GoalAdded,
    GoalChosen,
    Kidnapped,
    Looked,
    Note,
    QSnapshot,
    Sink,
    StepTaken,
    Tick,
    TrialEnded,
    TrialStarted,
)
from twonav_cli.experiments.journey import Journey, NoWishes, Visit
from twonav_cli.experiments.new_goal import GoalWish, cell_at_place
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.learner.agent import Agent
from twonav_cli.maze import Action, Maze
from twonav_cli.stages.maze_stage import MazeStage
from twonav_cli.stages.stage import ActionResult, Observation

CORRIDOR = Maze(np.zeros((1, 7), dtype=np.bool_), {"left": Cell(0, 0), "right": Cell(0, 6)}, {"middle": Cell(0, 3)})
FRAME = GridFrame(-0.4, 0.0, 0.4, 1, 7)


class FakeWishes(NoWishes):
    """Answers from a script: at which look (0 is before the first action) what is wanted."""

    def __init__(self, **script: dict[int, object]) -> None:
        super().__init__()
        self.looks = -1
        self.goals, self.kidnaps = script.get("goals", {}), script.get("kidnaps", {})
        self.moves, self.leaving = script.get("moves", {}), script.get("leaving", {})
        self.new_goals = script.get("new_goals", {})
        self.afterwards: list[str | None] = []

    def wait_for_permission(self) -> None:
        self.looks += 1

    def next_goal(self, wait: bool) -> str | None:
        if wait:
            return self.afterwards.pop(0) if self.afterwards else None
        goal = self.goals.pop(self.looks, None)
        return None if goal is None else str(goal)

    def take_new_goal(self) -> GoalWish | None:
        wish = self.new_goals.pop(self.looks, None)
        assert wish is None or isinstance(wish, GoalWish)
        return wish

    def take_kidnap(self) -> bool:
        return bool(self.kidnaps.pop(self.looks, False))

    def take_move(self) -> int | None:
        move = self.moves.pop(self.looks, None)
        return None if move is None else int(str(move))

    def left(self) -> bool:
        return self.looks in self.leaving


@pytest.fixture
def agent() -> Agent:
    """Return an agent that knows the corridor and takes the best action only."""
    config = replace(learning_preset("maze"), exploration="epsilon-greedy", epsilon=0.0, trial_limit_steps=40)
    agent = Agent.for_maze(CORRIDOR, config)
    for _ in range(30):
        for cell in CORRIDOR.free_cells:
            for action in Action:
                after = CORRIDOR.moved(cell, action)
                agent.observe(cell, action, after, after == cell)
    return agent


Travel = Callable[..., tuple[list[Visit], list[Event]]]


@pytest.fixture
def travel(agent: Agent) -> Travel:
    """Return a function that makes a journey and returns the visits and the events."""

    def go(*goals: str, wishes: NoWishes | None = None, stay: bool = False) -> tuple[list[Visit], list[Event]]:
        events: list[Event] = []
        rng = np.random.default_rng(0)
        journey = Journey(MazeStage(CORRIDOR), FRAME, agent, rng, events.append, wishes or NoWishes())
        return journey.run(goals, CORRIDOR.starts["middle"], stay), events

    return go


def of_kind(events: list[Event], kind: type[Event]) -> list[Event]:
    return [event for event in events if isinstance(event, kind)]


def test_goals_are_visited_in_order_from_where_the_one_before_ended(travel: Travel) -> None:
    visits, _ = travel("right", "left", "right")
    assert visits == [
        Visit("right", "reached", 3, 3),
        Visit("left", "reached", 6, 6),
        Visit("right", "reached", 6, 6),
    ]


def test_a_goal_that_the_robot_stands_in_is_reached_without_an_action(travel: Travel) -> None:
    visits, events = travel("right", "right")
    assert visits[1] == Visit("right", "reached", 0, 0)
    assert len(of_kind(events, StepTaken)) == 3


def test_events_tell_goal_start_steps_and_end_in_this_order(travel: Travel) -> None:
    _, events = travel("right")
    kinds = [type(event) for event in events]
    assert kinds == [QSnapshot, GoalChosen, QSnapshot, TrialStarted, *[StepTaken] * 3, TrialEnded]
    assert [event.clock for event in events[4:]] == [*(Clock(0, step) for step in (1, 2, 3)), Clock(0, 3)]


def test_the_trial_counts_goals_and_the_step_counts_on(travel: Travel) -> None:
    _, events = travel("right", "left")
    steps = of_kind(events, StepTaken)
    assert [step.clock.trial for step in steps] == [0] * 3 + [1] * 6
    assert [step.clock.step for step in steps] == list(range(1, 10))


def test_a_goal_that_is_asked_for_on_the_way_comes_next_and_at_once(travel: Travel) -> None:
    visits, _ = travel("right", "right", wishes=FakeWishes(goals={2: "left"}))
    assert visits == [
        Visit("right", "given-up", 2, 3),
        Visit("left", "reached", 5, 5),
        Visit("right", "reached", 6, 6),
    ]


def test_giving_up_is_no_failure_to_be_explained(travel: Travel) -> None:
    _, events = travel("right", wishes=FakeWishes(goals={1: "left"}))
    ended = of_kind(events, TrialEnded)[0]
    assert isinstance(ended, TrialEnded)
    assert (ended.outcome, ended.cause, ended.evidence) == ("given-up", "", "")


def test_a_goal_that_is_asked_for_on_arrival_does_not_undo_the_arrival(travel: Travel) -> None:
    visits, _ = travel("right", wishes=FakeWishes(goals={3: "left"}))
    assert visits == [Visit("right", "reached", 3, 3), Visit("left", "reached", 6, 6)]


def test_asking_for_the_present_goal_again_changes_nothing(travel: Travel) -> None:
    visits, _ = travel("right", wishes=FakeWishes(goals={1: "right"}))
    assert visits == [Visit("right", "reached", 3, 3)]


def test_an_unknown_goal_on_the_way_is_noted_and_the_robot_drives_on(travel: Travel) -> None:
    visits, events = travel("right", wishes=FakeWishes(goals={1: "rigth"}))
    assert visits == [Visit("right", "reached", 3, 3)]
    (note,) = of_kind(events, Note)
    assert isinstance(note, Note)
    assert note.level == "WARN"
    assert "did you mean 'right'" in note.text


def test_an_unknown_goal_at_the_start_is_refused_before_anything_happens(travel: Travel) -> None:
    with pytest.raises(TwonavError, match="did you mean 'left'"):
        travel("right", "lefft")


def test_who_stays_is_asked_for_further_goals_and_wrong_ones_are_noted(travel: Travel) -> None:
    wishes = FakeWishes()
    wishes.afterwards = ["nowhere", "left", None]
    visits, events = travel("right", wishes=wishes, stay=True)
    assert [visit.goal for visit in visits] == ["right", "left"]
    assert len(of_kind(events, Note)) == 1


def test_who_does_not_stay_is_not_waited_for(travel: Travel) -> None:
    wishes = FakeWishes()
    wishes.afterwards = ["left"]
    visits, _ = travel("right", wishes=wishes, stay=False)
    assert [visit.goal for visit in visits] == ["right"]


def test_a_kidnapped_robot_finds_its_goal_from_where_it_was_carried(travel: Travel) -> None:
    visits, events = travel("right", wishes=FakeWishes(kidnaps={2: True}))
    (carried,) = of_kind(events, Kidnapped)
    assert isinstance(carried, Kidnapped)
    assert carried.pose_before == Pose(*FRAME.centre_of(Cell(0, 5)), 0.0)
    cell = FRAME.cell_at(carried.pose_after.x_m, carried.pose_after.y_m)
    assert cell != Cell(0, 5)
    assert visits == [Visit("right", "reached", 2 + 6 - cell.col, 3)]


class CarriedStage(MazeStage):
    """A maze with a camera that counts how often its robot was placed, and how often it was carried."""

    def __init__(self, maze: Maze) -> None:
        super().__init__(maze)
        self.placed, self.carried = 0, list[Cell]()

    def place(self, cell: Cell) -> Observation:
        self.placed += 1
        return self._seen(super().place(cell))

    def carry(self, cell: Cell) -> Observation:
        self.carried.append(cell)
        self._cell = cell
        return self._seen(Observation(Cell(0, 0), cell))

    def _seen(self, seen: Observation) -> Observation:
        pose = Pose(float(seen.true_cell.col), 0.0, 0.0)
        return replace(seen, pose_true=pose, pose_estimate=pose, image=np.zeros((84, 84, 3), dtype=np.uint8))


def test_a_kidnapped_robot_is_carried_not_placed_and_looks_at_once(agent: Agent) -> None:
    stage, events = CarriedStage(CORRIDOR), list[Event]()
    wishes = FakeWishes(kidnaps={2: True})
    Journey(stage, FRAME, agent, np.random.default_rng(0), events.append, wishes).run(["right"], Cell(0, 3), stay=False)
    assert stage.placed == 1
    (cell,) = stage.carried
    looks = of_kind(events, Looked)
    assert [look.pose_true.x_m for look in looks if isinstance(look, Looked)] == [3.0, float(cell.col)]
    at = events.index(looks[1])
    assert isinstance(events[at - 1], Kidnapped)


def test_a_robot_that_fits_nowhere_but_in_one_cell_is_carried_there(agent: Agent) -> None:
    class Narrow(CarriedStage):
        def carry(self, cell: Cell) -> Observation:
            if cell != Cell(0, 1):
                raise TwonavError("the robot does not fit")
            return super().carry(cell)

    stage = Narrow(CORRIDOR)
    wishes = FakeWishes(kidnaps={2: True})
    Journey(stage, FRAME, agent, np.random.default_rng(0), lambda event: None, wishes).run(
        ["right"], Cell(0, 3), stay=False
    )
    assert stage.carried == [Cell(0, 1)]


def test_a_move_by_hand_replaces_the_agents_action_once(travel: Travel) -> None:
    visits, events = travel("right", wishes=FakeWishes(moves={1: int(Action.LEFT)}))
    actions = [step.action for step in of_kind(events, StepTaken) if isinstance(step, StepTaken)]
    assert actions == [Action.RIGHT, Action.LEFT, Action.RIGHT, Action.RIGHT, Action.RIGHT]
    assert visits == [Visit("right", "reached", 5, 3)]


def test_a_move_by_hand_against_a_wall_is_blocked(travel: Travel) -> None:
    visits, events = travel("right", wishes=FakeWishes(moves={0: int(Action.UP)}))
    first = of_kind(events, StepTaken)[0]
    assert isinstance(first, StepTaken)
    assert (first.outcome, first.next_cell) == ("blocked", Cell(0, 3))
    assert visits == [Visit("right", "reached", 4, 3)]


def test_leaving_ends_the_journey_with_the_visits_so_far(travel: Travel) -> None:
    visits, events = travel("right", "left", wishes=FakeWishes(leaving={6: True}))
    assert visits == [Visit("right", "reached", 3, 3)]
    assert len(of_kind(events, StepTaken)) == 3 + 2
    assert len(of_kind(events, TrialEnded)) == 1


def test_a_trial_ends_when_its_actions_are_used_up(travel: Travel, agent: Agent) -> None:
    agent.config = replace(agent.config, trial_limit_steps=2)
    visits, events = travel("right")
    assert visits == [Visit("right", "time-out", 2, 3)]
    ended = of_kind(events, TrialEnded)[0]
    assert isinstance(ended, TrialEnded)
    assert ended.cause == "time-out"


def test_the_agent_goes_on_learning(travel: Travel, agent: Agent) -> None:
    before = agent.table()
    agent.q[0, 3, Action.RIGHT, 1] = 99.0
    travel("right")
    assert agent.table() == pytest.approx(before)


class LostStage(MazeStage):
    """The robot believes to be one cell further right than it is, in no free cell at first."""

    def place(self, cell: Cell) -> Observation:
        super().place(cell)
        return Observation(cell, Cell(1, 0))

    def act(self, action: int, clock: Clock, sink: Sink) -> ActionResult:
        result = super().act(action, clock, sink)
        sink(Tick(clock, Pose(0, 0, 0), Pose(0, 0, 0), np.zeros(180)))
        seen = result.observation
        return replace(result, observation=Observation(Cell(0, min(seen.cell.col + 1, 6)), seen.cell))


@pytest.fixture
def lost(agent: Agent) -> tuple[list[Visit], list[Event]]:
    blocked = np.array([[False] * 7, [True] * 7])
    maze = Maze(blocked, CORRIDOR.goals, CORRIDOR.starts)
    padded = Agent.for_maze(maze, agent.config)
    padded.q[0] = agent.q[0]
    events: list[Event] = []
    journey = Journey(LostStage(maze), FRAME, padded, np.random.default_rng(0), events.append, NoWishes())
    return journey.run(["right"], Cell(0, 3), stay=False), events


def test_believing_to_have_arrived_elsewhere_is_a_false_arrival(lost: tuple[list[Visit], list[Event]]) -> None:
    visits, events = lost
    assert visits[0].outcome == "false-arrival"
    ended = of_kind(events, TrialEnded)[0]
    assert isinstance(ended, TrialEnded)
    assert ended.cause == "mislocalized"


def test_a_robot_in_no_free_cell_has_the_shortest_way_of_where_it_believes_to_be(
    lost: tuple[list[Visit], list[Event]],
) -> None:
    assert lost[0][0].shortest == 3


def test_the_ticks_of_an_action_carry_its_number(lost: tuple[list[Visit], list[Event]]) -> None:
    _, events = lost
    assert [tick.clock.step for tick in of_kind(events, Tick)] == [s.clock.step for s in of_kind(events, StepTaken)]


def test_a_goal_that_is_reached_with_the_last_action_is_reached(travel: Travel, agent: Agent) -> None:
    agent.config = replace(agent.config, trial_limit_steps=3)
    visits, _ = travel("right")
    assert visits == [Visit("right", "reached", 3, 3)]


def test_a_robot_without_a_goal_can_be_kidnapped_at_once(travel: Travel) -> None:
    class Kidnapper(FakeWishes):
        def next_goal(self, wait: bool) -> str | None:
            if wait and len(self.afterwards) == 2:
                self.kidnaps[self.looks] = True
            return super().next_goal(wait)

    wishes = Kidnapper()
    wishes.afterwards = [None, "left"]
    visits, events = travel("right", wishes=wishes, stay=True)
    (carried,) = of_kind(events, Kidnapped)
    assert isinstance(carried, Kidnapped)
    from_there = FRAME.cell_at(carried.pose_after.x_m, carried.pose_after.y_m).col
    assert visits == [Visit("right", "reached", 3, 3), Visit("left", "reached", from_there, from_there)]


def test_a_move_without_a_goal_is_answered_with_a_note(travel: Travel) -> None:
    wishes = FakeWishes(moves={3: int(Action.LEFT)})
    visits, events = travel("right", wishes=wishes, stay=True)
    assert [visit.outcome for visit in visits] == ["reached"]
    (note,) = of_kind(events, Note)
    assert isinstance(note, Note)
    assert "name a goal" in note.text


def test_a_goal_that_is_added_on_the_way_is_driven_to_without_a_step_to_learn_it(travel: Travel, agent: Agent) -> None:
    wishes = FakeWishes(new_goals={1: GoalWish("plant", FRAME.centre_of(Cell(0, 1)))}, goals={2: "plant"})
    visits, events = travel("right", wishes=wishes)
    assert visits == [Visit("right", "given-up", 1, 3), Visit("plant", "reached", 3, 3)]
    assert agent.goal_names == ["left", "right", "plant"]
    kinds = [type(event) for event in events]
    at = kinds.index(GoalAdded)
    assert kinds[at - 1 : at + 4] == [StepTaken, GoalAdded, QSnapshot, Note, TrialEnded]
    assert events[at] == GoalAdded(Clock(0, 1), "plant", Cell(0, 1))
    snapshot, note = events[at + 1 : at + 3]
    assert isinstance(snapshot, QSnapshot)
    assert snapshot.q.shape == (3, 1, 7, 4)
    assert isinstance(note, Note)
    assert note.level == "INFO"
    assert re.fullmatch(
        r"plant: learned in \d+\.\d ms, no step taken; 0 of 7 cells without a known way; from 841 remembered actions",
        note.text,
    )


def test_a_goal_without_a_place_is_added_where_the_robot_believes_to_be(travel: Travel, agent: Agent) -> None:
    travel("right", wishes=FakeWishes(new_goals={2: GoalWish("here")}))
    assert agent.goal_cells[2] == Cell(0, 5)


def test_the_stage_and_the_journey_have_the_new_goal_in_their_maze(agent: Agent) -> None:
    stage = MazeStage(CORRIDOR)
    wishes = FakeWishes(new_goals={0: GoalWish("here")})
    journey = Journey(stage, FRAME, agent, np.random.default_rng(0), lambda event: None, wishes)
    journey.run(["right"], Cell(0, 3), stay=False)
    assert stage.maze.goals == journey.maze.goals == {**CORRIDOR.goals, "here": Cell(0, 3)}
    agent.check_fits(stage.maze)


@pytest.mark.parametrize(
    ("wish", "why"),
    [
        (GoalWish("plant", (9.0, 0.2)), "outside the map: choose x from -0.4 to 2.4 and y from 0.0 to 0.4"),
        (GoalWish("right", (0.6, 0.2)), "already"),
        (GoalWish("<plant>", (0.6, 0.2)), "no name for a goal"),
    ],
)
def test_a_goal_that_cannot_be_added_is_noted_and_the_robot_drives_on(
    travel: Travel, agent: Agent, wish: GoalWish, why: str
) -> None:
    visits, events = travel("right", wishes=FakeWishes(new_goals={1: wish}))
    assert visits == [Visit("right", "reached", 3, 3)]
    (note,) = of_kind(events, Note)
    assert isinstance(note, Note)
    assert note.level == "WARN"
    assert why in note.text
    assert not of_kind(events, GoalAdded)
    assert agent.table().shape[0] == 2


def test_a_place_on_a_wall_is_answered_with_the_nearest_free_cell() -> None:
    maze = Maze(np.array([[False, True, True, False]]), {}, {})
    frame = GridFrame(0.0, 0.0, 1.0, 1, 4)
    assert cell_at_place(maze, frame, 0.9, 0.1) == Cell(0, 0)
    with pytest.raises(
        TwonavError, match=r"cannot stand at \(1.9, 0.5\) m: the nearest free cell is at \(0.50, 0.50\)"
    ):
        cell_at_place(maze, frame, 1.9, 0.5)


def test_a_goal_can_be_added_while_the_robot_waits_for_one(travel: Travel) -> None:
    class Adder(FakeWishes):
        def next_goal(self, wait: bool) -> str | None:
            if wait and len(self.afterwards) == 2:
                self.new_goals[self.looks] = GoalWish("plant", FRAME.centre_of(Cell(0, 1)))
            return super().next_goal(wait)

    wishes = Adder()
    wishes.afterwards = [None, "plant"]
    visits, _ = travel("right", wishes=wishes, stay=True)
    assert visits == [Visit("right", "reached", 3, 3), Visit("plant", "reached", 5, 5)]
