"""The stacked denoising autoencoders of Table 1: layers that learn to undo noise, then one network to a pose (§4.2.1).

Sigmoid units, tied weights, masking noise and cross entropy, as in Vincent et al. 2010. On top of the stack stands one
hidden layer of 512 (as in the convolutional networks; the paper names no size), then the output. B batch, D = 3888
inputs, K layers.
"""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from twonav_cli.localizer.pictures import SMALL_PX

INPUTS = 3 * SMALL_PX * SMALL_PX
CORRUPTION = 0.2
"""Share of a layer's inputs that are set to zero while it learns to undo that (Table 1)."""

DENSE = 512


class StackedAutoencoder(nn.Module):
    """K layers with a decoder each, and the layers on top that give the pose."""

    def __init__(self, units: tuple[int, ...], outputs: int, inputs: int = INPUTS) -> None:
        super().__init__()
        sizes = (inputs, *units)
        self.layers = nn.ModuleList(nn.Linear(below, above) for below, above in zip(sizes, units, strict=False))
        self.decoder_biases = nn.ParameterList(nn.Parameter(torch.zeros(below)) for below in sizes[:-1])
        self.dense = nn.Linear(units[-1], DENSE)
        self.out = nn.Linear(DENSE, outputs)
        for layer, below, above in zip(self.layers, sizes, units, strict=False):
            # Glorot and Bengio 2010, times 4 for sigmoid units.
            bound = 4.0 * math.sqrt(6.0 / (below + above))
            nn.init.uniform_(layer.weight, -bound, bound)  # type: ignore[arg-type]  # a Linear's weight
            nn.init.zeros_(layer.bias)  # type: ignore[arg-type]  # a Linear's bias

    def forward(self, pictures: Tensor) -> Tensor:
        """Map pictures [B, 3, 36, 36], 0 to 1, to numbers [B, outputs]."""
        x = self.encoded(pictures.flatten(1), len(self.layers))
        x = torch.relu(self.dense(x))
        # Metres need more digits than bfloat16 has: 3 cm at 7 m.
        with torch.autocast(x.device.type, enabled=False):
            return self.out(x.float())  # type: ignore[no-any-return]  # a module returns Any

    def encoded(self, x: Tensor, layers: int) -> Tensor:
        """Map inputs [B, D] to the units of a layer [B, units]; with 0 layers to themselves."""
        for layer in self.layers[:layers]:
            x = torch.sigmoid(layer(x))
        return x

    def denoising_loss(self, pictures: Tensor, layer: int, generator: torch.Generator) -> Tensor:
        """Return the cross entropy between the inputs of a layer and what it makes of them with a fifth masked.

        Args:
            pictures: [B, 3, 36, 36], 0 to 1.
            layer: Which, from 0; those below it stay as they are.
            generator: Draws the mask, on the processor.
        """
        with torch.no_grad():
            clean = self.encoded(pictures.flatten(1), layer).float()
            kept = torch.rand(clean.shape, generator=generator).to(clean.device) >= CORRUPTION
        encoder = self.layers[layer]
        hidden = torch.sigmoid(encoder(clean * kept))
        logits = functional.linear(hidden, encoder.weight.t(), self.decoder_biases[layer])  # type: ignore[operator]  # a Linear's weight
        return functional.binary_cross_entropy_with_logits(logits.float(), clean)

    def layer_parameters(self, layer: int) -> list[nn.Parameter]:
        """Return what a layer learns while it undoes noise."""
        return [*self.layers[layer].parameters(), self.decoder_biases[layer]]

    def pose_parameters(self) -> list[nn.Parameter]:
        """Return what learns the pose: everything but the decoders."""
        return [*self.layers.parameters(), *self.dense.parameters(), *self.out.parameters()]
