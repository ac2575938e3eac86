"""Which checkpoint a command starts from."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from twonav_cli import checkpoint_folders
from twonav_cli.checkpoint import CARD_FILE
from twonav_cli.config import learning_preset
from twonav_cli.errors import TwonavError
from twonav_cli.experiments.predecessors import checkpoint_folder, load_agent, load_localize
from twonav_cli.learner.agent import Agent
from twonav_cli.learner.replay import Experience
from twonav_cli.mapping.floor import Floor, read_floor


@pytest.fixture
def places(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """Return the folders of the shipped checkpoints and of the user's own runs, both empty."""
    shipped, own = tmp_path / "shipped", tmp_path / "own"
    monkeypatch.setattr(checkpoint_folders, "checkpoints_dir", lambda: shipped)
    monkeypatch.setattr(checkpoint_folders, "runs_dir", lambda: own)
    return shipped, own


@pytest.fixture(scope="module")
def floor(tmp_path_factory: pytest.TempPathFactory) -> Floor:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("TWONAV_RUNS", str(tmp_path_factory.mktemp("runs")))
        return read_floor("kitchen")


def put_card(folder: Path) -> Path:
    folder.mkdir(parents=True)
    (folder / CARD_FILE).write_text("{}")
    return folder


def put_agent(folder: Path, floor: Floor, value: float) -> Path:
    agent = Agent.for_maze(floor.maze, learning_preset("maze"))
    agent.q[:] = value
    start = next(iter(floor.maze.starts.values()))
    agent.replay.add(Experience(start, 0, start, True), times=int(value))
    card = {
        "scene": "kitchen",
        "scene_digest": floor.scene.digest,
        "map_digest": floor.map.digest,
        "command": "test",
        "seed": 0,
        "metrics": {},
    }
    return agent.save(folder, card)


@pytest.mark.usefixtures("places")
@pytest.mark.parametrize(("source", "option"), [("geometry", " --map-from geometry"), ("survey", "")])
def test_the_command_makes_it_on_the_map_that_is_in_use(floor: Floor, source: str, option: str) -> None:
    floor = replace(floor, map_source=source)
    for stage in ("maze", "2d", "3d"):
        with pytest.raises(TwonavError, match=f"`twonav train --stage maze --scene kitchen{option}`"):
            load_agent(floor, stage)
    with pytest.raises(TwonavError, match=f"`twonav train --stage localizer --scene kitchen{option}`"):
        load_localize(floor)


def test_a_stage_takes_its_own_agent_else_that_of_the_nearest_stage_before(
    places: tuple[Path, Path], floor: Floor
) -> None:
    for stage, value, expected in (("maze", 1.0, (1, 1, 1)), ("2d", 2.0, (1, 2, 2)), ("3d", 3.0, (1, 2, 3))):
        put_agent(places[0] / "kitchen" / stage, floor, value)
        assert tuple(load_agent(floor, name).q.max() for name in ("maze", "2d", "3d")) == expected


def test_the_settings_are_those_of_the_stage_that_is_played(places: tuple[Path, Path], floor: Floor) -> None:
    put_agent(places[0] / "kitchen" / "maze", floor, 1.0)
    assert load_agent(floor, "3d").config == learning_preset("3d")
    assert load_agent(floor, "maze").config == learning_preset("maze")


def test_what_was_experienced_in_either_stage_stays_known_but_is_not_swept(
    places: tuple[Path, Path], floor: Floor
) -> None:
    maze_agent = put_agent(places[0] / "kitchen" / "maze", floor, 1.0)
    alone = load_agent(floor, "3d")
    assert [len(r) for r in (alone.replay, alone.earlier_here, alone.earlier_elsewhere)] == [0, 0, 1]
    put_agent(places[0] / "kitchen" / "3d", floor, 3.0)
    both = load_agent(floor, "3d")
    assert [len(r) for r in (both.replay, both.earlier_here, both.earlier_elsewhere)] == [0, 3, 1]
    in_maze = load_agent(floor, "maze")
    assert [len(r) for r in (in_maze.replay, in_maze.earlier_here, in_maze.earlier_elsewhere)] == [0, 1, 0]
    (maze_agent / CARD_FILE).write_text("{}")
    assert len(load_agent(floor, "3d").earlier_elsewhere) == 0


def test_an_agent_of_another_map_is_refused(places: tuple[Path, Path], floor: Floor) -> None:
    folder = put_agent(places[0] / "kitchen" / "maze", floor, 1.0)
    agent = Agent.load(folder)
    card = {"scene": "kitchen", "scene_digest": floor.scene.digest, "map_digest": "f" * 16}
    agent.save(folder, {**card, "command": "test", "seed": 0, "metrics": {}})
    with pytest.raises(TwonavError, match="another map"):
        load_agent(floor, "maze")


def test_of_two_agents_the_one_of_this_map_is_taken(places: tuple[Path, Path], floor: Floor) -> None:
    other = put_agent(places[0] / "kitchen" / "maze", floor, 1.0)
    card = {"scene": "kitchen", "scene_digest": floor.scene.digest, "map_digest": "f" * 16}
    Agent.load(other).save(other, {**card, "command": "test", "seed": 0, "metrics": {}})
    own = put_agent(places[1] / "kitchen" / "maze", floor, 2.0)
    digests = (floor.scene.digest, floor.map.digest)
    assert checkpoint_folder("kitchen", "maze", None, False, *digests) == own
    assert checkpoint_folder("kitchen", "maze", None, False, floor.scene.digest) == other
    assert checkpoint_folder("kitchen", "maze", None, False, floor.scene.digest, "f" * 16) == other
    assert checkpoint_folder("kitchen", "maze", None, True, floor.scene.digest, "0" * 16) == own
    assert load_agent(floor, "maze").q.max() == 2.0


def test_an_agent_of_this_scene_goes_before_one_of_another(places: tuple[Path, Path], floor: Floor) -> None:
    put_card(places[0] / "kitchen" / "maze")
    own = put_agent(places[1] / "kitchen" / "maze", floor, 2.0)
    assert checkpoint_folder("kitchen", "maze", None, False, floor.scene.digest, "f" * 16) == own
