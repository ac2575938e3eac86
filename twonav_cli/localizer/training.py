"""Training a localizer on collected frames: the loop.

B batch, N frames.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from twonav_cli.checkpoint import save_checkpoint
from twonav_cli.dataset.collect import SIMULATOR
from twonav_cli.dataset.store import FrameStore, Indices
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, FittingStep, FittingValidated, Sink
from twonav_cli.localizer.errors_report import error_metrics
from twonav_cli.localizer.nearest import nearest_poses
from twonav_cli.localizer.networks import PoseNetwork, build_network, network_input
from twonav_cli.localizer.objective import pose_loss, varied
from twonav_cli.localizer.pose_code import HEADING_BINS, POSITION_BIN_M, PoseCode
from twonav_cli.localizer.training_state import STATE_FILE, load_state, save_state
from twonav_cli.rng import stream


def _setting(default: Any, sentence: str) -> Any:
    return field(default=default, metadata={"help": sentence})


_MAY_CHANGE = ("images", "threads", "validations", "validation_frames", "paper_frames", "save_every_s")
"""Settings that a training may change when it goes on: the first moves the end and with it the rate's fall."""


@dataclass(frozen=True)
class TrainingConfig:
    """How a localizer is trained."""

    architecture: str = _setting("inception-9", "Network, a name of ARCHITECTURES (§4.2.2: nine layers, no pooling).")
    images: int = _setting(800_000, "Pictures shown in all, repeats included (ours).")
    batch: int = _setting(128, "Pictures between two updates (ours).")
    part: int = _setting(32, "Pictures a thread takes at a time; normalised together (ours).")
    threads: int = _setting(2, "Threads that compute gradients, one core each (ours).")
    peak_rate: float = _setting(2.5e-3, "Largest learning rate of the one-cycle schedule (ours).")
    warm_up: float = _setting(0.15, "Share of the batches in which the rate rises (ours).")
    weight_decay: float = _setting(0.02, "Decoupled weight decay of AdamW (ours).")
    huber_weight: float = _setting(0.3, "Weight of the decoded pose's error beside the cross entropy (ours).")
    variation: float = _setting(0.1, "Largest relative change of brightness, contrast and colour (ours).")
    position_bin_m: float = _setting(POSITION_BIN_M, "Edge of a position bin (ours).")
    validations: int = _setting(6, "How often the held-out frames are tried during training (ours).")
    validation_frames: int = _setting(1000, "Held-out frames tried each time; the end tries all (ours).")
    paper_frames: int = _setting(4000, "Frames of the paper's test split tried at the end (ours).")
    save_every_s: float = _setting(60.0, "Time between two saves of the training's state (ours).")

    @property
    def steps(self) -> int:
        """Number of batches."""
        return max(1, self.images // self.batch)


def learning_rate(step: int, config: TrainingConfig) -> float:
    """Return the rate of a batch: a cosine up to the peak, then a cosine down to nearly nothing (one cycle; ours)."""
    rising = max(1, round(config.warm_up * config.steps))
    if step < rising:
        share, low = step / rising, 0.04
    else:
        share, low = 1.0 - (step - rising) / max(1, config.steps - rising), 0.0005
    return config.peak_rate * (low + (1.0 - low) * 0.5 * (1.0 - math.cos(math.pi * share)))


def batch_indices(step: int, training: Indices, batch: int, seed: int) -> Indices:
    """Return the frames of a batch [B]; the step alone fixes them, and each pass has an order of its own."""
    per_pass = len(training) // batch
    order = stream(seed, "batches", step // per_pass).permutation(training)
    start = (step % per_pass) * batch
    return np.asarray(order[start : start + batch])


def train(
    store: FrameStore,
    folder: Path,
    config: TrainingConfig,
    seed: int,
    should_stop: Callable[[], bool] | None = None,
    sink: Sink | None = None,
    resume: bool = False,
    command: str = "",
) -> Path | None:
    """Train a localizer and save it as a checkpoint.

    Args:
        store: Frames of one scene.
        folder: Where the checkpoint goes, and until then the training's state.
        config: How.
        seed: Seed of weights, batches and variations.
        should_stop: Asked after every batch; True saves the state and ends.
        sink: Gets FittingStep and FittingValidated.
        resume: Go on from the state in the folder; without one, start.
        command: The command line, for the card.

    Returns:
        The folder, or None when stopped before the end.

    Raises:
        TwonavError: Too few frames, unknown architecture, a state of another training, or a folder that cannot be
            written.
    """
    return _Training(store, folder, config, seed, sink or (lambda event: None)).run(should_stop, resume, command)


class _Training:
    """The network, its optimizer and the frames of one training."""

    def __init__(self, store: FrameStore, folder: Path, config: TrainingConfig, seed: int, sink: Sink) -> None:
        self.store, self.folder, self.config, self.seed, self.sink = store, folder, config, seed, sink
        self.frames = store.training()
        if len(self.frames) < config.batch:
            raise TwonavError(
                f"{len(self.frames)} training frames are too few for batches of {config.batch}: collect more"
            )
        self.code = PoseCode.covering(store.labels[store.labelled()], config.position_bin_m)
        torch.set_num_threads(1)  # Two threads inside an operation collapse when another program needs a core.
        torch.manual_seed(int(stream(seed, "weights").integers(2**31)))
        self.network = build_network(config.architecture, len(self.code.bins), HEADING_BINS)
        self.parameters = list(self.network.parameters())
        decayed = [{"params": [p for p in self.parameters if p.ndim >= 2], "weight_decay": config.weight_decay}]
        plain = [{"params": [p for p in self.parameters if p.ndim < 2], "weight_decay": 0.0}]
        self.optimizer = torch.optim.AdamW(decayed + plain, lr=config.peak_rate, fused=True)

    def run(self, should_stop: Callable[[], bool] | None, resume: bool, command: str) -> Path | None:
        """Train to the end, or until told to stop."""
        config, step = self.config, 0
        if resume:
            step = load_state(self.folder, self.network, self.optimizer, self._facts())
        saved_s = shown_s = time.monotonic()
        shown_step, losses = step, [0.0]
        marks = {round(config.steps * k / config.validations) for k in range(1, config.validations)}
        with ThreadPoolExecutor(config.threads) as pool:
            while step < config.steps:
                losses.append(self._update(step, pool))
                step += 1
                now_s = time.monotonic()
                if step % 20 == 0 or step == config.steps:
                    speed = (step - shown_step) * config.batch / max(now_s - shown_s, 1e-9)
                    rate = learning_rate(step - 1, config)
                    self.sink(FittingStep(self._clock(step), float(np.mean(losses[-20:])), rate, speed))
                    shown_s, shown_step, losses = now_s, step, losses[-20:]
                if step in marks:
                    self.sink(FittingValidated(self._clock(step), self._metrics(self._validation_frames(), pool)))
                stopping = should_stop is not None and should_stop() and step < config.steps
                if stopping or now_s - saved_s > config.save_every_s:
                    save_state(self.folder, self.network, self.optimizer, {**self._facts(), "step": step})
                    saved_s = now_s
                if stopping:
                    return None
            return self._finish(pool, command)

    def _update(self, step: int, pool: ThreadPoolExecutor) -> float:
        """Make one step of AdamW and return the loss; the threads share a batch part by part."""
        config = self.config
        self.network.train()
        images, poses = self.store.batch(batch_indices(step, self.frames, config.batch, self.seed))
        parts = [slice(start, start + config.part) for start in range(0, config.batch, config.part)]
        draws = stream(self.seed, "variation", step).integers(2**31, size=len(parts))
        jobs = [
            pool.submit(self._gradients, images[part], poses[part], int(draw))
            for part, draw in zip(parts, draws, strict=True)
        ]
        results = [job.result() for job in jobs]
        for parameter, gradients in zip(self.parameters, zip(*(g for _, g in results), strict=True), strict=True):
            total = gradients[0]
            for gradient in gradients[1:]:
                total.add_(gradient)
            parameter.grad = total
        for group in self.optimizer.param_groups:
            group["lr"] = learning_rate(step, config)
        self.optimizer.step()
        loss = sum(value for value, _ in results)
        if not math.isfinite(loss):
            raise TwonavError(f"training diverged at batch {step}: use a smaller peak rate")
        return loss

    def _gradients(
        self, images: NDArray[np.uint8], poses: NDArray[np.float32], draw: int
    ) -> tuple[float, tuple[Tensor, ...]]:
        """Return the loss of a part of a batch and its gradients, both as the part's share of the batch."""
        generator = torch.Generator().manual_seed(draw)
        x = varied(torch.from_numpy(images), self.config.variation, generator)
        position, heading = self.network(x)
        loss = pose_loss(position, heading, torch.from_numpy(poses), self.code, self.config.huber_weight)
        loss = loss * (len(images) / self.config.batch)
        return float(loss.detach()), torch.autograd.grad(loss, self.parameters)

    def _metrics(self, frames: Indices, pool: ThreadPoolExecutor) -> dict[str, float]:
        """Return the errors of the network at some frames."""
        self.network.eval()
        ordered = np.sort(frames)
        parts = [ordered[start : start + 64] for start in range(0, len(ordered), 64)]
        estimated = pool.map(lambda part: decoded_poses(self.network, self.code, self.store.batch(part)[0]), parts)
        return error_metrics(np.concatenate(list(estimated)), self.store.poses[ordered])

    def _finish(self, pool: ThreadPoolExecutor, command: str) -> Path:
        """Measure, save the checkpoint and drop the training's state."""
        metrics: dict[str, Any] = {}
        paper = stream(self.seed, "paper test").permutation(self.store.paper_test())[: self.config.paper_frames]
        off_grid = self.store.off_grid()
        for name, frames in (("off_grid", off_grid), ("paper_split", paper)):
            if len(frames):
                metrics[name] = self._metrics(frames, pool)
        if len(off_grid):
            nearest = nearest_poses(self.store, self.frames, off_grid)
            metrics["off_grid_nearest_frame"] = error_metrics(nearest, self.store.poses[off_grid])
            self.sink(FittingValidated(self._clock(self.config.steps), metrics["off_grid"]))
        meta = self.store.meta
        metrics |= {"labels": label_metrics(self.store)}
        card = {
            "kind": "localizer",
            "scene": meta["scene"],
            "scene_digest": meta["scene_digest"],
            "map_digest": meta.get("map_digest"),
            "command": command,
            "seed": self.seed,
            "metrics": metrics,
            "settings": {**asdict(self.config), "training_frames": len(self.frames), "bins": asdict(self.code.frame)},
            "render": meta.get("render", {}),
        }
        save_checkpoint(self.folder, shipped_arrays(self.network, self.code), card)
        (self.folder / STATE_FILE).unlink(missing_ok=True)
        return self.folder

    def _validation_frames(self) -> Indices:
        return self.store.off_grid()[: self.config.validation_frames]

    def _clock(self, step: int) -> Clock:
        return Clock(trial=step * self.config.batch // len(self.frames), step=step)

    def _facts(self) -> dict[str, Any]:
        """Return what a training that goes on must share with its beginning; it may end sooner or later."""
        config = {name: value for name, value in asdict(self.config).items() if name not in _MAY_CHANGE}
        return {"config": config, "seed": self.seed, "frames": self.store.meta}


def label_metrics(store: FrameStore) -> dict[str, Any]:
    """Return who labelled the frames, how many have no label, and how far labels lie from where the robot stood."""
    known = store.labelled()
    counts = {"by": store.meta.get("labels", SIMULATOR), "without_label": int((~known).sum())}
    return {**counts, **error_metrics(store.labels[known], store.poses[known])}


def decoded_poses(network: PoseNetwork, code: PoseCode, images: NDArray[np.uint8]) -> NDArray[np.float32]:
    """Return the estimated poses [B, 3] of images [B, 84, 84, 3]."""
    with torch.inference_mode():
        position, heading = network(network_input(torch.from_numpy(images)))
        return np.asarray(code.decode(position, heading).poses.numpy())


def shipped_arrays(network: PoseNetwork, code: PoseCode) -> dict[str, NDArray[Any]]:
    """Return what a checkpoint holds: kernels as float16, small vectors as float32, and the bins."""
    arrays: dict[str, NDArray[Any]] = {"bins": code.bins.astype(np.int32)}
    for name, value in network.state_dict().items():
        array = value.numpy()
        if array.dtype == np.float32 and array.ndim >= 2:
            array = array.astype(np.float16)
        arrays[f"network.{name}"] = array
    return arrays
