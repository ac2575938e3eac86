import numpy as np
import torch

from twonav_cli.localizer.networks import network_spec
from twonav_cli.localizer.regression import RegressionHead
from twonav_cli.localizer.stored_network import LEVELS, packed, set_weights
from twonav_cli.localizer.training_config import TrainingConfig

LABELS = np.random.default_rng(1).uniform((0, 0, -3), (5, 5, 3), (50, 3)).astype(np.float32)


def test_a_network_comes_back_within_half_a_level_of_each_row_and_its_answers_hardly_change() -> None:
    torch.manual_seed(0)
    head = RegressionHead.fitted(LABELS, TrainingConfig(network="cnn-7"))
    network, again = (network_spec("cnn-7").build(head).eval() for _ in range(2))
    arrays = packed(network, head)
    assert arrays["network.dense.weight"].dtype == np.int8
    set_weights(again, arrays)
    before, after = network.dense.weight.detach().numpy(), again.dense.weight.detach().numpy()
    largest = np.abs(before).max(axis=1, keepdims=True)
    assert (np.abs(before - after) <= 0.51 * largest / LEVELS).all()
    assert not np.array_equal(before, after)
    pictures = torch.rand(4, 3, 84, 84)
    with torch.inference_mode():
        one, other = network(pictures), again(pictures)
    assert (one - other).abs().max() < 0.02 * one.abs().max()


def test_a_checkpoint_takes_little_more_than_a_byte_for_each_number_of_a_dense_layer() -> None:
    head = RegressionHead.fitted(LABELS, TrainingConfig(network="inception-9"))
    network = network_spec("inception-9").build(head)
    size = sum(array.nbytes for array in packed(network, head).values())
    assert size < 1.3 * sum(parameter.numel() for parameter in network.parameters())
