"""A furnished scene in 3D as a Gymnasium environment: the kitchen, with localizers that are right and that are not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.utils.env_checker import check_env

import twonav_cli.environments  # noqa: F401  # registers the environment
from twonav_cli import checkpoint_folders
from twonav_cli.environments import apartment_env
from twonav_cli.environments.apartment_env import ApartmentEnv
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose
from twonav_cli.grid import Cell
from twonav_cli.maze import Action
from twonav_cli.stages.localize import Image, Located

BELOW = Cell(4, 7)
"""One cell below the stove, a goal of the kitchen."""

PICTURE = spaces.Box(0, 255, (84, 84, 3), np.uint8)


class Says:
    """A localizer that answers one given cell after the other, the last one for ever, with the true heading."""

    def __init__(self, env: ApartmentEnv, cells: list[Cell]) -> None:
        self.env, self.cells = env, cells

    def __call__(self, image: Image, motion: Pose) -> Located:
        cell = self.cells.pop(0) if len(self.cells) > 1 else self.cells[0]
        stage: Any = self.env._stage
        return Located(Pose(*self.env.floor.maze_frame.centre_of(cell), stage.world.pose().theta_rad))

    def forget(self) -> None:
        """Nothing is remembered."""

    def draw_from(self, rng: np.random.Generator) -> None:
        """Nothing is drawn."""


Make = Callable[..., ApartmentEnv]


@pytest.fixture
def kitchen(monkeypatch: pytest.MonkeyPatch) -> Iterator[Make]:
    """Return a function that makes the kitchen's environment; its localizer says certain cells, if any are given."""
    made: list[ApartmentEnv] = []

    def make(says: list[Cell] | None = None, **settings: Any) -> ApartmentEnv:
        env = gymnasium.make("twonav/Apartment-v0", **{"scene": "kitchen", **settings}).unwrapped
        assert isinstance(env, ApartmentEnv)
        if says is not None:
            monkeypatch.setattr(apartment_env, "load_localize", lambda floor, filtered, seed: Says(env, says))
        made.append(env)
        return env

    yield make
    for env in made:
        env.close()


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(
    "settings",
    [
        {},
        {"goal": None, "localizer": "truth", "base": "differential"},
        {"goal": None, "localizer": "raw", "observe": "cell", "render_mode": "rgb_array"},
    ],
    ids=str,
)
def test_gymnasiums_own_check_finds_nothing_to_say(kitchen: Make, settings: dict[str, Any]) -> None:
    check_env(kitchen(**settings))


def test_what_is_observed_is_the_picture_or_the_cell(kitchen: Make) -> None:
    spaces_of = {
        (observe, goal): kitchen(observe=observe, goal=goal, localizer="truth").observation_space
        for observe in ("image", "cell")
        for goal in ("stove", None)
    }
    assert spaces_of == {
        ("image", "stove"): PICTURE,
        ("image", None): spaces.Dict({"image": PICTURE, "goal": spaces.Discrete(5)}),
        ("cell", "stove"): spaces.Discrete(300),
        ("cell", None): spaces.MultiDiscrete([300, 5]),
    }


def test_the_picture_changes_with_every_action_and_names_the_goal_beside_it(kitchen: Make) -> None:
    env = kitchen(goal=None, localizer="truth")
    first, info = env.reset(seed=0, options={"start": "s4", "goal": "shelf"})
    second, *_ = env.step(Action.LEFT)
    assert (first["goal"], second["goal"], info["goal"]) == (4, 4, "shelf")
    assert first["image"].std() > 5
    assert (first["image"] != second["image"]).mean() > 0.1


def test_with_the_truth_the_robot_arrives_where_it_believes_to(kitchen: Make) -> None:
    env = kitchen(goal="stove", localizer="truth", observe="cell")
    env.reset(seed=0, options={"start": BELOW})
    observation, reward, terminated, _, info = env.step(Action.UP)
    assert (observation, reward, terminated) == (3 * 20 + 7, 100.0, True)
    assert info["cell"] == info["cell_true"] == info["goal_cell"]
    assert info["pose_estimate"] == info["pose"]
    assert not info["false_arrival"]


