"""What a training does one after the other: each layer of an autoencoder undoes noise, then all learn the pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import torch
from torch import Tensor, nn

from twonav_cli.errors import TwonavError
from twonav_cli.localizer.autoencoder import StackedAutoencoder
from twonav_cli.localizer.heads import Head
from twonav_cli.localizer.training_config import TrainingConfig

PhaseLoss = Callable[[nn.Module, Tensor, Tensor, torch.Generator], Tensor]
"""Gives the mean loss of a network for pictures [B, ...] and poses [B, 3]; the generator draws what is random."""


@dataclass(frozen=True)
class Phase:
    """Some batches of a training.

    Attributes:
        start: Its first batch.
        stop: The first batch after it.
        parameters: What it trains.
        loss: What it makes small.
        peak_rate: Its largest learning rate.
        weight_decay: Its decoupled weight decay.
    """

    start: int
    stop: int
    parameters: list[nn.Parameter]
    loss: PhaseLoss
    peak_rate: float
    weight_decay: float

    def optimizer(self) -> torch.optim.AdamW:
        """Return a fresh optimizer; only matrices and kernels decay."""
        decayed = [parameter for parameter in self.parameters if parameter.ndim >= 2]
        plain = [parameter for parameter in self.parameters if parameter.ndim < 2]
        groups = [{"params": decayed, "weight_decay": self.weight_decay}, {"params": plain, "weight_decay": 0.0}]
        return torch.optim.AdamW(groups, lr=self.peak_rate, fused=True)


def phases(network: nn.Module, head: Head, config: TrainingConfig) -> list[Phase]:
    """Return the phases of a training, without gaps.

    Raises:
        TwonavError: Layers of a network without any decoder are to be trained before.
    """
    before: list[Phase] = []
    parameters = list(network.parameters())
    if isinstance(network, StackedAutoencoder):
        before, parameters = _denoising(network, config), network.pose_parameters()
    elif config.pretraining_images:
        raise TwonavError(f"{config.network} is no autoencoder: set the pictures of its pretraining to 0")
    loss = partial(_pose_loss, head)
    first = config.pretraining_steps
    return [*before, Phase(first, config.steps, parameters, loss, config.peak_rate, config.weight_decay)]


def _denoising(network: StackedAutoencoder, config: TrainingConfig) -> list[Phase]:
    """Return one phase for each layer; they share the batches evenly."""
    layers = len(network.layers)
    bounds = [config.pretraining_steps * layer // layers for layer in range(layers + 1)]
    found = [
        Phase(
            bounds[layer], bounds[layer + 1], network.layer_parameters(layer), partial(_denoising_loss, layer),
            config.pretraining_rate, weight_decay=0.0,
        )
        for layer in range(layers)
    ]  # fmt: skip
    return [phase for phase in found if phase.stop > phase.start]


def _pose_loss(head: Head, network: nn.Module, pictures: Tensor, poses: Tensor, generator: torch.Generator) -> Tensor:
    outputs = network(pictures)
    with torch.autocast(pictures.device.type, enabled=False):
        return head.loss(outputs.float(), poses)


def _denoising_loss(
    layer: int, network: nn.Module, pictures: Tensor, poses: Tensor, generator: torch.Generator
) -> Tensor:
    assert isinstance(network, StackedAutoencoder)
    return network.denoising_loss(pictures, layer, generator)
