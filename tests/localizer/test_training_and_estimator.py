import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from twonav_cli.checkpoint import load_checkpoint, save_checkpoint
from twonav_cli.dataset.store import FrameStore
from twonav_cli.errors import TwonavError
from twonav_cli.events import Event, FittingStep, FittingValidated
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.localizer.training import train
from twonav_cli.localizer.training_config import TrainingConfig, learning_rate, training_settings
from twonav_cli.localizer.training_state import STATE_FILE

TINY = TrainingConfig(images=32 * 90, batch=32, part=16, validations=2, nearest_frames=100)
SHORT = replace(TINY, images=32 * 6, validations=1)


@pytest.fixture(scope="module")
def frames(toy_store: FrameStore) -> Selection:
    return toy_store, toy_store.training()


@pytest.fixture(scope="module")
def trained(
    toy_store: FrameStore, toy_grid_store: FrameStore, frames: Selection, tmp_path_factory: pytest.TempPathFactory
) -> tuple[Path, list[Event]]:
    folder, events = tmp_path_factory.mktemp("localizer"), []
    off_grid, paper = (toy_store, toy_store.off_grid()), (toy_grid_store, toy_grid_store.paper_test())
    trials = {"off_grid": off_grid, "paper_split": paper}
    assert train(frames, folder, TINY, 1, trials, off_grid, sink=events.append, command="train toy") == folder
    return folder, events


def weights_in(folder: Path) -> dict[str, np.ndarray]:
    return load_checkpoint(folder, "localizer")[0]


def assert_same_weights(one: Path, two: Path) -> None:
    first, second = weights_in(one), weights_in(two)
    assert first.keys() == second.keys()
    assert [name for name in first if not np.array_equal(first[name], second[name])] == []


def far_better_than_the_mean_pose(folder: Path, store: FrameStore) -> None:
    images, poses = store.batch(store.off_grid())
    found = error_metrics(Estimator.load(folder, "toy-digest").estimate_many(images), poses)
    mean = error_metrics(np.broadcast_to(poses.mean(axis=0), poses.shape), poses)
    assert found["pos_median_m"] < 0.5 * mean["pos_median_m"]
    assert found["ang_median_deg"] < 0.25 * mean["ang_median_deg"]


# What comes out


def test_our_network_learns_far_more_than_the_mean_pose(
    toy_store: FrameStore, trained: tuple[Path, list[Event]]
) -> None:
    far_better_than_the_mean_pose(trained[0], toy_store)


@pytest.mark.parametrize("network", ["cnn-7", "inception-9-hsv"])
def test_a_network_of_table_2_learns_far_more_than_the_mean_pose(
    toy_store: FrameStore, frames: Selection, tmp_path: Path, network: str
) -> None:
    config = training_settings(network, images=32 * 120, batch=32, part=16)
    train(frames, tmp_path, config, seed=1)
    far_better_than_the_mean_pose(tmp_path, toy_store)
    estimator = Estimator.load(tmp_path)
    assert not estimator.gives_beliefs
    with pytest.raises(TwonavError, match=f"{network} gives poses without a belief"):
        estimator.estimate(np.zeros((84, 84, 3), np.uint8))


def test_training_tells_its_progress_and_its_errors(trained: tuple[Path, list[Event]]) -> None:
    steps = [event for event in trained[1] if isinstance(event, FittingStep)]
    tried = [event for event in trained[1] if isinstance(event, FittingValidated)]
    assert steps[-1].clock.step == TINY.steps
    assert steps[-1].loss < steps[0].loss
    assert [event.clock.step for event in tried] == [45, 90]


def test_the_card_says_how_good_it_is_and_what_it_took(trained: tuple[Path, list[Event]]) -> None:
    card = json.loads((trained[0] / "card.json").read_text())
    assert card["scene_digest"] == "toy-digest"
    assert card["metrics"]["off_grid"]["n"] == 150
    assert card["metrics"]["off_grid_nearest"]["n"] == 100
    assert card["metrics"]["paper_split"]["n"] > 50
    assert card["settings"]["network"] == "belief"
    took = card["training"]
    assert took["device"] == "cpu"
    assert took["precision"] in {"float32", "bfloat16"}
    assert 1e6 < took["parameters"] < 5e6
    assert took["pictures_per_s"] == pytest.approx(TINY.images / took["seconds"], rel=0.1)
    assert sum(file.stat().st_size for file in trained[0].iterdir()) < 8e6
    assert not (trained[0] / STATE_FILE).exists()


def test_the_errors_in_the_card_are_those_of_the_checkpoint(
    toy_store: FrameStore, trained: tuple[Path, list[Event]]
) -> None:
    estimator = Estimator.load(trained[0])
    images, poses = toy_store.batch(toy_store.off_grid())
    found, said = error_metrics(estimator.estimate_many(images), poses), estimator.card["metrics"]["off_grid"]
    assert found["pos_mean_m"] == pytest.approx(said["pos_mean_m"], rel=1e-3)
    assert found["ang_mean_deg"] == pytest.approx(said["ang_mean_deg"], rel=1e-3)


# The estimator


def test_an_estimate_holds_the_belief_it_was_read_from(
    toy_store: FrameStore, trained: tuple[Path, list[Event]]
) -> None:
    estimator = Estimator.load(trained[0])
    image = np.array(toy_store.frames[-1])
    estimate = estimator.estimate(image)
    assert estimator.gives_beliefs
    assert estimate.grid.shape == estimate.frame.shape
    assert estimate.grid.sum() == pytest.approx(1.0, abs=1e-3)
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


