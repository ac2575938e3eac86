"""How much training each network gets: a budget of pictures, where the paper has 10,000 epochs."""

from __future__ import annotations

from typing import Any

from twonav_cli.experiments.localizer_tables.request import OWN_ROW, LocalizerRequest, default_images
from twonav_cli.localizer.networks import OURS
from twonav_cli.localizer.training_config import TrainingConfig, training_settings

QUICK_IMAGES, QUICK_BATCH = 6_000, 64
"""For `--quick`; the small frame sets hold fewer frames than a usual batch of an autoencoder."""


def budget(row: str, scene: str, request: LocalizerRequest) -> TrainingConfig:
    """Return how a row's network is trained for a table; an autoencoder's layers get pictures before in proportion.

    Raises:
        TwonavError: There is no network of that name.
    """
    network = OURS if row == OWN_ROW else row
    usual = default_images(row, scene)
    images = request.images or (QUICK_IMAGES if request.quick else usual)
    before = training_settings(network).pretraining_images
    changes: dict[str, Any] = {
        "images": images,
        "pretraining_images": round(before * images / usual),
        "device": request.device,
        "nearest_frames": 0,  # the row of the most alike frame is the same for every network of a scene
    }
    if request.quick:
        changes |= {"batch": QUICK_BATCH, "validations": 2}
    return training_settings(network, **changes)
