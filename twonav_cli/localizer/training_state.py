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


def save_state(folder: Path, network: nn.Module, optimizer: torch.optim.AdamW, facts: dict[str, Any]) -> Path:
    """Write weights, the optimizer's moments and a few facts (JSON values, among them "step").

    Raises:
        TwonavError: The folder cannot be written.
    """
    from safetensors.numpy import save

    arrays = {f"network.{name}": value.detach().numpy() for name, value in network.state_dict().items()}
    for name, parameter in network.named_parameters():
        for moment in _MOMENTS:
            if parameter in optimizer.state:
                arrays[f"{moment}.{name}"] = optimizer.state[parameter][moment].numpy()
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    return write_whole(folder / STATE_FILE, save(contiguous, metadata={"facts": json.dumps(facts)}))


def load_state(folder: Path, network: nn.Module, optimizer: torch.optim.AdamW, facts: dict[str, Any]) -> int:
    """Restore a training in place.

    Args:
        folder: Where the state is.
        network: Gets the weights.
        optimizer: Gets the moments.
        facts: What must have been the same; the state may hold more.

    Returns:
        The number of batches done; 0 where there is no state.

    Raises:
        TwonavError: The state is damaged, or of a training with other settings.
    """
    from safetensors import SafetensorError, safe_open

    path = folder / STATE_FILE
    if not path.exists():
        return 0
    try:
        with safe_open(path, framework="numpy") as file:
            found = json.loads((file.metadata() or {}).get("facts", "{}"))
            arrays = {name: torch.from_numpy(file.get_tensor(name)) for name in file.keys()}  # noqa: SIM118
        step = int(found.pop("step"))
    except (OSError, SafetensorError, ValueError, KeyError, AttributeError) as error:
        raise TwonavError(f"{path} is damaged: delete it and train from the start") from error
    if not _agrees(found, json.loads(json.dumps(facts))):
        raise TwonavError(f"{path} is of a training with other settings or frames: use the same, or start anew")
    _restore(network, optimizer, arrays, step)
    return step


def _agrees(found: Any, wanted: Any) -> bool:
    """Whether everything in `wanted`, key by key, is the same in `found`."""
    if isinstance(wanted, dict):
        return isinstance(found, dict) and all(_agrees(found.get(key), value) for key, value in wanted.items())
    return bool(found == wanted)


def _restore(network: nn.Module, optimizer: torch.optim.AdamW, arrays: dict[str, Tensor], step: int) -> None:
    prefix = "network."
    network.load_state_dict({k.removeprefix(prefix): v for k, v in arrays.items() if k.startswith(prefix)})
    for name, parameter in network.named_parameters():
        moments = {moment: arrays[f"{moment}.{name}"] for moment in _MOMENTS if f"{moment}.{name}" in arrays}
        if moments:
            layout = {key: torch.empty_like(parameter).copy_(value) for key, value in moments.items()}
            optimizer.state[parameter] = {"step": torch.tensor(float(step)), **layout}