@pytest.mark.parametrize("network", ["cnn-9", "sda-1x1500", "of-tomorrow"])
def test_weights_of_another_network_than_the_card_says_are_refused(
    trained: tuple[Path, list[Event]], tmp_path: Path, network: str
) -> None:
    arrays, card = load_checkpoint(trained[0], "localizer")
    card["settings"]["network"] = network
    save_checkpoint(tmp_path, {**arrays, "middle_m": np.zeros(2, np.float32)}, card)
    with pytest.raises(TwonavError, match="train it again"):
        Estimator.load(tmp_path)


# Being interrupted


@pytest.mark.parametrize("precision", ["float32", "bfloat16"])
def test_a_stopped_training_ends_with_the_same_weights_as_an_unbroken_one(
    frames: Selection, tmp_path: Path, precision: str
) -> None:
    config = replace(SHORT, precision=precision)
    train(frames, tmp_path / "whole", config, seed=2)
    asked = iter([False, False, False, True])
    assert train(frames, tmp_path / "cut", config, seed=2, should_stop=lambda: next(asked)) is None
    assert (tmp_path / "cut" / STATE_FILE).exists()
    train(frames, tmp_path / "cut", config, seed=2, resume=True)
    assert_same_weights(tmp_path / "whole", tmp_path / "cut")


def test_a_training_killed_while_it_is_measured_has_not_to_learn_again(
    toy_store: FrameStore, frames: Selection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def killed(*arguments: object) -> None:
        raise KeyboardInterrupt

    train(frames, tmp_path / "whole", SHORT, seed=2)
    with monkeypatch.context() as patched:
        patched.setattr("twonav_cli.localizer.training.trial_metrics", killed)
        with pytest.raises(KeyboardInterrupt):
            train(frames, tmp_path / "cut", SHORT, seed=2)
    events: list[Event] = []
    train(frames, tmp_path / "cut", SHORT, seed=2, resume=True, sink=events.append)
    assert events == []
    assert_same_weights(tmp_path / "whole", tmp_path / "cut")


def test_the_number_of_threads_changes_no_weight(frames: Selection, tmp_path: Path) -> None:
    for threads in (1, 3):
        train(frames, tmp_path / str(threads), replace(SHORT, threads=threads, part=8), seed=2)
    assert_same_weights(tmp_path / "1", tmp_path / "3")


def test_going_on_with_other_settings_frames_or_a_damaged_state_is_refused(frames: Selection, tmp_path: Path) -> None:
    train(frames, tmp_path, SHORT, seed=2, should_stop=lambda: True)
    with pytest.raises(TwonavError, match="other settings"):
        train(frames, tmp_path, replace(SHORT, peak_rate=1e-3), seed=2, resume=True)
    with pytest.raises(TwonavError, match="other settings"):
        train((frames[0], frames[1][:-1]), tmp_path, SHORT, seed=2, resume=True)
    state = tmp_path / STATE_FILE
    state.write_bytes(state.read_bytes()[:1000])
    with pytest.raises(TwonavError, match="damaged"):
        train(frames, tmp_path, SHORT, seed=2, resume=True)


def test_a_training_does_not_go_on_to_another_end(frames: Selection, tmp_path: Path) -> None:
    config = replace(TINY, images=32 * 50)
    asked = iter([False, False, True])
    train(frames, tmp_path, config, seed=2, should_stop=lambda: next(asked))
    with pytest.raises(TwonavError, match="other settings"):
        train(frames, tmp_path, replace(config, images=32 * 4), seed=2, resume=True)


# What cannot be


def test_too_few_frames_for_a_batch_are_refused(frames: Selection, tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="too few"):
        train(frames, tmp_path, replace(TINY, batch=1_000_000), seed=1)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"network": "inception"}, "did you mean 'inception-9'"),
        ({"device": "gpu"}, "auto, cpu, cuda"),
        ({"precision": "half"}, "auto, float32, bfloat16"),
        ({"pretraining_images": 64}, "belief is no autoencoder"),
    ],
)
def test_a_wrong_setting_is_answered_with_what_can_be(
    frames: Selection, tmp_path: Path, changes: dict[str, object], said: str
) -> None:
    with pytest.raises(TwonavError, match=said):
        train(frames, tmp_path, replace(TINY, **changes), seed=1)  # type: ignore[arg-type]  # wrong on purpose


def test_a_graphics_card_that_is_not_there_is_refused(
    frames: Selection, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    with pytest.raises(TwonavError, match="no graphics card"):
        train(frames, tmp_path, replace(TINY, device="cuda"), seed=1)


def test_a_training_that_diverges_says_so(frames: Selection, tmp_path: Path) -> None:
    with pytest.raises(TwonavError, match="use a smaller peak rate"):
        train(frames, tmp_path, replace(TINY, peak_rate=1e12), seed=1)


def test_frames_without_a_label_are_left_out(toy_store: FrameStore, frames: Selection, tmp_path: Path) -> None:
    labels = np.array(toy_store.labels)
    known = frames[1][::2]
    labels[np.setdiff1d(frames[1], known)] = np.nan
    labels[known[:5]] = np.inf
    train((replace(toy_store, labels=labels), frames[1]), tmp_path / "all", SHORT, seed=3)
    train((replace(toy_store, labels=labels), known[5:]), tmp_path / "known", SHORT, seed=3)
    assert_same_weights(tmp_path / "all", tmp_path / "known")
    card = json.loads((tmp_path / "all" / "card.json").read_text())
    assert card["settings"]["training_frames"] == len(known) - 5


# The rate


def test_the_rate_rises_to_its_peak_and_falls_to_nearly_nothing() -> None:
    rates = [learning_rate(step, 90, 2.5e-3, 0.15) for step in range(90)]
    assert max(rates) == pytest.approx(2.5e-3, rel=0.01)
    assert rates[0] < 0.1 * 2.5e-3
    assert rates[-1] < 0.01 * 2.5e-3
