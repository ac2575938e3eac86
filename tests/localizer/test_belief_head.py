import numpy as np
import pytest
import torch

from twonav_cli.localizer.belief_head import SIGMA_M, SIGMA_RAD, BeliefHead, sigmas
from twonav_cli.localizer.calibration import Calibration
from twonav_cli.localizer.objective import precision_loss
from twonav_cli.localizer.training_config import TrainingConfig

POSES = np.random.default_rng(4).uniform((0, 0, -3), (3, 3, 3), (20, 3)).astype(np.float32)


def test_a_head_is_the_same_after_it_was_stored() -> None:
    head = BeliefHead.fitted(POSES, TrainingConfig())
    again = BeliefHead.restored(head.arrays(), head.settings())
    outputs = torch.randn(7, head.outputs, generator=torch.Generator().manual_seed(0))
    assert torch.equal(head.poses(outputs), again.poses(outputs))


def outputs_for(head: BeliefHead, poses: torch.Tensor, log_sigma: tuple[float, float] = (0.0, 0.0)) -> torch.Tensor:
    """Return what a network puts out that gives exactly the targets."""
    window, weights = head.code.position_targets(poses)
    place = torch.full((len(poses), len(head.code.bins) + 1), -12.0)
    place = place.scatter_(1, window, (weights + 1e-6).log())[:, :-1]
    heading = (head.code.heading_targets(poses) + 1e-6).log()
    return torch.cat([place, heading, torch.tensor([log_sigma]).expand(len(poses), 2)], dim=1)


def test_the_logits_of_positions_come_before_those_of_headings() -> None:
    head = BeliefHead.fitted(POSES, TrainingConfig())
    poses = torch.from_numpy(POSES)
    outputs = outputs_for(head, poses)
    assert torch.allclose(head.poses(outputs), poses, atol=0.02)
    assert head.loss(outputs, poses) + 1.0 < head.loss(outputs.roll(1, 0), poses)


def test_a_belief_holds_both_places_that_a_picture_fits_with_their_shares() -> None:
    head = BeliefHead.fitted(POSES, TrainingConfig())
    here, there = torch.tensor([[0.5, 0.5, 1.0]]), torch.tensor([[2.0, 2.2, -2.0]])
    one, other = outputs_for(head, here, (0.5, -0.5)), outputs_for(head, there)
    bins = len(head.code.bins)
    mixed = one.clone()
    mixed[:, :bins] = (0.7 * one[:, :bins].softmax(1) + 0.3 * other[:, :bins].softmax(1)).log()
    mixed[:, bins:-2] = (0.6 * one[:, bins:-2].softmax(1) + 0.4 * other[:, bins:-2].softmax(1)).log()
    head.calibration = Calibration(lost=0.1, scale_m=2.0, scale_rad=3.0)
    belief = head.beliefs(mixed)[0]
    assert belief.places[:, 0] == pytest.approx([0.7, 0.3], abs=0.02)
    assert belief.places[:, 1:3].ravel() == pytest.approx([0.5, 0.5, 2.0, 2.2], abs=0.03)
    assert belief.places[0, 3] == pytest.approx(2.0 * SIGMA_M * np.exp(0.5), rel=1e-5)
    assert belief.headings[:, 0] == pytest.approx([0.6, 0.4], abs=0.02)
    assert belief.headings[:, 1] == pytest.approx([1.0, -2.0], abs=0.02)
    assert belief.headings[0, 2] == pytest.approx(3.0 * SIGMA_RAD * np.exp(-0.5), rel=1e-5)
    assert belief.lost == pytest.approx(0.1, abs=0.01)
    assert belief.grid.sum() == pytest.approx(1.0, abs=1e-4)
    assert belief.pose == pytest.approx((0.5, 0.5, 1.0), abs=0.03)


def test_a_sure_network_has_one_place_and_one_heading() -> None:
    head = BeliefHead.fitted(POSES, TrainingConfig())
    belief = head.beliefs(outputs_for(head, torch.tensor([[1.0, 1.0, 0.3]])))[0]
    assert belief.places.shape == (1, 4)
    assert belief.headings.shape == (1, 3)


def test_deviations_learn_how_large_the_errors_are() -> None:
    rng = torch.Generator().manual_seed(1)
    true = torch.zeros(4000, 3)
    decoded = torch.randn(4000, 3, generator=rng) * torch.tensor([0.03, 0.03, 0.01])
    log_sigma = torch.zeros(1, 2, requires_grad=True)
    optimizer = torch.optim.Adam([log_sigma], lr=0.05)
    for _ in range(200):
        optimizer.zero_grad()
        precision_loss(decoded, sigmas(log_sigma).expand(4000, 2), true, 0.27).backward()
        optimizer.step()
    means = (np.sqrt(2 / np.pi) * 0.03, np.sqrt(2 / np.pi) * 0.01)  # of the absolute values of Gaussians
    assert sigmas(log_sigma).detach()[0].numpy() == pytest.approx(means, rel=0.05)


def test_a_network_that_says_nothing_leaves_nearly_everything_open() -> None:
    labels = np.random.default_rng(5).uniform((0, 0, -3), (9, 9, 3), (4000, 3)).astype(np.float32)
    head = BeliefHead.fitted(labels, TrainingConfig())
    belief = head.beliefs(torch.zeros(1, head.outputs))[0]
    assert belief.lost > 0.8
    assert belief.confidence < 0.2
    assert belief.area_m2 == pytest.approx(81.0, rel=0.1)