def test_a_robot_that_wrongly_believes_to_be_at_the_goal_has_failed(kitchen: Make) -> None:
    env = kitchen([BELOW, Cell(3, 7)], goal="stove", localizer="raw")
    env.reset(seed=0, options={"start": BELOW})
    _, reward, terminated, _, info = env.step(Action.DOWN)
    assert (reward, terminated, info["false_arrival"]) == (-2.0, True, True)
    assert (info["cell"], info["cell_true"]) == ((3, 7), (5, 7))
    assert info["shortest_way"] == 2
    assert info["pose_estimate"][:2] == pytest.approx(env.floor.maze_frame.centre_of(Cell(3, 7)))


def test_a_robot_that_is_at_the_goal_without_knowing_goes_on_until_it_does(kitchen: Make) -> None:
    env = kitchen([BELOW, BELOW, Cell(3, 7)], goal="stove", localizer="raw", observe="cell")
    env.reset(seed=0, options={"start": BELOW})
    observation, reward, terminated, _, info = env.step(Action.UP)
    assert (observation, reward, terminated) == (4 * 20 + 7, -2.0, False)
    assert (info["cell_true"], info["blocked"], info["false_arrival"]) == ((3, 7), True, False)
    _, reward, terminated, _, info = env.step(Action.UP)
    assert (reward, terminated, info["cell_true"], info["outcome"]) == (100.0, True, (3, 7), "blocked")


def test_a_robot_that_believes_to_be_at_the_goal_from_the_start_has_one_action(kitchen: Make) -> None:
    env = kitchen([Cell(3, 7)], goal="stove", localizer="raw", observe="cell")
    observation, _ = env.reset(seed=0, options={"start": "s1"})
    assert observation == 3 * 20 + 7
    assert env.step(Action.UP)[1:3] == (-2.0, True)


@pytest.mark.parametrize("localizer", ["truth", "filtered"])
def test_a_seed_repeats_an_episode_whatever_came_before(kitchen: Make, localizer: str) -> None:
    first, second = kitchen(localizer=localizer, goal=None), kitchen(localizer=localizer, goal=None)
    second.reset(seed=8)
    second.step(1)
    start = {"start": (7, 8)}  # no start of the scene, so that the heading is drawn too
    episodes = [told(env, seed=3, options=start) for env in (first, second)]
    assert episodes[0] == episodes[1]
    assert told(first, seed=4, options=start) != episodes[0]


def told(env: ApartmentEnv, **asked: Any) -> list[Any]:
    """Return the pictures and everything else that a short episode says."""
    said = [env.reset(**asked), *(env.step(action) for action in (0, 3, 2))]
    return [(each[0]["image"].tobytes(), each[0]["goal"], each[1:]) for each in said]


def test_an_episode_has_200_actions_unless_told_otherwise() -> None:
    assert gymnasium.spec("twonav/Apartment-v0").max_episode_steps == 200


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"localizer": "filter"}, "unknown localizer 'filter'; did you mean 'filtered'.*filtered, raw, truth"),
        ({"observe": "picture"}, "unknown observation 'picture'.*image, cell"),
        ({"observe": ["cell"]}, "unknown observation"),
        ({"goal": "stov"}, "goal 'stov'; did you mean 'stove'"),
        ({"scene": "kitchn"}, "scene 'kitchn'; did you mean 'kitchen'"),
        ({"base": "tracks"}, "unknown base 'tracks'"),
    ],
    ids=str,
)
def test_what_is_wrong_is_said_in_one_line(kitchen: Make, settings: dict[str, Any], sentence: str) -> None:
    with pytest.raises(TwonavError, match=sentence) as raised:
        kitchen(**settings)
    assert "\n" not in str(raised.value)


def test_a_missing_localizer_is_noticed_before_anything_is_built(
    kitchen: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checkpoint_folders, "checkpoints_dir", lambda: tmp_path)
    monkeypatch.setattr(checkpoint_folders, "runs_dir", lambda: tmp_path)
    with pytest.raises(TwonavError, match="train --stage localizer --scene kitchen"):
        kitchen()
    assert kitchen(localizer="truth").floor.scene.name == "kitchen"
