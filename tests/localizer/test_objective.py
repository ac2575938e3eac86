import numpy as np
import torch

from twonav_cli.localizer.objective import pose_loss
from twonav_cli.localizer.pose_code import HEADING_BINS, PoseCode

POSES = np.random.default_rng(4).uniform((0, 0, -3), (3, 3, 3), (20, 3)).astype(np.float32)


def test_the_loss_is_smaller_near_the_truth_than_far_from_it_and_has_gradients() -> None:
    code = PoseCode.covering(POSES)
    poses = torch.from_numpy(POSES)
    window, weights = code.position_targets(poses)
    right = torch.full((20, len(code.bins) + 1), -12.0).scatter_(1, window, (weights + 1e-6).log())[:, :-1]
    heading = (code.heading_targets(poses) + 1e-6).log()
    good, decoded = pose_loss(right, heading, poses, code, 0.3)
    wrong, _ = pose_loss(right.roll(1, 0), heading.roll(1, 0), poses, code, 0.3)
    assert torch.allclose(decoded, poses, atol=0.02)
    assert good + 3.0 < wrong
    logits = torch.zeros(20, len(code.bins), requires_grad=True)
    pose_loss(logits, torch.zeros(20, HEADING_BINS), poses, code, 0.3)[0].backward()
    assert logits.grad is not None
    assert torch.isfinite(logits.grad).all()
    assert logits.grad.abs().sum() > 0
