import numpy as np
import pytest
import torch

from twonav_cli.localizer.regression import RegressionHead, pose_targets, poses_of, regression_loss

POSES = np.random.default_rng(4).uniform((-2.0, 1.0, -np.pi), (12.0, 4.0, np.pi), (300, 3)).astype(np.float32)


MIDDLE_M = torch.from_numpy(POSES[:, :2].mean(axis=0))


def test_positions_count_in_metres_from_the_middle_of_the_training_labels() -> None:
    targets = RegressionHead.fitted(POSES, None)
    numbers = pose_targets(torch.from_numpy(POSES), targets.middle_m).numpy()
    assert numbers[:, :2].mean(axis=0) == pytest.approx(0.0, abs=1e-4)
    assert numbers[0, :2] - numbers[1, :2] == pytest.approx(POSES[0, :2] - POSES[1, :2], abs=1e-5)
    assert numbers[:, 2] == pytest.approx(np.sin(POSES[:, 2]), abs=1e-6)
    assert numbers[:, 3] == pytest.approx(np.cos(POSES[:, 2]), abs=1e-6)


def test_numbers_stand_for_the_poses_that_they_were_made_of() -> None:
    outputs = pose_targets(torch.from_numpy(POSES), MIDDLE_M)
    assert poses_of(outputs, MIDDLE_M).numpy() == pytest.approx(POSES, abs=1e-4)


def test_the_length_of_sine_and_cosine_changes_no_heading() -> None:
    outputs = torch.tensor([[0.0, 0.0, 0.3, -0.3], [0.0, 0.0, 3.0, -3.0]])
    headings = poses_of(outputs, MIDDLE_M)[:, 2]
    assert headings.tolist() == pytest.approx([3 * np.pi / 4] * 2)


def test_the_loss_is_squared_near_the_truth_and_grows_evenly_far_from_it() -> None:
    targets = torch.zeros(2, 4)
    losses = [float(regression_loss(targets + away, targets)) for away in (0.01, 0.02, 1.0, 2.0)]
    assert losses[1] == pytest.approx(4 * losses[0], rel=1e-4)
    assert losses[3] == pytest.approx(2 * losses[2], rel=0.05)


def test_a_head_is_the_same_after_it_was_stored() -> None:
    head = RegressionHead.fitted(POSES, None)
    again = RegressionHead.restored(head.arrays(), head.settings())
    outputs = torch.randn(7, 4, generator=torch.Generator().manual_seed(0))
    assert torch.equal(head.poses(outputs), again.poses(outputs))
