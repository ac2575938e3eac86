"""One seed, named streams: drawing more from one stream never changes another."""

from __future__ import annotations

import zlib

import numpy as np


def stream(seed: int, name: str, *indices: int) -> np.random.Generator:
    """Return the generator of one named stream of a seed.

    Args:
        seed: The seed of the run.
        name: What is drawn: "explore", "replay", "odometry", "poses", "batches", "weights".
        indices: Further numbers that tell streams of the same name apart (repeat, worker). A last index of 0
            is the same as none, so each name keeps to one number of indices.
    """
    return np.random.default_rng([seed & 0xFFFFFFFF, zlib.crc32(name.encode()), *indices])
