"""The 3D stage in the kitchen: what is done, what is believed, and that they are two things."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.belief import Belief
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Event, Filtered, Tick, to_nobody
from twonav_cli.geometry import Pose, compose, distance_m
from twonav_cli.grid import Cell, GridFrame
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.maze import Action
from twonav_cli.navigation.outcomes import BLOCKED, REACHED
from twonav_cli.stages.localize import STILL, Image, Located
from twonav_cli.stages.sim3d_stage import Sim3dOptions, Sim3dStage

CLOCK = Clock(3, 7, 0.0)


@pytest.fixture(scope="module")
def floor(tmp_path_factory: pytest.TempPathFactory) -> Floor:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TWONAV_RUNS", str(tmp_path_factory.mktemp("runs")))
        return read_floor("kitchen")


@pytest.fixture(scope="module")
def shared(floor: Floor) -> Iterator[Sim3dStage]:
    stage = Sim3dStage(floor, None, seed=0)
    yield stage
    stage.close()


@pytest.fixture
def stage(shared: Sim3dStage, monkeypatch: pytest.MonkeyPatch) -> Sim3dStage:
    """Return the stage with the simulator's truth."""
    monkeypatch.setattr(shared, "localize", None)
    return shared


class Liar:
    """A localizer that makes something else of the truth, and remembers what it was told."""

    def __init__(self, lie: Callable[[], Pose]) -> None:
        self.lie = lie
        self.told: list[Pose | str] = []

    def __call__(self, image: Image, motion: Pose) -> Located:
        self.told.append(motion)
        return Located(self.lie())

    def forget(self) -> None:
        self.told.append("forget")

    def draw_from(self, rng: np.random.Generator) -> None:
        self.told.append("draw")


MakeLiar = Callable[[Callable[[Pose], Pose]], Sim3dStage]


@pytest.fixture
def lying(shared: Sim3dStage, monkeypatch: pytest.MonkeyPatch) -> MakeLiar:
    """Return a function that gives the stage a localizer which makes something else of the truth."""

    def make(lie: Callable[[Pose], Pose]) -> Sim3dStage:
        monkeypatch.setattr(shared, "localize", Liar(lambda: lie(shared.world.pose())))
        return shared

    return make


def free_with_free_neighbours(floor: Floor) -> Cell:
    """Return the first cell whose eight neighbours are free too."""
    blocked = floor.maze.blocked
    return next(
        cell
        for cell in floor.maze.free_cells
        if 0 < cell.row < floor.maze.rows - 1
        and 0 < cell.col < floor.maze.cols - 1
        and not blocked[cell.row - 1 : cell.row + 2, cell.col - 1 : cell.col + 2].any()
    )


def beside_the_left_wall(floor: Floor) -> Cell:
    """Return the start in the lower left corner of the room."""
    cell = floor.maze.starts["s1"]
    assert floor.maze.blocked[cell.row, cell.col - 1]
    return cell


def test_a_robot_that_is_placed_stands_in_the_middle_of_its_cell(stage: Sim3dStage, floor: Floor) -> None:
    cell = free_with_free_neighbours(floor)
    seen = stage.place(cell)
    assert seen.cell == seen.true_cell == cell
    assert seen.pose_true is not None
    assert seen.pose_true[:2] == pytest.approx(floor.maze_frame.centre_of(cell), abs=1e-9)


def test_looking_gives_a_picture_and_the_pose_it_was_taken_at(stage: Sim3dStage, floor: Floor) -> None:
    seen = stage.place(free_with_free_neighbours(floor))
    assert seen.image is not None
    assert (seen.image.shape, seen.image.dtype) == ((84, 84, 3), np.uint8)
    assert seen.image.std() > 5
    assert seen.pose_estimate == seen.pose_true == stage.world.pose()


def test_at_a_start_the_robot_looks_where_the_scene_says(stage: Sim3dStage, floor: Floor) -> None:
    for name, cell in floor.maze.starts.items():
        pose = stage.place(cell).pose_true
        assert pose is not None
        turn_rad = pose.theta_rad - floor.scene.starts[name].theta_rad
        assert np.cos(turn_rad) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize("action", list(Action))
