"""The 2D simulator of the kitchen as a Gymnasium environment."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import twonav_cli.environments  # noqa: F401  # registers the environment
from twonav_cli.environments.sim2d_env import Sim2dEnv
from twonav_cli.errors import TwonavError
from twonav_cli.grid import Cell
from twonav_cli.maze import Action
from twonav_cli.scene.catalog import scene_path

WAY = (0, 3, 3, 1, 2, 0, 0, 2)


def kitchen(**settings: Any) -> Sim2dEnv:
    """Return the bare environment of the kitchen."""
    env = gymnasium.make("twonav/Sim2D-v0", scene="kitchen", **settings).unwrapped
    assert isinstance(env, Sim2dEnv)
    return env


def told(env: Sim2dEnv, actions: tuple[int, ...], **asked: Any) -> list[str]:
    """Return everything that an episode says, as text."""
    return [str(env.reset(**asked)), *(str(env.step(action)) for action in actions)]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("settings", [{}, {"goal": None, "base": "differential", "render_mode": "rgb_array"}], ids=str)
def test_gymnasiums_own_check_finds_nothing_to_say(settings: dict[str, Any]) -> None:
    check_env(kitchen(**settings))


def test_the_shortest_way_leads_to_the_goal_and_its_reward() -> None:
    env = kitchen(goal="shelf")
    assert env.observation_space == gymnasium.spaces.Discrete(15 * 20)
    _, info = env.reset(seed=0, options={"start": "s1"})
    rewards, terminated = [], False
    while not terminated and len(rewards) < 50:
        here, way = Cell(*info["cell"]), env.maze.distances_to(Cell(*info["goal_cell"]))
        action = min(Action, key=lambda action: way[env.maze.moved(here, action)])
        _, reward, terminated, truncated, info = env.step(action)
        assert not truncated
        rewards.append(reward)
    assert rewards[-1] == 100.0
    assert set(rewards[:-1]) <= {-0.1, -2.0}
    assert info["cell"] == info["cell_true"] == info["goal_cell"]
    assert info["shortest_way"] == 0
    assert info["time_s"] > 0.5 * len(rewards)


def test_a_wall_blocks_and_the_robot_stays_in_its_cell() -> None:
    env = kitchen()
    cell = env.maze.starts["s1"]
    action = next(a for a in Action if env.maze.moved(cell, a) == cell)
    before, _ = env.reset(seed=0, options={"start": "s1"})
    after, reward, terminated, _, info = env.step(action)
    assert (after, reward, terminated) == (before, -2.0, False)
    assert (info["blocked"], info["outcome"]) == (True, "blocked")


@pytest.mark.parametrize("base", ["omni", "differential"])
def test_a_seed_repeats_an_episode_whatever_came_before(base: str) -> None:
    first, second = kitchen(goal=None, base=base), kitchen(goal=None, base=base)
    told(second, (1, 1, 2), seed=8)
    start = {"start": (7, 8)}  # no start of the scene, so that the heading is drawn too
    episodes = [[told(env, WAY, seed=3, options=start), told(env, WAY)] for env in (first, second)]
    assert episodes[0] == episodes[1]
    assert told(first, WAY, seed=4, options=start) != episodes[0][0]


def test_a_start_of_the_scene_has_its_heading() -> None:
    env = kitchen()
    _, info = env.reset(seed=0, options={"start": "s4"})
    assert info["pose"][2] == pytest.approx(env.floor.scene.starts["s4"].theta_rad)
    assert env.floor.maze_frame.cell_at(*info["pose"][:2]) == info["cell"] == tuple(env.maze.starts["s4"])


def test_a_scene_is_meant_by_name_or_path() -> None:
    goals = [Sim2dEnv(scene).maze.goals for scene in ("kitchen", str(scene_path("kitchen")), scene_path("kitchen"))]
    assert goals[0] == goals[1] == goals[2]


def test_an_episode_has_500_actions_unless_told_otherwise() -> None:
    assert gymnasium.spec("twonav/Sim2D-v0").max_episode_steps == 500
    env = gymnasium.make("twonav/Sim2D-v0", scene="kitchen", goal="shelf", max_episode_steps=2)
    env.reset(seed=0, options={"start": "s2"})
    assert [env.step(0)[3] for _ in range(2)] == [False, True]


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: Sim2dEnv("kitchn"), "scene 'kitchn'; did you mean 'kitchen'"),
        (lambda: Sim2dEnv(3), "3 is no scene: give a name .apartment, kitchen. or a path"),  # type: ignore[arg-type]  # on purpose
        (lambda: kitchen(goal="stov"), "goal 'stov'; did you mean 'stove'"),
        (lambda: kitchen(goal=9), "9 is no goal"),
        (lambda: kitchen(base="omnidirectional"), "unknown base 'omnidirectional'.*omni, differential"),
        (lambda: kitchen(base=["omni"]), "unknown base"),
        (lambda: kitchen(map_from="geometri"), "map source 'geometri'; did you mean 'geometry'"),
        (lambda: kitchen(map_from=1), "unknown map source '1'"),
        (lambda: Sim2dEnv("kitchen", render_mode="human"), "unknown render mode 'human'"),
        (lambda: kitchen().reset(options={"begin": "s1"}), "unknown option of reset 'begin'"),
        (lambda: kitchen().reset(options={"start": (0, 0)}), r"start \(0, 0\) is blocked or outside"),
        (lambda: kitchen().reset(options={"start": (3, 7)}), "the start lies on goal 'stove'"),
    ],
)
def test_what_is_wrong_is_said_in_one_line(make: Callable[[], object], sentence: str) -> None:
    with pytest.raises(TwonavError, match=sentence) as raised:
        make()
    assert "\n" not in str(raised.value)


def test_many_environments_run_side_by_side() -> None:
    envs = gymnasium.make_vec("twonav/Sim2D-v0", num_envs=2, scene="kitchen", goal=None)
    observations, infos = envs.reset(seed=0)
    assert observations.shape == (2, 2)
    assert infos["outcome"].tolist() == [None, None]
    infos = envs.step(np.array([0, 1]))[-1]
    assert set(infos["outcome"]) <= {"reached", "blocked", "timed-out"}
    assert [len(pose) for pose in infos["pose"]] == [3, 3]
    envs.close()
