"""A way in the maze that the robot's body cannot take is refused before anything is learned."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.mapping.approximate import approximate_maze
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.mapping.occupancy import OccupancyMap
from twonav_cli.scene.catalog import scene_names
from twonav_cli.stages.fitting import check_robot_fits


@pytest.fixture
def floor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Floor:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    return read_floor("kitchen")


def with_walls(floor: Floor, *boxes: tuple[float, float, float, float]) -> Floor:
    """Return the floor with boxes (x from, x to, y from, y to) that the maze does not know."""
    frame, occupied = floor.map.frame, floor.map.occupied.copy()
    xs, ys = frame.centres()
    for x_low, x_high, y_low, y_high in boxes:
        occupied[np.ix_((ys > y_low) & (ys < y_high), (xs > x_low) & (xs < x_high))] = True
    pixels = np.where(occupied, np.uint8(0), floor.map.pixels)
    return replace(floor, map=replace(floor.map, pixels=pixels))


@pytest.mark.parametrize("name", scene_names())
def test_the_robot_gets_everywhere_in_the_shipped_scenes(name: str) -> None:
    check_robot_fits(read_floor(name))


def test_a_goal_that_is_walled_in_is_named(floor: Floor) -> None:
    name, cell = next(iter(floor.maze.goals.items()))
    x, y = floor.maze_frame.centre_of(cell)
    tight = with_walls(floor, (x - 0.2, x - 0.1, y - 0.2, y + 0.2), (x + 0.1, x + 0.2, y - 0.2, y + 0.2))
    with pytest.raises(TwonavError, match=f"does not fit into the cell of goal {name!r}.*0.38 m"):
        check_robot_fits(tight)


@pytest.mark.parametrize(("gap_m", "fits"), [(0.5, True), (0.25, False)])
def test_a_doorway_narrower_than_the_robot_is_refused(floor: Floor, gap_m: float, fits: bool) -> None:
    frame = floor.map.frame
    occupied = np.zeros(frame.shape, dtype=bool)
    xs, ys = frame.centres()
    middle = 3.6
    border = (xs < 0.05) | (xs > 6.95)
    occupied[:, border] = True
    occupied[(ys < 0.05) | (ys > 4.95)] = True
    occupied[np.ix_(np.abs(ys - 2.4) > gap_m / 2, np.abs(xs - middle) < 0.06)] = True
    map_ = OccupancyMap.from_occupied(occupied, frame)
    open_map = OccupancyMap.from_occupied(occupied & (np.abs(xs - middle) >= 0.06)[None, :], frame)
    goals, starts = dict([next(iter(floor.scene.goals.items()))]), dict([next(iter(floor.scene.starts.items()))])
    goals = {name: pose._replace(x_m=5.4, y_m=2.4) for name, pose in goals.items()}
    starts = {name: pose._replace(x_m=1.4, y_m=2.4) for name, pose in starts.items()}
    maze, maze_frame = approximate_maze(open_map, goals, starts)
    narrow = replace(floor, map=map_, maze=maze, maze_frame=maze_frame)
    if fits:
        check_robot_fits(narrow)
        return
    with pytest.raises(TwonavError, match=r"does not get from start .* to goal .* less than its 0\.38 m"):
        check_robot_fits(narrow)
