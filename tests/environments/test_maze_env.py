"""The maze as a Gymnasium environment: what an episode is, what is refused, and that a learner learns in it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import twonav_cli.environments  # noqa: F401  # registers the environment
from twonav_cli.environments.maze_env import MazeEnv
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.maze import Action, Maze
from twonav_cli.scene.catalog import scene_path

#   0 1 2 3
# 0 s . # .
# 1 # . . .
# 2 g . # h
SMALL = Maze(
    np.array([[0, 0, 1, 0], [1, 0, 0, 0], [0, 0, 1, 0]], dtype=np.bool_),
    {"g": Cell(2, 0), "h": Cell(2, 3)},
    {"s": Cell(0, 0), "on h": Cell(2, 3)},
)

#   0 1 2
# 0 s . g   "near g" is (0, 1)
# 1 # # #
# 2 c . h   from "cut off" only h can be reached
HALVES = Maze(
    np.array([[0, 0, 0], [1, 1, 1], [0, 0, 0]], dtype=np.bool_),
    {"g": Cell(0, 2), "h": Cell(2, 2)},
    {"s": Cell(0, 0), "near g": Cell(0, 1), "cut off": Cell(2, 0)},
)

TWO_IN_ONE_CELL = Maze(
    np.zeros((1, 3), dtype=np.bool_), {"a": Cell(0, 2), "b": Cell(0, 2), "c": Cell(0, 1)}, {"s": Cell(0, 0)}
)

BEHIND_WALLS = Maze(np.array([[0, 1, 0]], dtype=np.bool_), {"g": Cell(0, 2)}, {"s": Cell(0, 0)})

VARIANTS: list[dict[str, Any]] = [
    {},
    {"maze": "apartment", "goal": "sofa"},
    {"maze": "kitchen", "goal": None},
    {"maze": "random"},
    {"maze": "random", "number": 3, "seed": 5, "goal": None},
    {"maze": SMALL, "goal": (1, 3)},
    {"maze": SMALL, "goal": None, "render_mode": "rgb_array"},
    {"maze": HALVES},
    {"maze": HALVES, "goal": None},
]


def small(maze: Maze = SMALL, **settings: Any) -> gymnasium.Env[Any, Any]:
    """Return the bare environment of a small maze."""
    return gymnasium.make("twonav/Maze-v0", maze=maze, **settings).unwrapped


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("settings", VARIANTS, ids=str)
def test_gymnasiums_own_check_finds_nothing_to_say(settings: dict[str, Any]) -> None:
    check_env(gymnasium.make("twonav/Maze-v0", **settings).unwrapped)


def test_a_scene_is_meant_by_name_or_path() -> None:
    mazes = [MazeEnv(maze).maze for maze in ("apartment", str(scene_path("apartment")), scene_path("apartment"))]
    assert mazes[0].goals == mazes[1].goals == mazes[2].goals


def test_with_one_goal_the_observation_is_the_cells_number() -> None:
    env = small(goal="g")
    observation, info = env.reset(options={"start": (1, 2)})
    assert env.observation_space == gymnasium.spaces.Discrete(12)
    assert observation == 6
    assert info == {"cell": (1, 2), "goal": "g", "goal_cell": (2, 0), "blocked": False, "shortest_way": 3}


def test_with_drawn_goals_the_observation_names_the_goal_and_every_goal_comes() -> None:
    env = small(goal=None)
    assert env.observation_space == gymnasium.spaces.MultiDiscrete([12, 2])
    episodes = [env.reset(seed=0), *(env.reset() for _ in range(40))]
    assert {(int(observation[1]), info["goal"]) for observation, info in episodes} == {(0, "g"), (1, "h")}


def test_an_action_earns_what_the_paper_says() -> None:
    env = small(goal="g")
    env.reset(options={"start": "s"})
    steps = [env.step(action) for action in (Action.UP, Action.RIGHT, Action.DOWN, Action.DOWN, Action.LEFT)]
    assert [reward for _, reward, *_ in steps] == [-2.0, -0.1, -0.1, -0.1, 100.0]
    assert [observation for observation, *_ in steps] == [0, 1, 5, 9, 8]
    assert [terminated for _, _, terminated, *_ in steps] == [False, False, False, False, True]
    assert [info["blocked"] for *_, info in steps] == [True, False, False, False, False]
    assert [info["shortest_way"] for *_, info in steps] == [4, 3, 2, 1, 0]


def test_passing_the_other_goal_ends_nothing() -> None:
    env = small(goal="g")
    env.reset(options={"start": (1, 3)})
    _, reward, terminated, _, info = env.step(Action.DOWN)
    assert info["cell"] == SMALL.goals["h"]
    assert (reward, terminated) == (-0.1, False)


def test_an_episode_is_truncated_at_its_limit() -> None:
    env = gymnasium.make("twonav/Maze-v0", maze=SMALL, max_episode_steps=3)
    env.reset(seed=0)
    assert [env.step(0)[3] for _ in range(3)] == [False, False, True]


def test_an_episode_has_500_actions_unless_told_otherwise() -> None:
    assert gymnasium.spec("twonav/Maze-v0").max_episode_steps == 500


def test_an_episode_begins_at_a_start_of_the_maze_that_is_not_the_goal() -> None:
    env = gymnasium.make("twonav/Maze-v0", maze="random", goal=(9, 9)).unwrapped
    starts = {tuple(cell) for cell in env.maze.starts.values()}  # type: ignore[attr-defined]  # MazeEnv, unwrapped
    assert {env.reset(seed=seed)[1]["cell"] for seed in range(200)} == starts - {(9, 9)}
    assert {small(goal="h").reset(seed=seed)[1]["cell"] for seed in range(20)} == {(0, 0)}


def test_the_same_seed_gives_the_same_episodes() -> None:
    first, second = (gymnasium.make("twonav/Maze-v0", maze="random", goal=None) for _ in range(2))
    episodes = [[env.reset(seed=9)[1], *(env.reset()[1] for _ in range(20))] for env in (first, second)]
    assert episodes[0] == episodes[1]
    assert len({(info["cell"], info["goal"]) for info in episodes[0]}) > 10


@pytest.mark.parametrize("goal", ["h", 1, (2, 3), [2, 3], np.array([2, 3]), np.int64(1)], ids=repr)
def test_a_goal_is_meant_by_name_number_or_cell(goal: Any) -> None:
    assert small(goal=goal).reset(seed=0)[1]["goal"] == "h"
    assert small(goal=None).reset(options={"goal": goal})[0].tolist() == [0, 1]
    assert small(goal="g").reset(options={"goal": goal, "start": 0})[1]["goal_cell"] == (2, 3)


def test_a_goal_for_one_episode_is_forgotten_after_it() -> None:
    env = small(goal="g")
    assert env.reset(options={"goal": "h"})[1]["goal"] == "h"
    assert env.reset()[1]["goal"] == "g"


def test_any_free_cell_can_be_the_goal() -> None:
    env = small(goal=(0, 3))
    _, info = env.reset(options={"start": (1, 3)})
    assert (info["goal"], info["shortest_way"]) == ("(0, 3)", 1)
    assert env.step(Action.UP)[1:3] == (100.0, True)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: gymnasium.make("twonav/Maze-v0", maze="apartmant"), "maze 'apartmant'; did you mean 'apartment'"),
        (lambda: gymnasium.make("twonav/Maze-v0", maze="no/such/scene.xml"), "there is no scene at no/such/scene.xml"),
        (lambda: gymnasium.make("twonav/Maze-v0", maze="random", number=-1), "at least 0: -1"),
        (lambda: gymnasium.make("twonav/Maze-v0", goal="kitchn"), "goal 'kitchn'; did you mean 'kitchen'"),
        (lambda: MazeEnv("random", number="1"), "number of a random maze .* whole number: '1' was given"),  # type: ignore[arg-type]  # on purpose
        (lambda: MazeEnv("random", seed=None), "seed of a random maze .* whole number: None was given"),  # type: ignore[arg-type]  # on purpose
        (lambda: MazeEnv(None), "None is no maze: give a name"),  # type: ignore[arg-type]  # on purpose
        (lambda: MazeEnv(render_mode=3), "unknown render mode '3'"),  # type: ignore[arg-type]  # on purpose
        (lambda: small().reset(options=["start"]), r"options of reset.*\['start'\]"),  # type: ignore[arg-type]  # on purpose
        (lambda: small(goal=2), "2 is no goal: give a name .g, h., a number below 2 or a cell .row, col."),
        (lambda: small(goal=1.5), "1.5 is no goal"),
        (lambda: small(goal=(0, 2)), r"goal \(0, 2\) is blocked or outside the maze of 3 x 4 cells"),
        (lambda: small().reset(options={"start": (1, 0)}), r"start \(1, 0\) is blocked .* for example \(0, 0\)"),
        (lambda: small().reset(options={"start": (3, 0)}), "blocked or outside"),
        (lambda: small().reset(options={"start": "x"}), "unknown start 'x'"),
        (lambda: small(goal="h").reset(options={"start": "on h"}), "the start lies on goal 'h'"),
        (lambda: small(goal=None).reset(options={"goal": (0, 1)}), r"no goal lies in cell \(0, 1\)"),
        (lambda: small().reset(options={"begin": "s"}), "unknown option of reset 'begin'"),
        (lambda: gymnasium.make("twonav/Maze-v0", maze=Maze(SMALL.blocked, {}, {})), "no goal or no start"),
    ],
)
def test_what_is_wrong_is_said(make: Callable[[], object], sentence: str) -> None:
    with pytest.raises(TwonavError, match=sentence):
        make()


@pytest.mark.filterwarnings("ignore:.*render_mode='txt'")
def test_an_unknown_render_mode_is_refused() -> None:
    with pytest.raises(TwonavError, match=r"unknown render mode 'txt'.*ansi, rgb_array"):
        small(render_mode="txt")


@pytest.mark.parametrize("action", [-1, 4, 1.0, None, "up"])
def test_an_action_that_there_is_not_is_refused(action: Any) -> None:
    env = small()
    env.reset(seed=0)
    with pytest.raises(TwonavError, match=r"there is no action .*: 0 is up, 1 down, 2 left, 3 right"):
        env.step(action)


@pytest.mark.parametrize("goal", [0, None])
def test_a_maze_without_a_way_from_a_start_to_the_goal_is_refused_at_once(goal: int | None) -> None:
    with pytest.raises(TwonavError, match=r"no start of the maze leads to (goal 'g'|any goal): "):
        small(BEHIND_WALLS, goal=goal)


@pytest.mark.parametrize(
    ("settings", "options", "sentence"),
    [
        ({"goal": "g"}, {"start": "cut off"}, r"goal 'g' cannot be reached from \(2, 0\): choose another start"),
        ({"goal": None}, {"start": "cut off", "goal": "g"}, r"goal 'g' cannot be reached from \(2, 0\)"),
        ({"goal": None}, {"start": (0, 2)}, r"no goal away from \(0, 2\) can be reached from there"),
        ({"goal": "g"}, {"goal": "h", "start": "s"}, r"goal 'h' cannot be reached from \(0, 0\)"),
    ],
)
def test_what_cannot_be_reached_is_refused(settings: dict[str, Any], options: dict[str, Any], sentence: str) -> None:
    env = small(HALVES, **settings)
    with pytest.raises(TwonavError, match=sentence):
        env.reset(options=options)


def test_a_goal_for_one_episode_that_no_start_leads_to_is_refused() -> None:
    env = small(Maze(HALVES.blocked, HALVES.goals, {"s": Cell(0, 0)}))
    with pytest.raises(TwonavError, match="no start of the maze leads to goal 'h'"):
        env.reset(options={"goal": "h"})
    assert env.reset(options={"goal": "h", "start": (2, 1)})[1]["shortest_way"] == 1


def test_a_start_that_lies_on_one_goal_draws_the_others() -> None:
    env = small(goal=None)
    drawn = {env.reset(seed=seed, options={"start": "on h"})[1]["goal"] for seed in range(100)}
    assert drawn == {"g"}


def test_only_goals_within_reach_of_the_wanted_start_are_drawn() -> None:
    env = small(HALVES, goal=None)
    drawn = {start: {env.reset(seed=n, options={"start": start})[1]["goal"] for n in range(50)} for start in range(3)}
    assert drawn == {0: {"g"}, 1: {"g"}, 2: {"h"}}


@pytest.mark.parametrize(("settings", "options"), [({"goal": "g"}, {}), ({"goal": None}, {"goal": "g"})], ids=repr)
def test_only_starts_that_lead_to_the_goal_are_drawn(settings: dict[str, Any], options: dict[str, Any]) -> None:
    env = small(HALVES, **settings)
    assert {env.reset(seed=seed, options=options)[1]["cell"] for seed in range(100)} == {(0, 0), (0, 1)}


def test_a_drawn_goal_and_a_drawn_start_belong_together() -> None:
    env = small(HALVES, goal=None)
    drawn = {(info["goal"], info["cell"]) for info in (env.reset(seed=seed)[1] for seed in range(100))}
    assert drawn == {("g", (0, 0)), ("g", (0, 1)), ("h", (2, 0))}


def test_a_goal_that_no_start_leads_to_is_never_drawn() -> None:
    env = small(Maze(HALVES.blocked, HALVES.goals, {"s": Cell(0, 0)}), goal=None)
    assert {env.reset(seed=seed)[1]["goal"] for seed in range(50)} == {"g"}


@pytest.mark.parametrize("goal", ["g", None])
@pytest.mark.parametrize(
    "refused", [{"goal": "h", "start": "s"}, {"goal": "h", "start": "x"}, {"start": "cut off", "goal": "g"}], ids=repr
)
def test_a_refused_reset_leaves_the_episode_before_as_it_was(goal: str | None, refused: dict[str, Any]) -> None:
    undisturbed, env = small(HALVES, goal=goal), small(HALVES, goal=goal)
    for each in (undisturbed, env):
        each.reset(seed=3, options={"start": "s", "goal": "g"})
    with pytest.raises(TwonavError):
        env.reset(seed=4, options=refused)
    for action in (Action.RIGHT, Action.RIGHT):
        assert str(env.step(action)) == str(undisturbed.step(action))
    resets = [[str(each.reset()) for _ in range(20)] for each in (undisturbed, env)]
    assert resets[0] == resets[1]


@pytest.mark.parametrize("goal", ["b", 1, [1]], ids=repr)
def test_of_two_goals_in_one_cell_the_one_that_is_meant_is_named(goal: Any) -> None:
    assert small(TWO_IN_ONE_CELL, goal=goal).reset(seed=0)[1]["goal"] == "b"
    assert small(TWO_IN_ONE_CELL, goal="c").reset(options={"goal": goal})[1]["goal"] == "b"
    observation, info = small(TWO_IN_ONE_CELL, goal=None).reset(options={"goal": goal})
    assert (observation.tolist(), info["goal"], info["goal_cell"]) == ([0, 1], "b", (0, 2))


def test_an_environment_that_was_not_reset_says_so() -> None:
    with pytest.raises(gymnasium.error.ResetNeeded):
        small().step(0)
    with pytest.raises(gymnasium.error.ResetNeeded):
        small(render_mode="ansi").render()


def test_text_and_picture_show_the_same_episode() -> None:
    text, picture = small(render_mode="ansi"), small(render_mode="rgb_array")
    for env in (text, picture):
        env.reset(options={"start": "s", "goal": "h"})
    assert text.render() == "@.#.\n#...\n..#G\n"
    shown = picture.render()
    assert (shown.shape, shown.dtype) == ((360, 480, 3), np.uint8)


def test_rendering_without_a_mode_warns() -> None:
    env = small()
    env.reset(seed=0)
    with pytest.warns(UserWarning, match="without a render mode"):
        assert env.render() is None


def test_many_environments_run_side_by_side() -> None:
    envs = gymnasium.make_vec("twonav/Maze-v0", num_envs=3, maze="random", goal=None)
    observations, infos = envs.reset(seed=0)
    assert observations.shape == (3, 2)
    assert infos["shortest_way"].min() > 0
    rewards = envs.step(np.array([0, 1, 2]))[1]
    assert set(rewards.tolist()) <= {-2.0, -0.1, 100.0}


def q_learned(env: gymnasium.Env[Any, Any], episodes: int, epsilon: float, rng: np.random.Generator) -> float:
    """Learn as every tutorial does, by a table and epsilon-greedy; return the mean length of the last 20 episodes."""
    q = np.zeros((env.observation_space.n, env.action_space.n))  # type: ignore[attr-defined]  # both are Discrete
    lengths = []
    for episode in range(episodes):
        state, _ = env.reset(seed=episode)
        done, length = False, 0
        while not done:
            ties = np.flatnonzero(q[state] == q[state].max())
            action = int(rng.integers(4)) if rng.random() < epsilon else int(rng.choice(ties))
            following, reward, terminated, truncated, _ = env.step(action)
            target = float(reward) + (0.0 if terminated else 0.95 * q[following].max())
            q[state, action] += 0.5 * (target - q[state, action])
            state, done, length = following, terminated or truncated, length + 1
        lengths.append(length)
    return float(np.mean(lengths[-20:]))


def test_a_tutorials_q_learner_learns_the_way() -> None:
    env = gymnasium.make("twonav/Maze-v0", maze="random", number=1, max_episode_steps=200)
    maze = env.unwrapped.maze  # type: ignore[attr-defined]  # MazeEnv, unwrapped
    shortest = np.mean([maze.distances_to(maze.goals["1"])[cell] for cell in maze.starts.values()])
    learned = q_learned(env, 150, epsilon=0.05, rng=np.random.default_rng(0))
    aimless = q_learned(env, 20, epsilon=1.0, rng=np.random.default_rng(0))
    assert learned < 1.5 * shortest
    assert aimless > 5 * shortest
