"""What one reads while an agent learns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from small_run import CONFIG, GOALS, STARTS, after, small_maze, small_walk

from twonav_cli.config import LearningConfig
from twonav_cli.terminal.screen.watch_drawing import Heat
from twonav_cli.terminal.screen.watch_keys import TD_ERRORS, VISITS, WatchControls
from twonav_cli.terminal.screen.watch_state import Trial
from twonav_cli.terminal.screen.watch_view import (
    errors_text,
    headline,
    hint_text,
    maze_titles,
    next_action,
    numbers_text,
    rounds_of,
    shown_goal,
    spent,
    status_text,
    trend,
    trial_sentence,
)

HEAT = Heat(np.zeros((5, 6)), 11.13, 100.0, np.zeros((5, 6), dtype=np.int8))
FREE = WatchControls()


@pytest.fixture
def walk():
    return small_walk()


@pytest.fixture
def state(walk):
    return after(walk, 3)


def test_every_goal_has_a_bar_as_long_as_its_error_and_the_marks_it_deserves(state) -> None:
    shown = replace(state, td_errors=np.array([1000.0, 500.0, 2.0]), goal="bed", learned=("desk",))
    sofa, bed, desk = errors_text(shown, FREE, 40, 10).plain.split("\n")
    assert (sofa[:7], bed[:7], desk[:7]) == (" 1 sofa", "▶2 bed ", " 3 desk")
    assert ["✓" in line for line in (sofa, bed, desk)] == [False, False, True]
    assert sofa.endswith("1,000")
    assert sofa.count("█") == pytest.approx(2 * bed.count("█"), abs=1) != 0
    assert desk.count("█") == 0


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_the_current_goal_is_among_the_lines_that_fit(state, rows: int) -> None:
    for goal in GOALS:
        text = errors_text(replace(state, goal=goal), FREE, 30, rows).plain
        assert len(text.split("\n")) == rows
        assert f"▶{list(GOALS).index(goal) + 1} {goal}" in text


def test_the_numbers_say_why_where_and_how_well(walk, state) -> None:
    state = replace(state, recent=(True, True, False), temperature=0.42, learned=("bed",))
    text = numbers_text(state, walk.agent, 78, 10).plain
    assert "sofa: its TD error is the largest (10,000), first of equals" in text
    assert "1 from s1: 3 actions, shortest way 10" in text
    assert "2 of the last 3 trials; temperature 0.42" in text
    assert f"1 of 3 goals in 3 actions; floor {state.floor_steps} (the proof alone)" in text
    assert "how likely each action is" in text


@pytest.mark.parametrize("cols", [12, 30, 78])
@pytest.mark.parametrize("rows", [0, 1, 6, 20])
def test_the_numbers_keep_to_their_space(walk, state, cols: int, rows: int) -> None:
    lines = numbers_text(state, walk.agent, cols, rows).plain.split("\n")
    assert len(lines) <= max(rows, 1)
    assert all(len(line) <= max(cols, 9 + 10) for line in lines)


def test_the_first_trial_is_counted_by_itself(walk, state) -> None:
    assert "1 of 1 trial;" in numbers_text(replace(state, recent=(True,)), walk.agent, 78, 10).plain


def test_the_end_of_a_trial_is_one_sentence(state) -> None:
    ended = replace(state, between=True, last_trial=Trial("s2", 31, 6, True))
    assert trial_sentence(ended).endswith("from s2 reached sofa in 31 actions, shortest way 6")
    failed = replace(ended, last_trial=Trial("s2", 500, 6, False))
    assert trial_sentence(failed).endswith("from s2 gave up after 500 actions, shortest way 6")


def test_the_trend_is_a_block_per_round_and_falls_as_the_ways_get_shorter(state) -> None:
    assert "once one has ended" in trend(state, 60)
    shown = replace(state, curve=(400, 600, 90, 110, 9, 11, 3))
    assert rounds_of(shown) == [500.0, 100.0, 10.0]
    assert trend(shown, 60) == "█▅▁ 500 to 10 actions a trial"
    assert len(trend(replace(state, curve=tuple(range(1, 900))), 60)) == 60
    assert trend(replace(state, curve=(7,)), 60) == "7 actions a trial in the first round"


def test_how_likely_each_action_is_follows_from_the_values_and_the_rule(walk, state) -> None:
    cell, goal = state.cell, walk.agent.goal_names.index(state.goal)
    walk.agent.q[(*cell, slice(None), goal)] = (80.0, 80.0 + 2 * np.log(3), -1e3, -1e3)
    walk.agent.temperature = 2.0
    assert next_action(state, walk.agent).startswith("↑ 25%  ↓ 75%  ← 0%  → 0%")
    walk.agent.config = replace(CONFIG, exploration="epsilon-greedy", epsilon=0.4)
    assert next_action(state, walk.agent).startswith("↑ 10%  ↓ 70%  ← 10%  → 10%")
    walk.agent.config = replace(CONFIG, learner="nearest-untried")
    assert next_action(state, walk.agent) == ""
    walk.agent.config = CONFIG
    assert next_action(replace(state, cell=GOALS[state.goal]), walk.agent) == "arrived"


def test_what_each_goal_took_is_told_in_the_order_of_learning(walk, state) -> None:
    walk.agent.progress.steps_of_goal = [30, 1200, 0]
    assert spent(replace(state, learned=("bed", "sofa")), walk.agent) == "bed 1,200 actions, sofa 30"


def test_the_title_and_the_scale_say_what_the_colours_mean(state) -> None:
    assert maze_titles(state, FREE, HEAT, 60, True)[0] == "values for sofa"
    assert (
        maze_titles(state, replace(FREE, looked_at="desk", heat=TD_ERRORS), HEAT, 60, True)[0] == "TD errors for desk"
    )
    assert maze_titles(state, replace(FREE, heat=VISITS), HEAT, 60, True)[0] == "visits"
    coloured, plain = (maze_titles(state, FREE, HEAT, 60, coloured)[1] for coloured in (True, False))
    assert coloured.startswith("11.1 [#")
    assert coloured.endswith("[/] 100 · grey: untried")
    assert plain == "11.1 .:-=+ 100 · blank: untried"
    assert maze_titles(state, FREE, HEAT, 20, False)[1] == "11.1 .:-=+ 100"
    assert maze_titles(state, FREE, replace(HEAT, low=np.nan), 60, True)[1] == "grey: untried"


def test_the_goal_that_is_looked_at_goes_before_the_current_one(state) -> None:
    assert shown_goal(state, FREE) == "sofa"
    assert shown_goal(state, replace(FREE, looked_at="desk")) == "desk"
    assert shown_goal(replace(state, goal=""), FREE) == "sofa"


def test_the_headline_counts_goals_and_in_the_end_compares_with_the_floor(state) -> None:
    assert headline(state) == "0 of 3 goals learned"
    clock = replace(state.clock, step=3 * state.floor_steps)
    done = replace(state, ended="learned", learned=tuple(GOALS), clock=clock)
    assert headline(done) == f"all 3 goals learned in {3 * state.floor_steps} actions, 3.00 times the floor"
    assert headline(replace(done, ended="gave-up", learned=("bed",))).endswith("1 of 3 goals learned")


@pytest.mark.parametrize("cols", [20, 40, 80, 200])
def test_the_two_lines_at_the_bottom_fit_and_the_last_one_tells_the_speed(state, cols: int) -> None:
    for controls in (FREE, WatchControls(paused=True), WatchControls(skip="goal")):
        assert len(hint_text(state, controls, cols)) <= max(cols, 20)
        status = status_text(state, controls, "cabin, multi", cols).plain
        assert cols < 40 or len(status) == cols
        assert any(word in status for word in ("10 actions/s", "PAUSED", "to the next goal"))


def test_the_hints_of_a_run_that_is_over_no_longer_move_it(state) -> None:
    assert "pause" in hint_text(state, FREE, 120).plain
    over = hint_text(replace(state, ended="learned"), FREE, 120).plain
    assert "leave" in over
    assert "pause" not in over


def test_goals_of_random_mazes_are_numbers_and_are_called_goals() -> None:
    from twonav_cli.events import Clock, RunStarted
    from twonav_cli.learner.agent import Agent
    from twonav_cli.maze import Maze
    from twonav_cli.terminal.screen.watch_state import first_state
    from twonav_cli.terminal.screen.watch_walk import Walk

    cells = list(GOALS.values())
    maze = Maze(small_maze().blocked, {str(n): c for n, c in enumerate(cells, 1)}, {"1": STARTS["s1"]})
    walk = Walk(Agent.for_maze(maze, LearningConfig()), maze, 0, lambda event: None)
    state = after(walk, 2, first_state(RunStarted(Clock(), "train", "maze", "random-0", 0, {}, maze), walk.agent))
    assert "2 goal 2" in errors_text(state, FREE, 40, 5).plain
    assert "1 from start 1: 2 actions" in numbers_text(state, walk.agent, 78, 9).plain
