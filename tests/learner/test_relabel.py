"""The values of a goal from old experience, beside an iteration that shares no code with them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from twonav_cli.config import LearningConfig
from twonav_cli.grid import Cell
from twonav_cli.learner import relabel
from twonav_cli.learner.relabel import entries_of, remembered, tried_entries, values_from_experience
from twonav_cli.learner.replay import Experience, Replay
from twonav_cli.maze import Action, Maze, filled_where_unreachable

UP, DOWN, LEFT, RIGHT = Action
CORRIDOR = np.ones((1, 3), dtype=np.bool_)
A, B, C = Cell(0, 0), Cell(0, 1), Cell(0, 2)
G = 0.5
CONFIG = LearningConfig(discount=G, initial_q=80.0)


def explored(maze: Maze, cells: set[Cell] | None = None) -> Replay:
    """Return the experience of every action in some cells, in all of them by default."""
    replay = Replay()
    for cell in maze.free_cells:
        for action in Action if cells is None or cell in cells else ():
            after = maze.moved(cell, action)
            replay.add(Experience(cell, int(action), after, after == cell))
    return replay


def corridor() -> Replay:
    return explored(Maze(~CORRIDOR, {"end": C}, {"start": A}))


def random_maze(seed: int, rows: int = 9, cols: int = 11) -> Maze:
    """Return a maze without a cell that cannot be reached."""
    rng = np.random.default_rng(seed)
    blocked = rng.random((rows, cols)) < 0.3
    blocked[0, 0] = False
    return Maze(filled_where_unreachable(blocked, Cell(0, 0)), {"corner": Cell(0, 0)}, {"corner": Cell(0, 0)})


def slipping(maze: Maze, seed: int, share: float = 1.0) -> Replay:
    """Return experience of a share of the entries, where an action may bump, do its part or slip to either side."""
    rng, replay = np.random.default_rng(seed), Replay()
    for cell in maze.free_cells:
        for action in Action:
            for _ in range(int(rng.integers(1, 6)) if rng.random() < share else 0):
                after = maze.moved(cell, int(rng.choice([action, *Action])))
                blocked = after == cell or rng.random() < 0.1
                replay.add(Experience(cell, int(action), after, blocked), int(rng.integers(1, 4)))
    return replay


def plainly(
    free: NDArray[np.bool_], replay: Replay, goal: Cell, config: LearningConfig
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Return what `values_from_experience` should: all entries at once, again and again, from dictionaries."""
    outcomes: dict[tuple[Cell, int], list[tuple[Experience, int]]] = {}
    for experience, number in replay.counts.items():
        outcomes.setdefault((experience.cell, experience.action), []).append((experience, number))
    has_way = np.zeros(free.shape, dtype=np.bool_)
    has_way[goal] = True
    for _ in range(free.size):
        for experience in replay.counts:
            has_way[experience.cell] |= has_way[experience.next_cell]
    q, rewards = np.full((*free.shape, 4), config.initial_q), config.rewards
    for _ in range(3000):
        before = q.copy()
        for cell in (Cell(*map(int, place)) for place in np.argwhere(free)):
            staying = rewards.blocked + config.discount * (0.0 if cell == goal else before[cell].max())
            for action in range(4):
                made = outcomes.get((cell, action), [])
                if not made:
                    q[(*cell, action)] = staying if has_way[cell] else config.initial_q
                    continue
                targets = []
                for (_, _, after, blocked), _ in made:
                    earned = rewards.blocked if blocked else rewards.step
                    if has_way[cell] and not has_way[after]:
                        targets.append(staying)
                    elif after == goal:
                        targets.append(rewards.goal if cell != goal else earned)
                    else:
                        targets.append(earned + config.discount * before[after].max())
                q[(*cell, action)] = np.average(targets, weights=[number for _, number in made])
        if np.abs(q - before).max() < 1e-12:
            break
    return q, has_way


def walked(maze: Maze, q: NDArray[np.float64], start: Cell, goal: Cell) -> int:
    """Return the number of greedy actions to the goal; -1 when it is not reached."""
    cell = start
    for steps in range(maze.blocked.size):
        if cell == goal:
            return steps
        cell = maze.moved(cell, int(q[cell].argmax()))
    return -1


