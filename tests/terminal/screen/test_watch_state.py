"""Watching as a state machine."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from small_run import CONFIG, GOALS, STARTS, after, small_maze, small_run, small_walk

from twonav_cli.events import Clock, GoalChosen, GoalLearned, RunEnded
from twonav_cli.grid import Cell
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.goals import GOAL_SELECTIONS
from twonav_cli.terminal.screen.watch_state import (
    CURVE_TRIALS,
    RECENT_TRIALS,
    TRAIL_CELLS,
    Trial,
    Walked,
    WatchState,
    advance,
    called,
    first_state,
    number,
    why_chosen,
)

NAMES = list(GOALS)
RULE = GOAL_SELECTIONS["td-error"]


def fresh() -> WatchState:
    return first_state(small_run(), Agent.for_maze(small_maze(), CONFIG))


def at_goal(goal: str = "desk") -> WatchState:
    return advance(fresh(), GoalChosen(Clock(), goal, RULE, np.array([1.0, 2.0, 3.0])))


def walked(cell: Cell, steps: int, *trials: Trial, start: str = "s1") -> Walked:
    return Walked(Clock(3, 40), cell, STARTS[start], steps, trials, 1.5, np.array([4.0, 5.0, 6.0]))


def test_the_floor_is_every_asked_for_success_by_a_shortest_way() -> None:
    maze = small_maze()
    ways = [int(maze.distances_to(goal)[start]) for goal in GOALS.values() for start in STARTS.values()]
    assert fresh().floor_steps == 5 * sum(ways) > 0


def test_the_reason_of_a_choice_carries_the_numbers_that_decided() -> None:
    chosen = GoalChosen(Clock(), "bed", RULE, np.array([9640.0, 9871.0, 12_000.0]))
    assert why_chosen(chosen, NAMES, ("desk",)) == "its TD error is the largest (9,871; next sofa, 9,640)"
    close = GoalChosen(Clock(), "bed", RULE, np.array([9640.2, 9640.3, 0.0]))
    assert why_chosen(close, NAMES, ()) == "its TD error is the largest (9,640.3; next sofa, 9,640.2)"


def test_equal_errors_and_the_last_goal_are_called_what_they_are() -> None:
    equal = GoalChosen(Clock(), "sofa", RULE, np.full(3, 1e4))
    assert why_chosen(equal, NAMES, ()) == "its TD error is the largest (10,000), first of equals"
    assert why_chosen(equal, NAMES, ("bed", "desk")) == "it is the last one left"


def test_other_rules_give_their_own_reason() -> None:
    drawn = GoalChosen(Clock(), "sofa", GOAL_SELECTIONS["random"], np.arange(3.0))
    assert why_chosen(drawn, NAMES, ()) == "drawn at random"


def test_numbers_are_short_and_those_of_random_mazes_are_told_from_names() -> None:
    assert [number(9871.4), number(26.61), number(0.000123)] == ["9,871", "26.6", "0.000123"]
    assert [called("7"), called("7", "start"), called("sofa")] == ["goal 7", "start 7", "sofa"]


def test_the_trail_follows_single_actions_and_begins_anew_where_some_were_not_seen() -> None:
    state = at_goal()
    for steps, cell in enumerate([Cell(1, 0), Cell(2, 0), Cell(2, 1)], start=1):
        state = advance(state, walked(cell, steps))
    assert state.trail == (Cell(0, 0), Cell(1, 0), Cell(2, 0), Cell(2, 1))
    assert state.cell == Cell(2, 1)
    assert advance(state, walked(Cell(4, 4), 90)).trail == (Cell(4, 4),)


def test_the_trail_is_bounded_and_keeps_the_latest_cells() -> None:
    state = at_goal()
    for steps in range(1, 3 * TRAIL_CELLS):
        state = advance(state, walked(Cell(0, steps % 2), steps))
    assert len(state.trail) == TRAIL_CELLS
    assert state.trail[-1] == state.cell == Cell(0, (3 * TRAIL_CELLS - 1) % 2)


def test_a_trial_that_reached_its_goal_is_shown_there_until_the_next_begins() -> None:
    state = advance(at_goal(), walked(Cell(2, 1), 1))
    state = advance(state, walked(STARTS["s2"], 0, Trial("s1", 2, 4, True), start="s2"))
    assert (state.cell, state.between, state.start) == (GOALS["desk"], True, STARTS["s1"])
    assert state.trail == (Cell(0, 0), Cell(2, 1), GOALS["desk"])
    state = advance(state, walked(Cell(4, 4), 1, start="s2"))
    assert (state.cell, state.between, state.start) == (Cell(4, 4), False, STARTS["s2"])
    assert state.trail == (STARTS["s2"], Cell(4, 4))


def test_a_trial_that_failed_is_shown_where_it_was_seen_last() -> None:
    state = advance(at_goal(), walked(Cell(2, 1), 499))
    state = advance(state, walked(STARTS["s2"], 0, Trial("s1", 500, 4, False), start="s2"))
    assert state.cell == Cell(2, 1)
    assert state.recent == (False,)


def test_successes_and_actions_per_trial_are_bounded_and_a_new_goal_starts_a_new_curve() -> None:
    trials = [Trial("s1", 9, 4, True)] * (CURVE_TRIALS + 7)
    state = advance(at_goal(), walked(Cell(0, 1), 1, *trials))
    assert len(state.recent) == RECENT_TRIALS
    assert CURVE_TRIALS - 2 < len(state.curve) <= CURVE_TRIALS
    state = advance(state, GoalLearned(Clock(9, 99), "desk"))
    state = advance(state, GoalChosen(Clock(9, 99), "bed", RULE, np.zeros(3)))
    assert (state.curve, state.last_trial, state.learned) == ((), None, ("desk",))
    assert len(state.recent) == RECENT_TRIALS


def test_a_run_is_followed_to_its_end() -> None:
    walk = small_walk()
    state = after(walk, 0)
    while not state.ended:
        state = after(walk, 50, state)
    assert state.ended == "learned"
    assert sorted(state.learned) == sorted(GOALS)
    assert state.clock.step == walk.agent.progress.step >= state.floor_steps
    assert state.temperature == walk.agent.temperature
    assert state.td_errors is not None
    assert np.array_equal(state.td_errors, walk.agent.td_error_of_goals())


def test_a_run_that_goes_on_knows_what_came_before() -> None:
    walk = small_walk()
    before = after(walk, 400)
    while not before.learned or before.between:
        before = after(walk, 1, before)
    state = first_state(replace(small_run(), clock=before.clock), walk.agent)
    assert set(state.learned) == set(before.learned)
    assert state.goal == before.goal
    assert "taken up again" in state.why
    assert state.clock.step == before.clock.step


def test_an_ended_run_has_ended_from_the_beginning() -> None:
    assert advance(fresh(), RunEnded(Clock(1, 2), "gave-up")).ended == "gave-up"
    agent = Agent.for_maze(small_maze(), CONFIG)
    agent.progress.learned[:] = True
    assert first_state(small_run(), agent).ended == "learned"
