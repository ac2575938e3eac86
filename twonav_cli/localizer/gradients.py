"""The gradients of a batch: parts of a fixed size, shared among threads, added up in a fixed order.

Which thread takes a part changes nothing, so neither does their number. B batch.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from copy import deepcopy

import torch
from torch import Tensor, nn

from twonav_cli.localizer.devices import arithmetic

Loss = Callable[[nn.Module, slice, int], Tensor]
"""Gives the mean loss of a network over a part of the batch, with a number that seeds the part's randomness."""


class PartwiseGradients:
    """A network, and a copy of it for each part of a batch that shares its weights.

    The copies are there for what a layer notes while it computes, as the running means of a normalisation: two threads
    cannot write them in a fixed order.
    """

    def __init__(self, network: nn.Module, device: torch.device, precision: str, pool: ThreadPoolExecutor) -> None:
        self._network = network
        self._device, self._precision, self._pool = device, precision, pool
        self._copies: list[nn.Module] = []

    def fill(self, parameters: list[nn.Parameter], loss: Loss, parts: list[slice], seeds: list[int]) -> float:
        """Put the gradients of a batch into some parameters.

        Args:
            parameters: Whose gradients are wanted.
            loss: Of a part.
            parts: Each part's place in the batch.
            seeds: One for each part.

        Returns:
            The mean loss of the batch.
        """
        total = max(part.stop for part in parts)
        copies = self._refreshed(len(parts))

        def share(network: nn.Module, part: slice, seed: int) -> tuple[Tensor, tuple[Tensor, ...]]:
            with arithmetic(self._device, self._precision):
                value = loss(network, part, seed) * ((part.stop - part.start) / total)
            return value.detach(), torch.autograd.grad(value, parameters)

        jobs = [self._pool.submit(share, *job) for job in zip(copies, parts, seeds, strict=True)]
        results = [job.result() for job in jobs]
        for parameter, gradients in zip(parameters, zip(*(g for _, g in results), strict=True), strict=True):
            sum_ = gradients[0]
            for gradient in gradients[1:]:
                sum_.add_(gradient)
            parameter.grad = sum_
        self._merge(copies)
        return float(sum(value for value, _ in results))

    def _refreshed(self, count: int) -> list[nn.Module]:
        """Return copies of the network that share its weights and hold its notes, ready to learn."""
        while len(self._copies) < count:
            shared = {id(parameter): parameter for parameter in self._network.parameters()}
            self._copies.append(deepcopy(self._network, shared))
        for copied in self._copies[:count]:
            copied.train()
            for note, own in zip(copied.buffers(), self._network.buffers(), strict=True):
                note.copy_(own)
        return self._copies[:count]

    @torch.no_grad()
    def _merge(self, copies: list[nn.Module]) -> None:
        """Make each note of the network the mean of its copies' notes; one that counts is the same in all."""
        for own, *notes in zip(self._network.buffers(), *(copied.buffers() for copied in copies), strict=True):
            if own.is_floating_point():
                own.copy_(torch.stack(notes).mean(dim=0))
            else:
                own.copy_(notes[0])
