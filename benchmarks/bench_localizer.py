"""What the localizer costs: pictures learned per second against plain PyTorch, and one picture at a time.

Run: python benchmarks/bench_localizer.py. One core; both sides of a ratio take turns in one process and are timed by
its CPU time. "Plain" is the same network and loss in float32 with PyTorch's usual memory layout.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import torch
from torch import nn

from twonav_cli.localizer.belief_head import BeliefHead
from twonav_cli.localizer.devices import arithmetic, chosen_precision
from twonav_cli.localizer.estimator import Estimator
from twonav_cli.localizer.networks import OURS, network_spec
from twonav_cli.localizer.pictures import network_input
from twonav_cli.localizer.training_config import training_settings

ROUNDS, STEPS, BATCH = 5, 4, 128
SINGLE_PICTURES = 300
CHECKPOINT = Path(__file__).parents[1] / "checkpoints" / "apartment" / "localizer"
CPU = torch.device("cpu")


def learner(head: BeliefHead, precision: str, channels_last: bool) -> Callable[[], None]:
    """Return one step of learning from a batch of made-up pictures."""
    network = network_spec(OURS).build(head)
    if not channels_last:
        network = network.to(memory_format=torch.contiguous_format)
        for module in network.modules():
            if isinstance(module, nn.Conv2d):
                module.weight.data = module.weight.data.contiguous()
    optimizer = torch.optim.AdamW(network.parameters(), lr=1e-3, fused=channels_last)
    images = torch.randint(0, 256, (BATCH, 84, 84, 3), dtype=torch.uint8)
    poses = torch.tensor([[5.0, 4.0, 0.3]]).expand(BATCH, 3)

    def step() -> None:
        pictures = network_input(images, "rgb84")
        with arithmetic(CPU, precision):
            outputs = network(pictures if channels_last else pictures.contiguous())
        optimizer.zero_grad()
        head.loss(outputs.float(), poses).backward()
        optimizer.step()

    return step


def cpu_s(action: Callable[[], object], times: int) -> float:
    """Return the CPU seconds of doing something a few times."""
    begun = time.process_time()
    for _ in range(times):
        action()
    return time.process_time() - begun


def main() -> None:
    """Print both figures."""
    torch.set_num_threads(1)
    labels = np.random.default_rng(0).uniform((0.5, 0.5, -3), (13.5, 8.5, 3), (20_000, 3)).astype(np.float32)
    head = BeliefHead.fitted(labels, training_settings(OURS))
    precision = chosen_precision("auto", CPU)
    ours, plain = learner(head, precision, True), learner(head, "float32", False)
    ours(), plain()
    times = np.array([(cpu_s(ours, STEPS), cpu_s(plain, STEPS)) for _ in range(ROUNDS)])
    ours_s, plain_s = np.median(times, axis=0)
    pictures = STEPS * BATCH
    ratio = np.median(times[:, 1] / times[:, 0])
    print(
        f"learning, {precision}: {pictures / ours_s:.0f} pictures/s, plain {pictures / plain_s:.0f}; {ratio:.2f} times"
    )
    estimator = Estimator.load(CHECKPOINT)
    image = np.random.default_rng(1).integers(0, 256, (84, 84, 3), dtype=np.uint8)
    estimator.estimate(image)
    single = [cpu_s(lambda: estimator.estimate(image), 1) for _ in range(SINGLE_PICTURES)]
    print(f"one picture, network and decoding: {1e3 * np.median(single):.2f} ms")


if __name__ == "__main__":
    main()
