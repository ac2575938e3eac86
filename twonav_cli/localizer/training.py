"""Training a localizer on collected frames: the one loop, for every network.

B batch, N frames.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from twonav_cli.checkpoint import save_checkpoint
from twonav_cli.errors import TwonavError
from twonav_cli.events import Clock, FittingStep, FittingValidated, Sink
from twonav_cli.files import digest_of
from twonav_cli.localizer.batches import Batch, Selection, batches
from twonav_cli.localizer.belief_head import BeliefHead
from twonav_cli.localizer.calibrating import calibration_frames, calibration_of
from twonav_cli.localizer.devices import chosen_device, chosen_precision, device_name
from twonav_cli.localizer.gradients import PartwiseGradients
from twonav_cli.localizer.measuring import label_metrics, measured, nearest_metrics, thinned, trial_metrics
from twonav_cli.localizer.networks import network_spec
from twonav_cli.localizer.phases import Phase, phases
from twonav_cli.localizer.pictures import network_input
from twonav_cli.localizer.stored_network import packed, set_weights
from twonav_cli.localizer.training_config import MAY_CHANGE, TrainingConfig, learning_rate
from twonav_cli.localizer.training_state import STATE_FILE, Facts, find_state, save_state
from twonav_cli.rng import stream

TELL_EVERY = 20
"""Batches between two FittingStep."""


def train(
    frames: Selection,
    folder: Path,
    config: TrainingConfig,
    seed: int,
    trials: Mapping[str, Selection] | None = None,
    validation: Selection | None = None,
    should_stop: Callable[[], bool] | None = None,
    sink: Sink | None = None,
    resume: bool = False,
    command: str = "",
) -> Path | None:
    """Train a localizer and save it as a checkpoint.

    Args:
        frames: What to learn from: a store and the indices of frames in it; those without a label are left out.
        folder: Where the checkpoint goes, and until then the training's state.
        config: How.
        seed: Seed of weights, batches and variations.
        trials: Name to frames at which the trained network is measured against the truth, for the card's metrics; each
            has a row of the most alike training frame beside it, its name with `_nearest` behind it.
        validation: Frames that are tried during training; None tries none.
        should_stop: Asked after every batch; True saves the state and ends.
        sink: Gets FittingStep and FittingValidated.
        resume: Go on from the state in the folder; without one, start.
        command: The command line, for the card.

    Returns:
        The folder, or None when stopped before the end.

    Raises:
        TwonavError: Too few frames, an unknown name, no such device, a state of another training, a training that
            diverges, or a folder that cannot be written.
    """
    training = _Training(frames, folder, config, seed, validation, sink or (lambda event: None))
    with training.pool:
        if not training.run(should_stop, resume):
            return None
        return training.finish(trials or {}, command)


class _Training:
    """The network, its optimizer and the frames of one training."""

    def __init__(
        self, frames: Selection, folder: Path, config: TrainingConfig, seed: int, validation: Selection | None,
        sink: Sink,
    ) -> None:  # fmt: skip
        self.store = frames[0]
        self.frames = frames[1][np.isfinite(self.store.labels[frames[1]]).all(axis=1)]
        self.folder, self.config, self.seed, self.sink = folder, config, seed, sink
        self.validation = validation if validation and len(validation[1]) else None
        if len(self.frames) < config.batch:
            raise TwonavError(
                f"{len(self.frames)} training frames are too few for batches of {config.batch}: collect more"
            )
        self.spec = network_spec(config.network)
        self.device = chosen_device(config.device)
        self.precision = chosen_precision(config.precision, self.device)
        torch.set_num_threads(1)  # Two threads inside an operation collapse when another program needs a core.
        torch.manual_seed(int(stream(seed, "weights").integers(2**31)))
        head = self.spec.head_class.fitted(self.store.labels[self.frames], config)
        self.network = self.spec.build(head).to(self.device)
        self.head = head.to(self.device)
        self.phases = phases(self.network, self.head, config)
        threads = config.threads if self.device.type == "cpu" else 1
        self.pool = ThreadPoolExecutor(threads, initializer=torch.set_num_threads, initargs=(1,))
        self.gradients = PartwiseGradients(self.network, self.device, self.precision, self.pool)
        self.seconds = 0.0

    def run(self, should_stop: Callable[[], bool] | None, resume: bool) -> bool:
        """Train to the end, and return True, or until told to stop."""
        found = find_state(self.folder, self._facts()) if resume else None
        begun = 0
        if found:
            begun, self.seconds = int(found.facts["step"]), float(found.facts["seconds"])
            found.restore_weights(self.network)
        for phase in self.phases:
            if phase.stop <= begun:
                continue
            optimizer, start = phase.optimizer(), max(begun, phase.start)
            if found and start > phase.start:
                found.restore_moments(self.network, optimizer, start - phase.start)
            if not self._run_phase(phase, optimizer, start, should_stop):
                return False
        return True

    def _run_phase(
        self, phase: Phase, optimizer: torch.optim.AdamW, start: int, should_stop: Callable[[], bool] | None
    ) -> bool:
        """Train from a batch to the end of a phase, and return True, or until told to stop."""
        config, progress = self.config, _Progress(start)
        share = config.pose_steps / max(1, config.validations)
        marks = {config.pretraining_steps + round(share * k) for k in range(1, config.validations + 1)}
        saved_s = since_s = time.monotonic()
        shown = batches((self.store, self.frames), start, phase.stop, config.batch, self.seed)
        with closing(shown):
            for step, batch in enumerate(shown, start=start + 1):
                rate = learning_rate(step - 1 - phase.start, phase.stop - phase.start, phase.peak_rate, config.warm_up)
                progress.losses.append(self._update(phase, optimizer, step - 1, batch, rate))
                self.seconds += time.monotonic() - since_s
                if step % TELL_EVERY == 0 or step == phase.stop:
                    self.sink(progress.told(self._clock(step), rate, config.batch))
                if step in marks and self.validation is not None:
                    self._validate(step)
                stopping = should_stop is not None and step < config.steps and should_stop()
                # At the end too: what comes then takes minutes, and may be killed as well.
                if stopping or step == config.steps or time.monotonic() - saved_s > config.save_every_s:
                    facts = {**self._facts(), "step": step, "seconds": self.seconds}
                    save_state(self.folder, self.network, optimizer, facts)
                    saved_s = time.monotonic()
                if stopping:
                    return False
                since_s = time.monotonic()
        return True

    def _update(self, phase: Phase, optimizer: torch.optim.AdamW, step: int, batch: Batch, rate: float) -> float:
        """Make one step of AdamW and return the loss; the threads share a batch part by part."""
        config = self.config
        images, labels = batch
        parts = [slice(first, min(first + config.part, len(images))) for first in range(0, len(images), config.part)]
        seeds = stream(self.seed, "variation", step).integers(2**31, size=len(parts)).tolist()

        def loss(network: nn.Module, part: slice, seed: int) -> Tensor:
            generator = torch.Generator().manual_seed(seed)
            shown = torch.from_numpy(images[part]).to(self.device)
            pictures = network_input(shown, self.spec.pictures, config.variation, generator)
            return phase.loss(network, pictures, torch.from_numpy(labels[part]).to(self.device), generator)

        value = self.gradients.fill(phase.parameters, loss, parts, seeds)
        if not math.isfinite(value):
            raise TwonavError(f"training diverged at batch {step}: use a smaller peak rate")
        for group in optimizer.param_groups:
            group["lr"] = rate
        optimizer.step()
        return value

    def _validate(self, step: int) -> None:
        assert self.validation is not None
        store, frames = self.validation
        chosen = frames if step == self.config.steps else thinned(frames, self.config.validation_frames)
        found = measured(self.network, self.head, self.spec.pictures, (store, chosen), self.pool)
        self.sink(FittingValidated(self._clock(step), found))

    def finish(self, trials: Mapping[str, Selection], command: str) -> Path:
        """Measure what is saved, save the checkpoint and drop the training's state."""
        if not all(bool(torch.isfinite(value).all()) for value in self.network.state_dict().values()):
            raise TwonavError("training diverged at its end: use a smaller peak rate")
        arrays = packed(self.network, self.head)
        set_weights(self.network, arrays)
        if isinstance(self.head, BeliefHead) and self.validation is not None:
            self.network.eval()
            frames = calibration_frames(self.validation)
            self.head.calibration = calibration_of(self.network, self.head, self.spec.pictures, frames, self.pool)
        metrics = trial_metrics(self.network, self.head, self.spec.pictures, trials, self.pool)
        metrics |= nearest_metrics((self.store, self.frames), trials, self.config.nearest_frames)
        metrics |= {"labels": label_metrics(self.store)}
        meta = self.store.meta
        card = {
            "kind": "localizer",
            "scene": meta["scene"],
            "scene_digest": meta["scene_digest"],
            "map_digest": meta.get("map_digest"),
            "command": command,
            "seed": self.seed,
            "metrics": metrics,
            "settings": {**asdict(self.config), "training_frames": len(self.frames), **self.head.settings()},
            "training": self._effort(),
            "render": meta.get("render", {}),
        }
        save_checkpoint(self.folder, arrays, card)
        (self.folder / STATE_FILE).unlink(missing_ok=True)
        return self.folder

    def _effort(self) -> dict[str, Any]:
        """Return what the training took."""
        return {
            "parameters": sum(parameter.numel() for parameter in self.network.parameters()),
            "device": device_name(self.device),
            "precision": self.precision,
            "seconds": round(self.seconds, 1),
            "pictures_per_s": round(self.config.steps * self.config.batch / max(self.seconds, 1e-9), 1),
        }

    def _clock(self, step: int) -> Clock:
        return Clock(trial=step * self.config.batch // len(self.frames), step=step)

    def _facts(self) -> Facts:
        """Return what a training that goes on must share with its beginning; how it is computed may differ."""
        config = {name: value for name, value in asdict(self.config).items() if name not in MAY_CHANGE}
        shown = digest_of([self.frames.tobytes()])
        resolved = {"precision": self.precision, "device": self.device.type}
        return {"config": {**config, **resolved}, "seed": self.seed, "frames": self.store.meta, "indices": shown}


class _Progress:
    """What the next FittingStep says."""

    def __init__(self, step: int) -> None:
        self.losses: list[float] = []
        self._step, self._since_s = step, time.monotonic()

    def told(self, clock: Clock, rate: float, batch: int) -> FittingStep:
        """Return the event of a batch, and begin to count anew."""
        now_s = time.monotonic()
        speed = (clock.step - self._step) * batch / max(now_s - self._since_s, 1e-9)
        event = FittingStep(clock, float(np.mean(self.losses)), rate, speed)
        self.losses, self._step, self._since_s = [], clock.step, now_s
        return event
