"""The state of a training: one safetensors file, written whole, from which a killed training goes on."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from twonav_cli.errors import TwonavError
from twonav_cli.files import write_whole

STATE_FILE = "training.safetensors"

_MOMENTS = ("exp_avg", "exp_avg_sq")

Facts = dict[str, Any]
"""JSON values."""


def save_state(folder: Path, network: nn.Module, optimizer: torch.optim.AdamW, facts: Facts) -> Path:
    """Write weights, the optimizer's moments and a few facts.

    Raises:
        TwonavError: The folder cannot be written.
    """
    from safetensors.numpy import save

    arrays = {f"network.{name}": value.detach().cpu().numpy() for name, value in network.state_dict().items()}
    for name, parameter in network.named_parameters():
        for moment in _MOMENTS:
            if parameter in optimizer.state:
                arrays[f"{moment}.{name}"] = optimizer.state[parameter][moment].cpu().numpy()
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    return write_whole(folder / STATE_FILE, save(contiguous, metadata={"facts": json.dumps(facts)}))


class FoundState:
    """A training's state as it was read.

    Attributes:
        facts: As they were saved.
    """

    def __init__(self, facts: Facts, arrays: dict[str, Tensor]) -> None:
        self.facts = facts
        self._arrays = arrays

    def restore_weights(self, network: nn.Module) -> None:
        """Put the weights into a network.

        Raises:
            TwonavError: They are those of another one.
        """
        prefix = "network."
        own = {name.removeprefix(prefix): x for name, x in self._arrays.items() if name.startswith(prefix)}
        try:
            network.load_state_dict(own)
        except RuntimeError as error:
            raise TwonavError(
                f"the {STATE_FILE} is of another network or version of twonav: delete it and train from the start"
            ) from error

    def restore_moments(self, network: nn.Module, optimizer: torch.optim.AdamW, updates: int) -> None:
        """Put the moments into an optimizer that has made some updates."""
        for name, parameter in network.named_parameters():
            keys = {moment: f"{moment}.{name}" for moment in _MOMENTS}
            if all(key in self._arrays for key in keys.values()):
                moments = {moment: torch.empty_like(parameter).copy_(self._arrays[key]) for moment, key in keys.items()}
                count = torch.tensor(float(updates), device=parameter.device)
                optimizer.state[parameter] = {"step": count, **moments}


def find_state(folder: Path, must_agree: Facts) -> FoundState | None:
    """Read the state of a training; None where there is none.

    Args:
        folder: Where it is.
        must_agree: What must be the same in the state's facts; they may hold more.

    Raises:
        TwonavError: The state is damaged, or of a training with other settings.
    """
    from safetensors import SafetensorError, safe_open

    path = folder / STATE_FILE
    if not path.exists():
        return None
    try:
        with safe_open(path, framework="numpy") as file:
            facts = json.loads((file.metadata() or {}).get("facts", "{}"))
            arrays = {name: torch.from_numpy(file.get_tensor(name)) for name in file.keys()}  # noqa: SIM118
        int(facts["step"])
    except (OSError, SafetensorError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise TwonavError(f"{path} is damaged: delete it and train from the start") from error
    if not _agrees(facts, json.loads(json.dumps(must_agree))):
        raise TwonavError(f"{path} is of a training with other settings or frames: use the same, or start anew")
    return FoundState(facts, arrays)


def _agrees(found: Any, wanted: Any) -> bool:
    """Whether everything in `wanted`, key by key, is the same in `found`."""
    if isinstance(wanted, dict):
        return isinstance(found, dict) and all(_agrees(found.get(key), value) for key, value in wanted.items())
    return bool(found == wanted)
