"""Rows of a network's training: loss and rate per batch, what was measured on the validation frames."""

from __future__ import annotations

import rerun as rr

from twonav_cli.events import FittingStep, FittingValidated
from twonav_cli.recording.blueprint import FITTING_UNITS, fitting_blueprint
from twonav_cli.recording.flight import Detail
from twonav_cli.recording.rrd_file import RrdFile

STEPS_PER_SHIPMENT = 20


def unit_of(metric: str) -> str:
    """Return the plot of a metric by the last part of its name: "median_error_m" is drawn in metres."""
    return FITTING_UNITS.get(metric.rsplit("_", 1)[-1], FITTING_UNITS[""])


class FittingRows:
    """Turns the progress of a training into rows."""

    def __init__(self, file: RrdFile) -> None:
        self._file = file
        self._units: list[str] = []

    def step(self, event: FittingStep) -> None:
        """Buffer one measurement of the training."""
        put, clock = self._file.put, event.clock
        put("fit/loss", event.loss, clock, Detail.TRIAL)
        put("fit/learning_rate", event.learning_rate, clock, Detail.TRIAL)
        put("fit/images_per_s", event.images_per_s, clock, Detail.TRIAL)
        if self._file.buffered("fit/loss") >= STEPS_PER_SHIPMENT:
            self._file.ship(Detail.FULL)

    def validated(self, event: FittingValidated) -> None:
        """Write a validation; a unit that is seen for the first time gets its own plot."""
        units = [unit for unit in FITTING_UNITS.values() if unit in {unit_of(name) for name in event.metrics}]
        if any(unit not in self._units for unit in units):
            self._units = [unit for unit in FITTING_UNITS.values() if unit in {*units, *self._units}]
            self._file.show(fitting_blueprint(self._units))
        for name, value in event.metrics.items():
            columns = rr.Scalars.columns(scalars=[float(value)])
            self._file.send(f"val/{unit_of(name)}/{name}", [event.clock], columns)
        text = ", ".join(f"{name} {value:.4g}" for name, value in event.metrics.items())
        self._file.put("log", ("INFO", f"epoch {event.clock.trial}: {text}"), event.clock, Detail.TRIAL)
        self._file.ship(Detail.FULL)