def test_the_values_of_a_corridor_are_those_that_one_computes_by_hand() -> None:
    q, has_way = values_from_experience(CORRIDOR, corridor(), C, CONFIG)
    one_away, two_away = 100.0, -0.1 + G * 100.0
    assert q[0, 1].tolist() == [-2 + G * one_away] * 2 + [-0.1 + G * two_away, one_away]
    assert q[0, 0].tolist() == [-2 + G * two_away] * 3 + [two_away]
    assert has_way.all()


def test_in_the_goal_itself_a_wall_has_nothing_behind_it_and_leaving_leads_back() -> None:
    q, _ = values_from_experience(CORRIDOR, corridor(), C, CONFIG)
    assert q[0, 2].tolist() == [-2.0, -2.0, -0.1 + G * 100.0, -2.0]


def test_the_mean_of_what_followed_counts() -> None:
    replay = corridor()
    replay.add(Experience(B, RIGHT, B, True), times=3)
    q, _ = values_from_experience(CORRIDOR, replay, C, CONFIG)
    # V = 1/4 100 + 3/4 (-2 + G V)
    value = (25.0 - 1.5) / (1 - 0.75 * G)
    assert np.isclose(q[0, 1, RIGHT], value)
    assert np.isclose(q[0, 0, RIGHT], -0.1 + G * value)


def test_entering_the_goal_earns_its_reward_even_when_the_action_ended_blocked() -> None:
    replay = Replay()
    replay.add(Experience(B, RIGHT, C, True))
    replay.add(Experience(A, RIGHT, B, True))
    q, _ = values_from_experience(CORRIDOR, replay, C, CONFIG)
    assert (q[0, 1, RIGHT], q[0, 0, RIGHT]) == (100.0, -2.0 + G * 100.0)


def test_an_untried_action_counts_as_blocked_where_a_way_is_known_and_keeps_its_first_value_elsewhere() -> None:
    replay = Replay()
    replay.add(Experience(B, RIGHT, C, False))
    q, has_way = values_from_experience(CORRIDOR, replay, C, CONFIG)
    assert has_way.tolist() == [[False, True, True]]
    assert q[0, 1].tolist() == [-2 + G * 100.0] * 3 + [100.0]
    assert q[0, 0].tolist() == [80.0] * 4
    assert q[0, 2].tolist() == [-2.0] * 4


def test_without_a_known_way_the_values_lead_to_the_nearest_unknown() -> None:
    free = np.ones((1, 6), dtype=np.bool_)
    maze = Maze(~free, {}, {})
    q, has_way = values_from_experience(free, explored(maze, {Cell(0, c) for c in range(3)}), Cell(0, 5), CONFIG)
    assert has_way.tolist() == [[False] * 5 + [True]]
    assert q[0, :3].argmax(axis=1).tolist() == [RIGHT] * 3
    assert q[0, 2, RIGHT] == -0.1 + G * 80.0
    assert q[0, 3].tolist() == [80.0] * 4


def test_a_promising_unknown_does_not_draw_the_agent_off_a_known_way() -> None:
    replay = corridor()
    free = np.ones((2, 3), dtype=np.bool_)
    for cell in (A, B, C):
        del replay.counts[Experience(cell, DOWN, cell, True)]
    replay.add(Experience(A, DOWN, Cell(1, 0), False))  # from where nothing was tried
    q, has_way = values_from_experience(free, replay, C, replace(CONFIG, initial_q=1e4))
    assert q[0].argmax(axis=1).tolist()[:2] == [RIGHT, RIGHT]
    assert q[0, 0, DOWN] == q[0, 0, UP]
    assert not has_way[1].any()


