from concurrent.futures import ThreadPoolExecutor

import pytest
import torch
from torch import Tensor, nn

from twonav_cli.localizer.gradients import PartwiseGradients

X = torch.randn(12, 5, generator=torch.Generator().manual_seed(0))
PARTS = [slice(0, 5), slice(5, 10), slice(10, 12)]


def filled(network: nn.Module, parts: list[slice]) -> float:
    def loss(copied: nn.Module, part: slice, seed: int) -> Tensor:
        return copied(X[part]).square().sum(dim=1).mean()

    with ThreadPoolExecutor(2) as pool:
        gradients = PartwiseGradients(network, torch.device("cpu"), "float32", pool)
        return gradients.fill(list(network.parameters()), loss, parts, [0] * len(parts))


def test_parts_of_uneven_size_add_up_to_the_gradient_of_the_whole_batch() -> None:
    network = nn.Linear(5, 3)
    whole = network(X).square().sum(dim=1).mean()
    expected = torch.autograd.grad(whole, list(network.parameters()))
    assert filled(network, PARTS) == pytest.approx(float(whole.detach()), rel=1e-5)
    for parameter, gradient in zip(network.parameters(), expected, strict=True):
        assert parameter.grad is not None
        assert torch.allclose(parameter.grad, gradient, atol=1e-5)


def test_what_a_normalisation_remembers_is_the_mean_of_what_the_parts_saw() -> None:
    network = nn.Sequential(nn.BatchNorm1d(5), nn.Linear(5, 1))
    norm = network[0]
    assert isinstance(norm, nn.BatchNorm1d)
    filled(network, PARTS)
    means = torch.stack([X[part].mean(dim=0) for part in PARTS]).mean(dim=0)
    assert norm.running_mean is not None
    assert norm.num_batches_tracked is not None
    assert torch.allclose(norm.running_mean, 0.1 * means, atol=1e-6)
    assert norm.num_batches_tracked.item() == 1
