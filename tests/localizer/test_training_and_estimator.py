import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.dataset.store import FrameStore
from twonav_cli.errors import TwonavError
from twonav_cli.events import Event, FittingStep, FittingValidated
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.localizer.training import TrainingConfig, batch_indices, learning_rate, train
from twonav_cli.localizer.training_state import STATE_FILE

TINY = TrainingConfig(architecture="inception-9-slim", images=32 * 90, batch=32, part=16, validations=2)


@pytest.fixture(scope="module")
def trained(toy_store: FrameStore, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, list[Event]]:
    folder, events = tmp_path_factory.mktemp("localizer"), []
    assert train(toy_store, folder, TINY, seed=1, sink=events.append, command="train toy") == folder
    return folder, events


def test_the_network_learns_far_more_than_the_mean_pose(
    toy_store: FrameStore, trained: tuple[Path, list[Event]]
) -> None:
    images, poses = toy_store.batch(toy_store.off_grid())
    found = error_metrics(Estimator.load(trained[0], "toy-digest").estimate_many(images), poses)
    mean = error_metrics(np.broadcast_to(poses.mean(axis=0), poses.shape), poses)
    assert found["pos_median_m"] < 0.5 * mean["pos_median_m"]
    assert found["ang_median_deg"] < 0.25 * mean["ang_median_deg"]


def test_training_tells_its_progress_and_its_errors(trained: tuple[Path, list[Event]]) -> None:
    steps = [event for event in trained[1] if isinstance(event, FittingStep)]
    tried = [event for event in trained[1] if isinstance(event, FittingValidated)]
    assert steps[-1].clock.step == TINY.steps
    assert steps[-1].loss < steps[0].loss
    assert [event.clock.step for event in tried] == [45, 90]


def test_the_card_says_how_good_it_is_and_the_checkpoint_is_small(trained: tuple[Path, list[Event]]) -> None:
    card = json.loads((trained[0] / "card.json").read_text())
    assert card["scene_digest"] == "toy-digest"
    assert card["metrics"]["off_grid"]["n"] == 150
    assert card["metrics"]["paper_split"]["n"] > 50
    assert sum(file.stat().st_size for file in trained[0].iterdir()) < 8e6
    assert not (trained[0] / STATE_FILE).exists()


def test_an_estimate_holds_the_belief_it_was_read_from(
    toy_store: FrameStore, trained: tuple[Path, list[Event]]
) -> None:
    estimator = Estimator.load(trained[0])
    image = np.array(toy_store.frames[-1])
    estimate = estimator.estimate(image)
    assert estimate.grid_belief.shape == estimate.frame.shape
    assert estimate.grid_belief.sum() == pytest.approx(1.0, abs=1e-3)
    assert 0.0 < estimate.confidence <= 1.0 + 1e-6
    assert estimate.pose == pytest.approx(estimator.estimate_many(image[None])[0], abs=1e-3)


@pytest.mark.parametrize(
    "image",
    [np.zeros((60, 80, 3), np.uint8), np.full((84, 84, 3), np.nan), np.zeros((84, 84), np.uint8)],
    ids=["wrong size", "not a number", "grey"],
)
def test_a_picture_that_is_none_is_refused(trained: tuple[Path, list[Event]], image: np.ndarray) -> None:
    with pytest.raises(TwonavError, match="needs uint8 RGB"):
        Estimator.load(trained[0]).estimate(image)


def test_a_localizer_of_another_scene_is_refused(trained: tuple[Path, list[Event]]) -> None:
    with pytest.raises(TwonavError, match="another scene"):
        Estimator.load(trained[0], "other")


def test_a_stopped_training_goes_on_and_ends_the_same_way(toy_store: FrameStore, tmp_path: Path) -> None:
    config = replace(TINY, images=32 * 8, threads=1, validations=1)
    whole = train(toy_store, tmp_path / "whole", config, seed=2)
    asked = iter([False, False, False, True])
    assert train(toy_store, tmp_path / "cut", config, seed=2, should_stop=lambda: next(asked)) is None
    assert (tmp_path / "cut" / STATE_FILE).exists()
    cut = train(toy_store, tmp_path / "cut", config, seed=2, resume=True)
    assert whole is not None
    assert cut is not None
    images, _ = toy_store.batch(toy_store.off_grid()[:20])
    one, two = (Estimator.load(folder).estimate_many(images) for folder in (whole, cut))
    assert np.allclose(one, two, atol=1e-3)


def test_going_on_with_other_settings_or_a_damaged_state_is_refused(toy_store: FrameStore, tmp_path: Path) -> None:
    config = replace(TINY, images=32 * 4)
    train(toy_store, tmp_path, config, seed=2, should_stop=lambda: True)
    with pytest.raises(TwonavError, match="other settings"):
        train(toy_store, tmp_path, replace(config, peak_rate=1e-3), seed=2, resume=True)
    state = tmp_path / STATE_FILE
    state.write_bytes(state.read_bytes()[:1000])
    with pytest.raises(TwonavError, match="damaged"):
        train(toy_store, tmp_path, config, seed=2, resume=True)


def test_a_training_that_goes_on_may_end_sooner(toy_store: FrameStore, tmp_path: Path) -> None:
    config = replace(TINY, images=32 * 50)
    asked = iter([False, False, True])
    train(toy_store, tmp_path, config, seed=2, should_stop=lambda: next(asked))
    events: list[Event] = []
    train(toy_store, tmp_path, replace(config, images=32 * 4), seed=2, resume=True, sink=events.append)
    assert [event.clock.step for event in events if isinstance(event, FittingStep)] == [4]


def test_too_few_frames_for_a_batch_are_refused(toy_store: FrameStore, tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="too few"):
        train(toy_store, tmp_path, replace(TINY, batch=1_000_000), seed=1)


def test_the_rate_rises_to_its_peak_and_falls_to_nearly_nothing() -> None:
    rates = [learning_rate(step, TINY) for step in range(TINY.steps)]
    assert max(rates) == pytest.approx(TINY.peak_rate, rel=0.01)
    assert rates[0] < 0.1 * TINY.peak_rate
    assert rates[-1] < 0.01 * TINY.peak_rate


def test_a_pass_shows_every_frame_once_and_the_next_in_another_order() -> None:
    frames = np.arange(100, 160)
    first, second = (
        np.concatenate([batch_indices(step, frames, 10, seed=3) for step in range(start, start + 6)])
        for start in (0, 6)
    )
    assert sorted(first) == sorted(second) == frames.tolist()
    assert first.tolist() != second.tolist()