@pytest.mark.parametrize("discount", [0.0, 0.5, 0.95, 0.99])
@pytest.mark.parametrize("share", [1.0, 0.6, 0.2])
def test_it_agrees_with_a_plain_iteration_over_the_same_experience(discount: float, share: float) -> None:
    config = replace(CONFIG, discount=discount)
    maze = random_maze(seed=int(100 * share), rows=5, cols=6)
    for replay in (slipping(maze, 7, share), explored(maze, set(maze.free_cells[:: round(1 / share)]))):
        goal = maze.free_cells[len(maze.free_cells) // 2]
        q, has_way = values_from_experience(~maze.blocked, replay, goal, config)
        expected, expected_way = plainly(~maze.blocked, replay, goal, config)
        assert np.array_equal(has_way, expected_way)
        assert np.abs(q - expected).max() < 1e-6


@pytest.mark.parametrize("discount", [0.95, 0.999])
@pytest.mark.parametrize("slips", [False, True])
def test_few_sweeps_are_enough_at_any_discount(discount: float, slips: bool) -> None:
    maze = random_maze(3, 24, 47)
    rows = remembered(~maze.blocked, [slipping(maze, 1) if slips else explored(maze)])
    entries, next_cells = entries_of(~maze.blocked, rows), rows[:, 3] * maze.cols + rows[:, 4]
    solved = relabel.solved(
        ~maze.blocked.reshape(-1), entries, next_cells, rows[:, 6].copy(), rows[:, 5] > 0, 0,
        np.array([100.0, -2.0, -0.1]), discount, 80.0,
    )  # fmt: skip
    assert solved[2] <= (150 if slips else 3)


def test_a_room_without_a_way_out_is_left_at_the_price_of_walking_for_ever() -> None:
    free = np.array([[True, True, False, True, False, True]])
    maze = Maze(~free, {}, {})
    q, has_way = values_from_experience(free, explored(maze), Cell(0, 3), replace(CONFIG, discount=0.999))
    assert has_way.tolist() == [[False, False, False, True, False, False]]
    assert np.allclose([q[0, 0].max(), q[0, 1].max(), q[0, 5].max()], [-100.0, -100.0, -2000.0])


def test_experience_of_an_earlier_stage_counts_only_where_this_one_has_none() -> None:
    here = Replay()
    here.add(Experience(A, RIGHT, A, True))
    q, has_way = values_from_experience(CORRIDOR, here, C, CONFIG, outside=corridor())
    assert has_way.tolist() == [[False, True, True]]
    assert q[0, 1, RIGHT] == 100.0
    rows = remembered(CORRIDOR, [here], corridor())
    assert len(rows) == 12
    assert [0, 0, RIGHT, 0, 0, 1, 1] in rows.tolist()
    assert tried_entries(CORRIDOR, rows).all()


def test_experience_that_names_no_free_cell_is_passed_over() -> None:
    replay = corridor()
    wrong = [Experience(Cell(0, 3), 0, A, False), Experience(A, 0, Cell(-1, 0), False), Experience(A, 4, B, False)]
    for experience in wrong:
        replay.add(experience)
    q, _ = values_from_experience(CORRIDOR, replay, C, CONFIG)
    assert np.array_equal(q, values_from_experience(CORRIDOR, corridor(), C, CONFIG)[0])


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_with_half_of_the_maze_explored_every_known_way_is_walked_and_the_rest_is_named(seed: int) -> None:
    maze = random_maze(seed, 15, 15)
    assert len(maze.free_cells) > 100
    cells = set(maze.free_cells[: len(maze.free_cells) // 2])
    goal = maze.free_cells[len(cells) // 2]
    q, has_way = values_from_experience(~maze.blocked, explored(maze, cells), goal, LearningConfig())
    known = Maze(maze.blocked | ~np.isin(np.arange(225), [15 * r + c for r, c in cells]).reshape(15, 15), {}, {})
    distance = known.distances_to(goal)  # ways through explored cells only
    assert np.array_equal(has_way, distance >= 0)
    assert 0 < has_way.sum() < len(maze.free_cells)
    for cell in maze.free_cells:
        if has_way[cell]:
            assert walked(maze, q, cell, goal) == distance[cell]
        elif cell in cells:
            assert reaches_unknown(maze, q, cell, cells)


def reaches_unknown(maze: Maze, q: NDArray[np.float64], cell: Cell, known: set[Cell]) -> bool:
    for _ in range(maze.blocked.size):
        if cell not in known:
            return True
        cell = maze.moved(cell, int(q[cell].argmax()))
    return False


def test_what_was_compiled_beforehand_is_what_is_used() -> None:
    relabel.compile_now()
    before = len(relabel.solved.signatures)
    values_from_experience(CORRIDOR, corridor(), C, CONFIG, outside=corridor())
    values_from_experience(np.asfortranarray(np.ones((3, 3), dtype=np.bool_)), corridor(), C, LearningConfig())
    assert len(relabel.solved.signatures) == before
