"""Fitting what makes beliefs as sure as they are right: the floor and the widths under which true poses are likeliest.

N frames with a belief and a true pose each; K places, J headings of a belief.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from twonav_cli.belief import Belief
from twonav_cli.errors import TwonavError
from twonav_cli.geometry import FloatArray, wrap_angles
from twonav_cli.localizer.calibration import Calibration
from twonav_cli.localizer.errors_report import Poses

START_LOST = 0.05
"""Floor from which the search starts (ours)."""

LOST = (1e-3, 0.9)
"""Bounds of the floor: no finite number of frames shows that none is ever far off, and beliefs that say nothing must
not make the bells vanish (ours)."""

SCALE = (0.25, 4.0)
"""Bounds of the scales: for beliefs that say nothing the best bell would be infinitely wide (ours)."""


def fit_calibration(beliefs: Sequence[Belief], poses: Poses, exponent: float = 1.0) -> Calibration:
    """Return the floor and the scales that make true poses [N, 3] likeliest: least mean of -log density.

    Args:
        beliefs: [N] of frames that were not trained on.
        poses: [N, 3] where they were taken.
        exponent: On the weights of places and headings; it is taken as given.

    Raises:
        TwonavError: There is no frame, or not one pose for each.
    """
    from scipy.optimize import minimize

    check_pairs(beliefs, poses)
    start = Calibration(0.0, 1.0, 1.0, exponent)
    columns = _columns([start.applied(belief) for belief in beliefs], poses)

    def read(numbers: FloatArray) -> Calibration:
        lost = float(np.clip(1.0 / (1.0 + np.exp(-numbers[0])), *LOST))
        scale_m, scale_rad = (float(np.clip(np.exp(number), *SCALE)) for number in numbers[1:])
        return Calibration(lost, scale_m, scale_rad, exponent)

    def cost(numbers: FloatArray) -> float:
        return float(_misfits(columns, read(numbers)).mean())

    first = np.array([np.log(START_LOST / (1.0 - START_LOST)), 0.0, 0.0])
    simplex = first + np.concatenate([np.zeros((1, 3)), 0.7 * np.eye(3)])
    options = {"initial_simplex": simplex, "xatol": 1e-3, "fatol": 1e-6, "maxiter": 400}
    return read(minimize(cost, first, method="Nelder-Mead", options=options).x)


def mean_misfit(beliefs: Sequence[Belief], poses: Poses) -> float:
    """Return the mean of -log density (per square metre and radian) that beliefs give true poses [N, 3]."""
    check_pairs(beliefs, poses)
    density = [
        belief.density(pose[None])[0] for belief, pose in zip(beliefs, np.asarray(poses, dtype=np.float64), strict=True)
    ]
    return float(-np.log(density).mean())


def check_pairs(beliefs: Sequence[Belief], poses: Poses) -> None:
    """Raise a TwonavError unless there is a frame, and one true pose, of numbers, for each belief."""
    if not np.isfinite(poses).all():
        raise TwonavError("some true poses are not numbers: leave frames without a label out")
    if not beliefs or len(beliefs) != len(poses):
        raise TwonavError(f"{len(beliefs)} beliefs and {len(poses)} true poses: give one of each for every frame")


@dataclass(frozen=True)
class _Columns:
    """Every frame's bells side by side, padded with bells of no weight.

    Attributes:
        places: [N, K, 3] weight, squared distance to the truth, deviation.
        headings: [N, J, 3] weight, squared angle to the truth, deviation.
        area_m2: [N].
        lost: [N] floor of the beliefs as they are.
    """

    places: FloatArray
    headings: FloatArray
    area_m2: FloatArray
    lost: FloatArray


def _columns(beliefs: Sequence[Belief], poses: Poses) -> _Columns:
    places = np.zeros((len(beliefs), max(len(belief.places) for belief in beliefs), 3))
    headings = np.zeros((len(beliefs), max(len(belief.headings) for belief in beliefs), 3))
    places[:, :, 2] = headings[:, :, 2] = 1.0
    for index, (belief, pose) in enumerate(zip(beliefs, np.asarray(poses, dtype=np.float64), strict=True)):
        squared = ((belief.places[:, 1:3] - pose[:2]) ** 2).sum(axis=1)
        places[index, : len(squared)] = np.column_stack([belief.places[:, 0], squared, belief.places[:, 3]])
        away_rad = wrap_angles(belief.headings[:, 1] - pose[2])
        headings[index, : len(away_rad)] = np.column_stack([belief.headings[:, 0], away_rad**2, belief.headings[:, 2]])
    area_m2, lost = (np.array([getattr(belief, name) for belief in beliefs]) for name in ("area_m2", "lost"))
    return _Columns(places, headings, area_m2, lost)


def _misfits(columns: _Columns, calibration: Calibration) -> FloatArray:
    """Return -log density [N] of the true poses after a calibration."""
    weight, squared, sigma = np.moveaxis(columns.places, 2, 0)
    sigma = sigma * calibration.scale_m
    place = (weight / (2 * np.pi * sigma**2) * np.exp(-0.5 * squared / sigma**2)).sum(axis=1)
    weight, squared, sigma = np.moveaxis(columns.headings, 2, 0)
    sigma = sigma * calibration.scale_rad
    heading = (weight / (np.sqrt(2 * np.pi) * sigma) * np.exp(-0.5 * squared / sigma**2)).sum(axis=1)
    found = (1.0 - calibration.lost) * (1.0 - columns.lost)
    lost = 1.0 - found
    likelihood = (found * place + lost / columns.area_m2) * (found * heading + lost / (2 * np.pi))
    return np.asarray(-np.log(likelihood))