def test_an_action_reaches_the_neighbour_in_its_direction(stage: Sim3dStage, floor: Floor, action: Action) -> None:
    cell = free_with_free_neighbours(floor)
    stage.place(cell)
    result = stage.act(action, CLOCK, to_nobody)
    assert result.outcome == REACHED
    assert result.observation.cell == result.observation.true_cell == floor.maze.moved(cell, action)


def test_a_wall_is_reported_blocked_and_the_robot_stays_in_its_cell(stage: Sim3dStage, floor: Floor) -> None:
    cell = beside_the_left_wall(floor)
    stage.place(cell)
    before = stage.collisions
    result = stage.act(Action.LEFT, CLOCK, to_nobody)
    assert result.outcome == BLOCKED
    assert result.observation.true_cell == cell
    assert stage.collisions == before


def test_the_clock_goes_on_while_driving_and_every_tick_tells_it(stage: Sim3dStage, floor: Floor) -> None:
    stage.place(free_with_free_neighbours(floor))
    events: list[Event] = []
    begun_s = stage.time_s
    stage.act(Action.UP, CLOCK, events.append)
    ticks = [event for event in events if isinstance(event, Tick)]
    assert len(ticks) == len(events) >= 5
    times_s = [tick.clock.time_s for tick in ticks]
    assert times_s == sorted(set(times_s))
    assert times_s[0] == begun_s
    assert stage.time_s > times_s[-1]
    assert {(tick.clock.trial, tick.clock.step) for tick in ticks} == {(3, 7)}
    assert all(tick.scan_m.shape == (180,) and tick.image is None and tick.drive is None for tick in ticks)


