"""On what a network is trained, and with how many digits."""

from __future__ import annotations

import contextlib
import os
from typing import Any

import torch

from twonav_cli.errors import TwonavError, unknown_name

DEVICES = ("auto", "cpu", "cuda")
PRECISIONS = ("auto", "float32", "bfloat16")


def chosen_device(name: str) -> torch.device:
    """Return the device of a name; "auto" is a graphics card where there is one.

    Raises:
        TwonavError: The name is wrong, or there is no such device.
    """
    if name not in DEVICES:
        raise unknown_name("device", name, DEVICES)
    present = torch.cuda.is_available()
    if name == "cuda" and not present:
        raise TwonavError("there is no graphics card that torch can use (cuda): take the device cpu or auto")
    if name == "cpu" or not present:
        return torch.device("cpu")
    # Read when the first matrix is multiplied: without it the card may add in another order each time.
    os.environ.setdefault("CUBLAS_WORKSPACE_CONFIG", ":4096:8")
    torch.use_deterministic_algorithms(True, warn_only=True)
    torch.backends.cudnn.benchmark = False
    torch.backends.cudnn.allow_tf32 = False  # float32 means float32: what a card says holds on a processor
    return torch.device("cuda")


def chosen_precision(name: str, device: torch.device) -> str:
    """Return "float32" or "bfloat16"; "auto" is bfloat16 where the device has instructions for it.

    Raises:
        TwonavError: The name is wrong.
    """
    if name not in PRECISIONS:
        raise unknown_name("precision", name, PRECISIONS)
    if name != "auto":
        return name
    return "bfloat16" if _has_bfloat16(device) else "float32"


def arithmetic(device: torch.device, precision: str) -> contextlib.AbstractContextManager[Any]:
    """Return the context in which a network computes with a precision; each thread needs its own."""
    if precision == "float32":
        return contextlib.nullcontext()
    return torch.autocast(device.type, dtype=torch.bfloat16)


def device_name(device: torch.device) -> str:
    """Return what a card says about a device."""
    return torch.cuda.get_device_name(device) if device.type == "cuda" else "cpu"


def _has_bfloat16(device: torch.device) -> bool:
    if device.type == "cuda":
        return bool(torch.cuda.is_bf16_supported())
    # Torch keeps these two to itself and has renamed them before; without them bfloat16 is slower than float32.
    asked = (getattr(torch.cpu, name, None) for name in ("_is_avx512_bf16_supported", "_is_amx_tile_supported"))
    return any(bool(ask()) for ask in asked if ask is not None)
