"""The 2D stage in the kitchen: the robot knows where it is, and its outline decides where it can go."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, Event, Tick, to_nobody
from twonav_cli.grid import Cell
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.maze import Action
from twonav_cli.navigation.outcomes import BLOCKED, REACHED
from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage

CLOCK = Clock(3, 7, 0.0)


@pytest.fixture(scope="module")
def floor(tmp_path_factory: pytest.TempPathFactory) -> Floor:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TWONAV_RUNS", str(tmp_path_factory.mktemp("runs")))
        return read_floor("kitchen")


def open_cell(floor: Floor) -> Cell:
    """Return the first cell whose eight neighbours are free too."""
    blocked = np.pad(floor.maze.blocked, 1, constant_values=True)
    return next(c for c in floor.maze.free_cells if not blocked[c.row : c.row + 3, c.col : c.col + 3].any())


@pytest.mark.parametrize("base", ["omni", "differential"])
@pytest.mark.parametrize("action", list(Action))
def test_an_action_reaches_the_neighbour_in_its_direction(floor: Floor, base: str, action: Action) -> None:
    stage, cell = Sim2dStage(floor, 0, Sim2dOptions(base=base)), open_cell(floor)
    assert stage.place(cell).cell == cell
    result = stage.act(action, CLOCK, to_nobody)
    assert result.outcome == REACHED
    assert result.observation.cell == result.observation.true_cell == floor.maze.moved(cell, action) != cell
    assert result.plausible
    assert stage.time_s > 0.5


def test_the_robot_knows_where_it_is(floor: Floor) -> None:
    stage = Sim2dStage(floor, 0)
    seen = stage.place(open_cell(floor))
    for action in (0, 2, 1, 3):
        assert seen.pose_estimate == seen.pose_true == stage.body.pose()
        assert seen.image is None
        seen = stage.act(action, CLOCK, to_nobody).observation


def test_a_wall_blocks_and_the_robot_stays_in_its_cell(floor: Floor) -> None:
    stage, maze = Sim2dStage(floor, 0), floor.maze
    cell = maze.starts["s1"]
    action = next(a for a in Action if maze.moved(cell, a) == cell)
    stage.place(cell)
    result = stage.act(action, CLOCK, to_nobody)
    assert (result.outcome, result.observation.cell) == (BLOCKED, cell)


def test_at_a_start_the_robot_looks_where_the_scene_says(floor: Floor) -> None:
    stage = Sim2dStage(floor, 0)
    for name, cell in floor.maze.starts.items():
        pose = stage.place(cell).pose_true
        assert pose is not None
        assert np.cos(pose.theta_rad - floor.scene.starts[name].theta_rad) == pytest.approx(1.0)


def test_the_same_seed_gives_the_same_way_and_watching_changes_nothing(floor: Floor) -> None:
    ways = []
    for options in (Sim2dOptions(), Sim2dOptions(), Sim2dOptions(ticks=True), Sim2dOptions(trace=True)):
        stage, events = Sim2dStage(floor, 5, options), list[Event]()
        stage.place(open_cell(floor))
        ways.append([stage.act(a, CLOCK, events.append).observation.pose_true for a in (0, 3, 3, 1, 2, 0)])
        ticks = [event for event in events if isinstance(event, Tick)]
        assert (len(ticks) > 40) == (options.ticks or options.trace)
        assert any(tick.drive is not None for tick in ticks) == options.trace
    for way in ways[1:]:
        assert np.allclose(way, ways[0], atol=1e-12)
    other = Sim2dStage(floor, 6)
    other.place(open_cell(floor))
    assert other.act(0, CLOCK, to_nobody).observation.pose_true != ways[0][0]


def test_a_cell_in_which_the_robot_fits_no_way_is_refused(floor: Floor) -> None:
    cell = open_cell(floor)
    occupied = floor.map.occupied.copy()
    x_m, y_m = floor.maze_frame.centre_of(cell)
    pixel = floor.map.frame.cell_at(x_m, y_m)
    occupied[pixel.row, pixel.col - 4], occupied[pixel.row, pixel.col + 4] = True, True
    occupied[pixel.row - 4, pixel.col], occupied[pixel.row + 4, pixel.col] = True, True
    walled = replace(floor, map=made_of(floor.map, occupied))
    with pytest.raises(TwonavError, match="does not fit into the cell"):
        Sim2dStage(walled, 0).place(cell)


def made_of(map_: OccupancyMap, occupied: np.ndarray) -> OccupancyMap:
    """Return a map with other occupied pixels."""
    return replace(map_, pixels=np.where(occupied, np.uint8(0), map_.pixels))


def test_in_tight_places_some_actions_end_otherwise_than_in_the_maze(floor: Floor) -> None:
    stage, rng = Sim2dStage(floor, 0, Sim2dOptions(base="differential")), np.random.default_rng(0)
    cells, as_in_maze, blocked_though_free = floor.maze.free_cells, 0, 0
    for _ in range(20):
        seen = stage.place(cells[int(rng.integers(len(cells)))])
        for action in rng.integers(len(Action), size=10):
            before, should = seen.true_cell, floor.maze.moved(seen.cell, Action(action))
            result = stage.act(int(action), CLOCK, to_nobody)
            seen = result.observation
            as_in_maze += seen.true_cell == should
            blocked_though_free += result.outcome == BLOCKED and should != before
    assert blocked_though_free > 0
    assert 180 <= as_in_maze < 200


def test_a_trial_that_draws_from_its_own_stream_repeats_whatever_came_before(floor: Floor) -> None:
    stage, cell, ways = Sim2dStage(floor, 0), open_cell(floor), []
    for before in (0, 3):
        stage.place(cell)
        for _ in range(before):
            stage.act(0, CLOCK, to_nobody)
        stage.draw_from(np.random.default_rng(9))
        stage.place(cell)
        ways.append([stage.act(a, CLOCK, to_nobody).observation.pose_true for a in (0, 3, 1)])
    assert ways[0] == ways[1]