def test_pictures_and_what_the_controller_weighed_are_sent_when_asked_for(
    stage: Sim3dStage, floor: Floor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(stage, "options", replace(stage.options, image_every_tick=True, trace=True))
    stage.place(free_with_free_neighbours(floor))
    events: list[Event] = []
    stage.act(Action.UP, CLOCK, events.append)
    assert all(isinstance(event, Tick) and event.image is not None for event in events)
    assert any(isinstance(event, Tick) and event.drive is not None for event in events)


def test_between_two_looks_the_believed_pose_drifts_from_the_true_one(stage: Sim3dStage, floor: Floor) -> None:
    stage.place(free_with_free_neighbours(floor))
    ticks: list[Tick] = []
    stage.act(Action.UP, CLOCK, lambda event: ticks.append(event) if isinstance(event, Tick) else None)
    assert ticks[0].pose_believed == ticks[0].pose_true
    assert 0 < distance_m(ticks[-1].pose_believed, ticks[-1].pose_true) < 0.1


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_the_same_seed_gives_the_same_result_and_another_one_does_not(floor: Floor, base: str) -> None:
    def driven(seed: int) -> tuple[Pose | None, float]:
        stage = Sim3dStage(floor, None, seed, Sim3dOptions(base=base))
        stage.place(floor.maze.starts["s4"])
        observation = stage.act(Action.DOWN, CLOCK, to_nobody).observation
        stage.close()
        return observation.pose_true, stage.time_s

    assert driven(5) == driven(5)
    assert driven(5) != driven(6)


def test_a_lying_localizer_changes_the_believed_cell_but_not_the_true_one(lying: MakeLiar, floor: Floor) -> None:
    cell = free_with_free_neighbours(floor)
    stage = lying(lambda pose: pose._replace(x_m=pose.x_m + 0.4))
    seen = stage.place(cell)
    assert seen.true_cell == cell
    assert seen.cell == Cell(cell.row, cell.col + 1)
    assert seen.pose_true == stage.world.pose()
    assert seen.pose_estimate != seen.pose_true


def test_the_robot_drives_by_what_it_believes(lying: MakeLiar, floor: Floor) -> None:
    cell = free_with_free_neighbours(floor)
    stage = lying(lambda pose: pose._replace(x_m=pose.x_m + 0.15))
    stage.place(cell)
    after = stage.act(Action.UP, CLOCK, to_nobody).observation
    assert after.pose_true is not None
    centre_x_m, _ = floor.maze_frame.centre_of(cell)
    assert after.pose_true.x_m == pytest.approx(centre_x_m - 0.15, abs=0.08)


def test_an_estimate_in_a_wall_means_the_free_cell_beside_it(lying: MakeLiar, floor: Floor) -> None:
    cell = beside_the_left_wall(floor)
    stage = lying(lambda pose: pose._replace(x_m=pose.x_m - 0.4))
    seen = stage.place(cell)
    assert seen.pose_estimate is not None
    assert floor.maze.blocked[floor.maze_frame.cell_at(seen.pose_estimate.x_m, seen.pose_estimate.y_m)]
    assert seen.cell == cell


def test_an_estimate_far_outside_still_means_a_free_cell(lying: MakeLiar, floor: Floor) -> None:
    seen = lying(lambda pose: Pose(-50.0, 80.0, 0.0)).place(beside_the_left_wall(floor))
    assert not floor.maze.blocked[seen.cell]


def test_the_localizer_is_told_what_odometry_reported_since_the_last_look(lying: MakeLiar, floor: Floor) -> None:
    stage = lying(lambda pose: pose)
    assert isinstance(stage.localize, Liar)
    before = stage.place(free_with_free_neighbours(floor)).pose_true
    ticks: list[Tick] = []
    after = stage.act(Action.UP, CLOCK, lambda event: ticks.append(event) if isinstance(event, Tick) else None)
    assert before is not None
    assert after.observation.pose_true is not None
    assert stage.localize.told[:2] == ["forget", STILL]
    (motion,) = stage.localize.told[2:]
    assert isinstance(motion, Pose)
    reported = compose(before, motion)
    assert 0 < distance_m(reported, after.observation.pose_true) < 0.1
    assert distance_m(reported, ticks[-1].pose_believed) < 0.05


def test_a_robot_that_is_carried_looks_but_is_not_told(lying: MakeLiar, floor: Floor) -> None:
    stage = lying(lambda pose: pose)
    assert isinstance(stage.localize, Liar)
    stage.place(floor.maze.starts["s1"])
    seen = stage.carry(free_with_free_neighbours(floor))
    assert seen.true_cell == free_with_free_neighbours(floor)
    assert stage.localize.told == ["forget", STILL, STILL]


def test_a_robot_is_carried_only_where_it_touches_nothing(
    stage: Sim3dStage, floor: Floor, monkeypatch: pytest.MonkeyPatch
) -> None:
    headings: list[float] = []

    def touching() -> list[str]:
        headings.append(stage.world.pose().theta_rad)
        return ["chair"] if len(headings) < 3 else []

    with monkeypatch.context() as patch:
        patch.setattr(stage.world, "touching", touching)
        seen = stage.carry(free_with_free_neighbours(floor))
    assert seen.pose_true is not None
    assert len(set(headings)) == 3
    assert seen.pose_true.theta_rad == pytest.approx(headings[-1])
    monkeypatch.setattr(stage.world, "touching", lambda: ["chair"])
    with pytest.raises(TwonavError, match="whichever way it looks"):
        stage.carry(free_with_free_neighbours(floor))


def test_what_the_localizer_says_of_a_picture_is_seen(shared: Sim3dStage, floor: Floor) -> None:
    class Sure(Liar):
        def __call__(self, image: Image, motion: Pose) -> Located:
            return Located(Pose(1.0, 2.0, 0.5), belief, filtered)

    belief = Belief(np.ones((1, 4)), np.ones((1, 3)), 0.1, 60.0, np.ones((1, 1), np.float32), GridFrame(0, 0, 1, 1, 1))
    filtered = Filtered(0.9, 0.1, 0.1, np.zeros((2, 3), np.float32), np.zeros((0, 3)))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(shared, "localize", Sure(lambda: STILL))
        seen = shared.place(free_with_free_neighbours(floor))
    assert (seen.pose_estimate, seen.belief, seen.filtered) == (Pose(1.0, 2.0, 0.5), belief, filtered)


def test_a_trial_that_draws_from_its_own_stream_repeats_whatever_came_before(stage: Sim3dStage, floor: Floor) -> None:
    cell, ways = free_with_free_neighbours(floor), []
    for before in (0, 2):
        stage.place(cell)
        for _ in range(before):
            stage.act(0, CLOCK, to_nobody)
        stage.draw_from(np.random.default_rng(9))
        stage.place(cell)
        ways.append([stage.act(a, CLOCK, to_nobody).observation.pose_true for a in (0, 3, 1)])
    assert ways[0] == ways[1]
