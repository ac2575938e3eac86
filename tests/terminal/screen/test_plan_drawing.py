"""The floor plan in characters."""

from __future__ import annotations

import math

import numpy as np
import pytest
from fake_game import FRAME, GOALS, MAZE_FRAME, fake_map, fake_maze

from twonav_cli.belief import Belief
from twonav_cli.geometry import Pose
from twonav_cli.grid import GridFrame
from twonav_cli.terminal.screen import palette
from twonav_cli.terminal.screen.floor_plan import Plan, fitted, plan_of_map
from twonav_cli.terminal.screen.plan_drawing import Marks, draw_plan, draw_scene, heading_glyph


def small_plan() -> Plan:
    """4 x 2 m at 0.5 m a pixel: one character is one pixel wide and two high; a wall at the left, one goal."""
    occupied = np.zeros((4, 8), dtype=bool)
    occupied[:, 0] = True
    return plan_of_map(occupied, GridFrame(-1.0, -1.0, 0.5, 4, 8), {"sofa": (2.75, 0.75)}, {}, None)


def lines(picture) -> list[str]:
    return picture.text().plain.split("\n")


def test_ascii_shows_walls_floor_and_the_goals_key() -> None:
    assert lines(draw_plan(small_plan(), Marks(), 2, 8, coloured=False)) == ["#......1", "#......."]


def test_a_wall_thinner_than_a_character_is_not_lost_without_colour() -> None:
    occupied = np.zeros((40, 40), dtype=bool)
    occupied[13, :20] = True
    plan = plan_of_map(occupied, GridFrame(0, 0, 0.05, 40, 40), {}, {}, None)
    assert lines(draw_plan(plan, Marks(), 2, 4, coloured=False)) == ["##..", "...."]


def test_the_robot_stands_where_its_pose_is_and_its_estimate_beside_it() -> None:
    marks = Marks(pose_true=Pose(0.75, -0.75, 0), pose_estimate=Pose(1.25, -0.75, 0))
    assert lines(draw_plan(small_plan(), marks, 2, 8, coloured=False))[1] == "#..@&..."


def doubtful() -> Belief:
    """Half of 0.9 in each bin at (0.75, 0.75), half of 0.03 in each at (2.25, -0.75): two bins make a character."""
    grid = np.zeros((2, 8), dtype=np.float32)
    grid[0, 3], grid[1, 6] = 0.9, 0.03
    frame = GridFrame(-1.0, -1.0, 0.5, 4, 8)
    bins = np.repeat(grid / 2, 2, axis=0)
    return Belief(np.array([(1.0, 0.75, 0.75, 0.1)]), np.array([(1.0, 0.0, 0.1)]), 0.0, 4.0, bins, frame)


def test_the_belief_is_a_heat_on_the_floor_the_likelier_the_paler() -> None:
    plain, picture = (draw_plan(small_plan(), Marks(belief=said), 2, 8) for said in (None, doubtful()))
    changed = np.argwhere((picture.paper != plain.paper).any(axis=-1)).tolist()
    assert changed == [[0, 3], [1, 6]]
    likely, unlikely = picture.paper[0, 3].sum(), picture.paper[1, 6].sum()
    assert likely > unlikely + 100
    assert unlikely > plain.paper[1, 6].sum() + 50


def test_without_colour_the_belief_is_written_in_characters() -> None:
    drawn = lines(draw_plan(small_plan(), Marks(belief=doubtful()), 2, 8, coloured=False))
    assert drawn == ["#..%...1", "#.....:."]


def test_a_wall_is_never_heated() -> None:
    said = doubtful()
    said.grid[:, 0] = 0.5
    plain, picture = (draw_plan(small_plan(), Marks(belief=shown), 2, 8) for shown in (None, said))
    assert (picture.paper[:, 0] == plain.paper[:, 0]).all()


def test_no_arrow_stands_where_the_belief_is() -> None:
    plan = plan_of_map(np.zeros((4, 8), bool), GridFrame(-1, -1, 0.5, 4, 8), {}, {}, GridFrame(-1, -1, 0.5, 4, 8))
    arrows = np.zeros((4, 8), dtype=np.int8)
    drawn = draw_plan(plan, Marks(arrows=arrows, belief=doubtful()), 2, 8, coloured=False)
    assert lines(drawn) == ["^^^%^^^^", "^^^^^^:^"]


