import numpy as np
import pytest
import torch

from twonav_cli.localizer.pose_code import HEADING_BINS, PoseCode

POSES = np.random.default_rng(4).uniform((-2.0, 1.0, -np.pi), (3.0, 4.0, np.pi), (300, 3)).astype(np.float32)


@pytest.fixture
def code() -> PoseCode:
    return PoseCode.covering(POSES)


def _soft_logits(code: PoseCode, poses: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
    """Logits of a network that gives exactly the targets."""
    window, weights = code.position_targets(torch.from_numpy(poses))
    position = torch.full((len(poses), len(code.bins) + 1), -30.0)
    position.scatter_(1, window, (weights + 1e-12).log())
    return position[:, :-1], (code.heading_targets(torch.from_numpy(poses)) + 1e-12).log()


def test_decoding_the_targets_gives_the_pose_back_much_finer_than_a_bin(code: PoseCode) -> None:
    decoded = code.decode(*_soft_logits(code, POSES))
    error = decoded.poses.numpy() - POSES
    assert np.abs(error[:, :2]).max() < 0.01
    assert np.abs((error[:, 2] + np.pi) % (2 * np.pi) - np.pi).max() < np.deg2rad(0.2)
    assert decoded.confidence.numpy() == pytest.approx(1.0, abs=1e-3)


def test_between_two_places_the_likelier_one_is_taken_not_their_mean(code: PoseCode) -> None:
    logits, heading = _soft_logits(code, np.array([[-1.5, 1.5, 0.3], [2.5, 3.5, 0.3]], dtype=np.float32))
    both = (0.6 * logits[:1].exp() + 0.4 * logits[1:].exp()).log()
    decoded = code.decode(both, heading[:1])
    assert decoded.poses[0, :2].numpy() == pytest.approx((-1.5, 1.5), abs=0.01)
    assert float(decoded.confidence[0]) == pytest.approx(0.6, abs=0.01)


def test_headings_meet_across_pi(code: PoseCode) -> None:
    poses = np.array([[0.0, 2.0, np.pi - 0.01], [0.0, 2.0, -np.pi + 0.01]], dtype=np.float32)
    targets = code.heading_targets(torch.from_numpy(poses))
    assert targets[0, HEADING_BINS // 2] > 0.2
    assert targets[0, HEADING_BINS // 2 - 1] > 0.2
    assert code.decode(*_soft_logits(code, poses)).poses[:, 2].numpy() == pytest.approx(poses[:, 2], abs=0.005)


def test_the_belief_puts_each_bin_at_its_row_and_column(code: PoseCode) -> None:
    pose = np.array([[2.0, 3.9, 0.0]], dtype=np.float32)
    grid = code.belief(code.decode(*_soft_logits(code, pose)).positions[0].numpy())
    assert grid.shape == code.frame.shape
    assert np.unravel_index(grid.argmax(), grid.shape) == code.frame.cell_at(2.0, 3.9)
    assert grid.sum() == pytest.approx(1.0, abs=1e-4)


def test_places_far_from_every_frame_have_no_bin() -> None:
    code = PoseCode.covering(np.array([[0.0, 0.0, 0.0], [9.0, 0.0, 0.0]], dtype=np.float32))
    assert len(code.bins) == 2 * 25
    assert code.frame.cols > 30
