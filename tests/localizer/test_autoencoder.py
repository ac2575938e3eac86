from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
import torch

from twonav_cli.checkpoint import load_checkpoint
from twonav_cli.dataset.store import FrameStore
from twonav_cli.localizer import networks
from twonav_cli.localizer.autoencoder import StackedAutoencoder
from twonav_cli.localizer.batches import Selection
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.localizer.phases import phases
from twonav_cli.localizer.pictures import network_input
from twonav_cli.localizer.regression import RegressionHead
from twonav_cli.localizer.training import train
from twonav_cli.localizer.training_config import TrainingConfig, training_settings
from twonav_cli.localizer.training_state import STATE_FILE, find_state

UNITS = (100, 80)


@pytest.fixture(autouse=True)
def _small(monkeypatch: pytest.MonkeyPatch) -> None:
    """A stack that learns in seconds, beside those of Table 1."""
    spec = replace(networks.NETWORKS["sda-2x1500"], make=partial(StackedAutoencoder, UNITS))
    monkeypatch.setitem(networks.NETWORKS, "sda-small", spec)


@pytest.fixture
def frames(toy_store: FrameStore) -> Selection:
    return toy_store, toy_store.training()


def small_settings(**changes: object) -> TrainingConfig:
    config = training_settings("sda-small", batch=64, part=32, images=64 * 10, pretraining_images=64 * 10)
    return replace(config, **changes)  # type: ignore[arg-type]  # names are checked by replace


def denoising_error(network: StackedAutoencoder, layer: int, store: FrameStore) -> float:
    images = torch.from_numpy(store.batch(store.off_grid())[0])
    with torch.no_grad():
        pictures = network_input(images, "hsv36")
        return float(network.denoising_loss(pictures, layer, torch.Generator().manual_seed(0)))


def test_each_layer_learns_to_undo_noise_better_than_before(
    toy_store: FrameStore, frames: Selection, tmp_path: Path
) -> None:
    config = small_settings(pretraining_images=64 * 120)
    asked = iter([False] * 119 + [True])
    train(frames, tmp_path, config, seed=1, should_stop=lambda: next(asked))
    torch.manual_seed(0)
    network = StackedAutoencoder(UNITS, 4)
    state = find_state(tmp_path, {})
    assert state is not None
    untrained = denoising_error(network, 0, toy_store)
    state.restore_weights(network)
    assert denoising_error(network, 0, toy_store) < untrained - 0.02
    trained = denoising_error(network, 1, toy_store)
    network.layers[1] = StackedAutoencoder(UNITS, 4).layers[1]
    torch.nn.init.zeros_(network.decoder_biases[1])
    assert trained < denoising_error(network, 1, toy_store) - 0.02


def test_noise_hides_a_fifth_of_the_inputs_and_is_undone_with_the_encoders_own_weights() -> None:
    network = StackedAutoencoder((50,), 4, inputs=3 * 6 * 6)
    pictures = torch.rand(400, 3, 6, 6, generator=torch.Generator().manual_seed(0))
    seen = []
    network.layers[0].register_forward_hook(lambda layer, given, made: seen.append(given[0]))
    found = network.denoising_loss(pictures, 0, torch.Generator().manual_seed(1))
    masked = seen[0]
    kept = masked != 0
    assert 1.0 - kept.double().mean() == pytest.approx(0.2, abs=0.01)
    assert torch.equal(masked[kept], pictures.flatten(1)[kept])
    weight, bias = network.layers[0].weight, network.layers[0].bias
    undone = torch.sigmoid(torch.sigmoid(masked @ weight.t() + bias) @ weight + network.decoder_biases[0])
    clean = pictures.flatten(1)
    entropy = -(clean * undone.log() + (1 - clean) * (1 - undone).log()).mean()
    assert float(found.detach()) == pytest.approx(float(entropy.detach()), rel=1e-4)


def test_every_layer_is_trained_by_itself_and_then_all_with_the_output() -> None:
    network = StackedAutoencoder(UNITS, 4)
    head = RegressionHead.fitted(np.zeros((2, 3), np.float32), None)
    first, second, pose = phases(network, head, small_settings())
    assert [(phase.start, phase.stop) for phase in (first, second, pose)] == [(0, 5), (5, 10), (10, 20)]
    trained = {id(parameter) for parameter in second.parameters}
    assert trained == {id(p) for p in (*network.layers[1].parameters(), network.decoder_biases[1])}
    assert not {id(p) for p in first.parameters} & trained
    decoders = {id(p) for p in network.decoder_biases}
    assert {id(p) for p in pose.parameters} == {id(p) for p in network.parameters()} - decoders


def test_the_whole_stack_learns_more_than_the_mean_pose(
    toy_store: FrameStore, frames: Selection, tmp_path: Path
) -> None:
    train(frames, tmp_path, small_settings(images=64 * 150, pretraining_images=64 * 60), seed=1)
    images, poses = toy_store.batch(toy_store.off_grid())
    found = error_metrics(Estimator.load(tmp_path, "toy-digest").estimate_many(images), poses)
    mean = error_metrics(np.broadcast_to(poses.mean(axis=0), poses.shape), poses)
    assert found["pos_mean_m"] < 0.7 * mean["pos_mean_m"]
    assert found["ang_mean_deg"] < 0.4 * mean["ang_mean_deg"]


@pytest.mark.parametrize("stop_after", [3, 5, 8, 10, 14], ids=lambda batches: f"{batches} batches")
def test_a_training_stopped_in_any_phase_ends_with_the_same_weights(
    frames: Selection, tmp_path: Path, stop_after: int
) -> None:
    train(frames, tmp_path / "whole", small_settings(), seed=2)
    asked = iter([False] * (stop_after - 1) + [True])
    assert train(frames, tmp_path / "cut", small_settings(), seed=2, should_stop=lambda: next(asked)) is None
    assert (tmp_path / "cut" / STATE_FILE).exists()
    train(frames, tmp_path / "cut", small_settings(), seed=2, resume=True)
    whole, cut = (load_checkpoint(tmp_path / name, "localizer")[0] for name in ("whole", "cut"))
    assert [name for name in whole if not np.array_equal(whole[name], cut[name])] == []
