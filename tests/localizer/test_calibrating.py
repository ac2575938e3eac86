from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
import torch

from twonav_cli.dataset.collect import MAPPER
from twonav_cli.dataset.store import FrameStore
from twonav_cli.errors import TwonavError
from twonav_cli.localizer.belief_head import BeliefHead
from twonav_cli.localizer.calibrating import MAP_M, calibration_frames, calibration_of
from twonav_cli.localizer.calibration_fit import LOST, SCALE, fit_calibration
from twonav_cli.localizer.networks import network_spec
from twonav_cli.localizer.training_config import TrainingConfig


@pytest.mark.parametrize(("labels", "map_m"), [("simulator", 0.0), (MAPPER, MAP_M)])
def test_a_network_that_learned_nothing_gets_bounded_numbers_and_the_maps_own_error(
    toy_store: FrameStore, labels: str, map_m: float
) -> None:
    torch.manual_seed(0)
    store = replace(toy_store, meta={**toy_store.meta, "labels": labels})
    head = BeliefHead.fitted(store.labels[store.training()], TrainingConfig())
    network = network_spec("belief").build(head).eval()
    with ThreadPoolExecutor(1) as pool:
        found = calibration_of(network, head, "rgb84", (store, store.off_grid()[:40]), pool)
    assert LOST[0] <= found.lost <= LOST[1]
    assert SCALE[0] <= found.scale_m <= SCALE[1]
    assert SCALE[0] <= found.scale_rad <= SCALE[1]
    assert found.map_m == map_m
    beliefs = replace_calibration(head, found).beliefs(torch.zeros(1, head.outputs))
    assert beliefs[0].places[0, 3] >= map_m


def replace_calibration(head: BeliefHead, calibration: object) -> BeliefHead:
    head.calibration = calibration  # type: ignore[assignment]  # it is one
    return head


def test_frames_without_a_label_do_not_calibrate(toy_store: FrameStore) -> None:
    labels = toy_store.labels.copy()
    frames = toy_store.off_grid()[:20]
    labels[frames[3]] = np.nan
    _, kept = calibration_frames((replace(toy_store, labels=labels), frames))
    assert frames[3] not in kept
    assert len(kept) == 19


def test_poses_that_are_not_numbers_are_refused(toy_store: FrameStore) -> None:
    head = BeliefHead.fitted(toy_store.labels[toy_store.training()], TrainingConfig())
    beliefs = head.beliefs(torch.zeros(2, head.outputs))
    with pytest.raises(TwonavError, match="not numbers"):
        fit_calibration(beliefs, np.array([[0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]]))
