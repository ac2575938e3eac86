"""The maze as a stage."""

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, to_nobody
from twonav_cli.grid import Cell
from twonav_cli.maze import Action, Maze
from twonav_cli.navigation.outcomes import BLOCKED, REACHED
from twonav_cli.stages.maze_stage import MazeStage

BLOCKED_CELLS = np.array([[False, True], [False, False]])


@pytest.fixture
def stage() -> MazeStage:
    return MazeStage(Maze(BLOCKED_CELLS, {"g": Cell(1, 1)}, {"s": Cell(0, 0)}))


def test_a_move_into_a_free_cell_is_reached(stage: MazeStage) -> None:
    stage.place(Cell(0, 0))
    result = stage.act(Action.DOWN, Clock(), to_nobody)
    assert result.outcome == REACHED
    assert result.observation.cell == result.observation.true_cell == Cell(1, 0)


@pytest.mark.parametrize("action", [Action.UP, Action.LEFT, Action.RIGHT])
def test_walls_and_borders_block_and_leave_the_robot_where_it_is(stage: MazeStage, action: Action) -> None:
    stage.place(Cell(0, 0))
    result = stage.act(action, Clock(), to_nobody)
    assert result.outcome == BLOCKED
    assert result.observation.cell == Cell(0, 0)


@pytest.mark.parametrize("cell", [Cell(0, 1), Cell(-1, 0), Cell(0, 9)])
def test_a_start_in_a_wall_or_outside_is_refused(stage: MazeStage, cell: Cell) -> None:
    with pytest.raises(TwonavError, match="choose a free one"):
        stage.place(cell)


def test_a_robot_that_is_carried_knows_where_it_is(stage: MazeStage) -> None:
    stage.place(Cell(0, 0))
    seen = stage.carry(Cell(1, 1))
    assert seen.cell == seen.true_cell == Cell(1, 1)


def test_acting_before_being_placed_is_refused(stage: MazeStage) -> None:
    with pytest.raises(TwonavError, match="place it"):
        stage.act(Action.UP, Clock(), to_nobody)
