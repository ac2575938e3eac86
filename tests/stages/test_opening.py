"""A stage by name, and the scene's localizer as the 3D stage asks it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from twonav_cli import checkpoint_folders
from twonav_cli.belief import Belief
from twonav_cli.checkpoint import CARD_FILE
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import Pose, distance_m
from twonav_cli.grid import GridFrame
from twonav_cli.mapping.floor import Floor, read_floor
from twonav_cli.stages.localize import STILL
from twonav_cli.stages.maze_stage import MazeStage
from twonav_cli.stages.opening import load_localize, localizer_folder, make_stage
from twonav_cli.stages.sim2d_stage import Sim2dOptions, Sim2dStage


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


def test_the_maze_stage_is_that_of_the_floor(floor: Floor) -> None:
    stage = make_stage(floor, "maze", None, 0)
    assert isinstance(stage, MazeStage)
    assert np.array_equal(stage.maze.blocked, floor.maze.blocked)


def test_a_stage_has_the_options_that_are_its_own(floor: Floor) -> None:
    stage = make_stage(floor, "2d", None, 0, Sim2dOptions(base="differential"))
    assert isinstance(stage, Sim2dStage)
    assert stage.options.base == "differential"


def test_a_missing_localizer_is_answered_with_the_command_that_makes_it(
    places: tuple[Path, Path], floor: Floor
) -> None:
    with pytest.raises(TwonavError, match="train --stage localizer"):
        load_localize(floor)


def test_the_folder_that_is_loaded_is_found_without_loading_it(places: tuple[Path, Path], floor: Floor) -> None:
    folder = places[0] / "kitchen" / "localizer"
    with pytest.raises(TwonavError, match="train --stage localizer"):
        localizer_folder(floor)
    folder.mkdir(parents=True)
    (folder / CARD_FILE).write_text("{}")
    assert localizer_folder(floor) == folder


class FakeEstimator:
    """Sure of one place; `gives_beliefs` False gives poses only, as the paper's networks do."""

    gives_beliefs = True

    @classmethod
    def load(cls, folder: Path, digest: str) -> FakeEstimator:
        return cls()

    def estimate(self, image: np.ndarray) -> Belief:
        places, headings = np.array([(1.0, 2.0, 1.0, 0.1)]), np.array([(1.0, 0.5, 0.1)])
        return Belief(places, headings, 0.1, 60.0, np.zeros((1, 1), np.float32), GridFrame(0, 0, 1, 1, 1))

    def estimate_many(self, images: np.ndarray) -> np.ndarray:
        return np.tile((3.0, 2.0, 1.0), (len(images), 1))


@pytest.fixture
def estimator(places: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch) -> type[FakeEstimator]:
    """Put a made-up localizer in the place of the shipped one."""
    from twonav_cli.localizer import estimator as module

    folder = places[0] / "kitchen" / "localizer"
    folder.mkdir(parents=True)
    (folder / CARD_FILE).write_text("{}")
    fake = type("Fake", (FakeEstimator,), {})
    monkeypatch.setattr(module, "Estimator", fake)
    return fake


IMAGE = np.zeros((84, 84, 3), dtype=np.uint8)


def test_the_raw_localizer_gives_the_pose_and_the_belief_of_each_picture(
    floor: Floor, estimator: type[FakeEstimator]
) -> None:
    found = load_localize(floor)(IMAGE, STILL)
    assert found.pose == Pose(2.0, 1.0, 0.5)
    assert found.belief is not None
    assert found.filtered is None


def test_the_filtered_localizer_has_particles_about_the_picture_of_its_first_look(
    floor: Floor, estimator: type[FakeEstimator]
) -> None:
    found = load_localize(floor, filtered=True, seed=1)(IMAGE, STILL)
    assert found.filtered is not None
    assert distance_m(found.pose, Pose(2.0, 1.0, 0.5)) < 0.1
    again = load_localize(floor, filtered=True, seed=1)(IMAGE, STILL)
    assert again.pose == found.pose


def test_a_localizer_without_beliefs_gives_poses_but_cannot_be_filtered(
    floor: Floor, estimator: type[FakeEstimator]
) -> None:
    estimator.gives_beliefs = False
    found = load_localize(floor)(IMAGE, STILL)
    assert (found.pose, found.belief) == (Pose(3.0, 2.0, 1.0), None)
    with pytest.raises(TwonavError, match="--localizer raw"):
        load_localize(floor, filtered=True)
