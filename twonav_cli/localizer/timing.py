"""What one picture costs: network and decoding, on one core."""

from __future__ import annotations

import time

import numpy as np
import torch
from numpy.typing import NDArray

from twonav_cli.localizer.estimator import Estimator

PICTURES = 200


def milliseconds_of(estimator: Estimator, images: NDArray[np.uint8]) -> float:
    """Return the median CPU time of one picture of some [N, 84, 84, 3], in milliseconds, on one thread."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        taken_s = [_cpu_s(estimator, image) for image in images[:PICTURES]]
    finally:
        torch.set_num_threads(threads)
    return 1e3 * float(np.median(taken_s))


def _cpu_s(estimator: Estimator, image: NDArray[np.uint8]) -> float:
    begun_s = time.process_time()
    estimator.estimate(image)
    return time.process_time() - begun_s