def test_a_sharp_belief_is_seen_on_a_sheet_whose_characters_are_wider_than_its_bins() -> None:
    frame = GridFrame(0, 0, 0.1, 40, 80)
    plan = plan_of_map(np.zeros((40, 80), bool), frame, {}, {}, None)
    for col in range(80):
        grid = np.zeros((40, 80), dtype=np.float32)
        grid[21, col] = 1.0
        said = Belief(np.ones((1, 4)), np.ones((1, 3)), 0.0, 32.0, grid, frame)
        drawn = lines(draw_plan(plan, Marks(belief=said), 4, 16, coloured=False))
        assert drawn[2] == "." * (col // 5) + "%" + "." * (15 - col // 5)


@pytest.mark.parametrize("coloured", [True, False])
def test_other_places_are_question_marks_under_the_robot(coloured: bool) -> None:
    marks = Marks(pose_true=Pose(0.75, -0.75, 0), others=((0.75, -0.75), (1.75, -0.75)))
    drawn = draw_plan(small_plan(), marks, 2, 8, coloured)
    assert drawn.glyphs[1, 5] == "?"
    assert drawn.glyphs[1, 3] == ("→" if coloured else "@")


def test_true_pose_is_cyan_and_estimate_magenta() -> None:
    marks = Marks(pose_true=Pose(0.75, -0.75, 0), pose_estimate=Pose(1.25, -0.75, math.pi))
    picture = draw_plan(small_plan(), marks, 2, 8)
    assert tuple(picture.paper[1, 3]) == palette.TRUE
    assert tuple(picture.paper[1, 4]) == palette.ESTIMATE
    assert "".join(picture.glyphs[1, 3:5]) == "→←"


def test_arrows_point_along_the_best_action_of_the_cell_beneath() -> None:
    plan = plan_of_map(np.zeros((4, 8), bool), GridFrame(0, 0, 0.5, 4, 8), {}, {}, GridFrame(0, 0, 1.0, 2, 4))
    arrows = np.array([[0, 1, 2, 3], [-1, 0, 0, 0]], dtype=np.int8)
    assert lines(draw_plan(plan, Marks(arrows=arrows), 2, 8, coloured=False)) == ["^.v.<.>.", "..^.^.^."]


def test_no_arrow_stands_in_a_wall() -> None:
    maze = fake_maze()
    plan = plan_of_map(fake_map(maze), FRAME, {"sofa": MAZE_FRAME.centre_of(GOALS["sofa"])}, {}, MAZE_FRAME)
    arrows = np.zeros(maze.blocked.shape, dtype=np.int8)
    drawn = draw_plan(plan, Marks(arrows=arrows), 24, 47, coloured=False)
    places = np.argwhere(drawn.glyphs == "^")
    assert len(places) > 200
    for row, col in places:
        y_m = FRAME.y_max_m - (row + 0.5) * 9.6 / drawn.rows
        x_m = FRAME.x_min_m + (col + 0.5) * 18.8 / drawn.cols
        assert not plan.occupied[FRAME.cell_at(x_m, y_m)]


def test_the_current_goal_carries_its_name_even_at_the_border() -> None:
    picture = draw_plan(small_plan(), Marks(goal="sofa"), 2, 8)
    assert "".join(picture.glyphs[0, 2:]) == "1 sofa"
    assert tuple(picture.paper[0, 7]) == palette.CURRENT_GOAL


@pytest.mark.parametrize(("rows", "cols"), [(13, 50), (20, 76), (24, 94), (60, 40), (1, 1)])
def test_a_drawing_keeps_its_shape_and_never_outgrows_its_space(rows: int, cols: int) -> None:
    sheet = fitted(plan_of_map(fake_map(fake_maze()), FRAME, {}), rows, cols)
    assert 1 <= sheet.rows <= rows
    assert 1 <= sheet.cols <= cols
    assert cols < 10 or sheet.cols / sheet.rows == pytest.approx(2 * 18.8 / 9.6, rel=0.1)


@pytest.mark.parametrize("cols", [80, 120])
@pytest.mark.parametrize("coloured", [True, False])
def test_a_printed_scene_lists_every_goal_and_fits_the_width(cols: int, coloured: bool) -> None:
    maze = fake_maze()
    text = draw_scene(maze, MAZE_FRAME, fake_map(maze), FRAME, cols, coloured=coloured).plain
    assert all(name in text for name in maze.goals)
    assert "x  -0.20 m  y   7.70 m" in text
    assert max(len(line) for line in text.split("\n")) <= cols


def test_headings_are_rounded_to_the_nearest_eighth_of_a_turn() -> None:
    assert [heading_glyph(math.radians(a)) for a in (0, 44, 90, 180, -90, 359)] == list("→↗↑←↓→")
