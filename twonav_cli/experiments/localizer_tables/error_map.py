"""Fig. 7: the mean position error of every 25 cm cell, and where cells lie in a picture.

N frames, K cells, R rows, C columns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from twonav_cli.config import FRAME_SPACING_M
from twonav_cli.experiments.localizer_tables.report import (
    TITLES,
    Figures,
    errata_figures,
    settings_of,
)
from twonav_cli.experiments.localizer_tables.request import LocalizerRequest
from twonav_cli.experiments.paper_figures import FIG_7
from twonav_cli.grid import GridFrame

FloatArray = NDArray[np.float64]


@dataclass(frozen=True)
class ErrorMap:
    """The errors of a network over the floor.

    Attributes:
        network: A name of NETWORKS, or NEAREST.
        paper: "min_m" and "max_m" as printed; None for one that the paper does not have.
        cells: [K] lists of x_m, y_m (the centre), the mean position error in metres and the number of frames.
        summary: "min_m", "median_m", "mean_m" and "max_m" over the cells, the "cells", "frames" and the "worst" cell's
            centre.
        training: What the training took; None when there was none.
    """

    network: str
    paper: Figures | None
    cells: list[list[float]]
    summary: Figures
    training: Figures | None


@dataclass(frozen=True)
class ErrorMapReport:
    """Fig. 7, the paper's ends of the scale and our maps.

    Attributes:
        table: "fig7".
        title: One line.
        scene: Name.
        maps: One for each network that could be measured.
        missing: The paper's networks that are not trained, to "min_m" and "max_m" as printed.
        errata: The paper's slips: "row" and "text".
        settings: Everything that decides the figures, the command and the versions.
    """

    table: str
    title: str
    scene: str
    maps: list[ErrorMap]
    missing: dict[str, Figures]
    errata: list[dict[str, str]]
    settings: Figures


def error_map(
    scene: str, network: str, errors_m: FloatArray, true_poses: NDArray[Any], training: Figures | None
) -> ErrorMap:
    """Return the map of the errors [N] of frames taken at poses [N, 3], which lie at centres of cells."""
    centres, errors, counts = cell_means(errors_m, true_poses)
    worst = int(errors.argmax())
    return ErrorMap(
        network,
        _printed(scene, network),
        [
            [*centre, round(error, 5), count]
            for centre, error, count in zip(centres.tolist(), errors, counts.tolist(), strict=True)
        ],
        {
            "min_m": float(errors.min()),
            "median_m": float(np.median(errors)),
            "mean_m": float(errors.mean()),
            "max_m": float(errors.max()),
            "cells": len(errors),
            "frames": len(errors_m),
            "worst": centres[worst].tolist(),
        },
        training,
    )


def error_map_report(
    request: LocalizerRequest, scene: str, maps: list[ErrorMap], missing: list[str], scenes: Figures
) -> ErrorMapReport:
    """Return the report of a request."""
    settings = {
        **settings_of(request, scenes),
        "frames": "the paper's test frames of each cell; the paper takes every degree, also those trained on",
    }
    name = request.table
    ends = {network: _printed(scene, network) or {} for network in missing}
    return ErrorMapReport(name, TITLES[name], scene, maps, ends, errata_figures(name), settings)


def _printed(scene: str, network: str) -> Figures | None:
    """Return the paper's ends, if it has this network."""
    printed = FIG_7.get((scene, network))
    return None if printed is None else printed._asdict()


def cell_means(errors_m: FloatArray, true_poses: NDArray[Any]) -> tuple[FloatArray, FloatArray, NDArray[np.int64]]:
    """Return the centres [K, 2] of the cells, the mean error [K] in each, and how many frames it has [K].

    Args:
        errors_m: [N].
        true_poses: [N, 3], at the centres of the cells.
    """
    places = np.asarray(true_poses, dtype=np.float64)[:, :2].round(3)
    centres, cell = np.unique(places, axis=0, return_inverse=True)
    counts = np.bincount(cell.ravel(), minlength=len(centres))
    return centres, np.bincount(cell.ravel(), weights=errors_m, minlength=len(centres)) / counts, counts


def heat_of(cells: list[list[float]]) -> tuple[FloatArray, GridFrame]:
    """Return the errors of cells as a picture [R, C], not a number where there is no cell, and where it lies."""
    x_m, y_m, errors = np.array(cells, dtype=np.float64)[:, :3].T
    cols, rows = (round((axis.max() - axis.min()) / FRAME_SPACING_M) + 1 for axis in (x_m, y_m))
    low = float(x_m.min() - FRAME_SPACING_M / 2), float(y_m.min() - FRAME_SPACING_M / 2)
    frame = GridFrame(*low, FRAME_SPACING_M, rows, cols)
    heat = np.full(frame.shape, np.nan)
    for x, y, error in zip(x_m, y_m, errors, strict=True):
        heat[frame.cell_at(float(x), float(y))] = error
    return heat, frame
