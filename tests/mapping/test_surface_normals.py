import numpy as np
import pytest

from twonav_cli.mapping.surface_normals import NEIGHBOUR_BEAMS, NEIGHBOUR_M, surface_normals


def wall(angle_rad: float, count: int = 20, gap_m: float = 0.05) -> np.ndarray:
    """Return ends [N, 2] along a straight wall in a direction."""
    along = np.arange(count) * gap_m
    return np.stack([1.0 + np.cos(angle_rad) * along, -2.0 + np.sin(angle_rad) * along], axis=1)


@pytest.mark.parametrize("angle_rad", [0.0, 0.4, np.pi / 2, 2.0, -1.0])
def test_a_normal_stands_across_its_wall(angle_rad: float) -> None:
    normals = surface_normals(wall(angle_rad))
    assert np.hypot(*normals.T) == pytest.approx(1.0)
    assert normals @ [np.cos(angle_rad), np.sin(angle_rad)] == pytest.approx(0.0, abs=1e-6)


def test_noise_hardly_turns_a_normal() -> None:
    ends = wall(0.4, 200) + 0.005 * np.random.default_rng(0).standard_normal((200, 2))
    normals = surface_normals(ends)
    off_rad = np.arcsin(np.abs(normals @ [np.cos(0.4), np.sin(0.4)]))
    assert np.median(off_rad) < 0.05
    assert off_rad.max() < 0.3


def test_a_normal_is_the_smaller_principal_direction_of_the_ends_around() -> None:
    rng = np.random.default_rng(1)
    ends = wall(1.1, 30, 0.06) + 0.02 * rng.standard_normal((30, 2))
    normals = surface_normals(ends)
    for i in range(NEIGHBOUR_BEAMS, 30 - NEIGHBOUR_BEAMS):
        near = ends[i - NEIGHBOUR_BEAMS : i + NEIGHBOUR_BEAMS + 1]
        near = near[np.hypot(*(near - ends[i]).T) < NEIGHBOUR_M]
        smaller = np.linalg.eigh(np.cov(near.T))[1][:, 0]
        assert abs(normals[i] @ smaller) == pytest.approx(1.0)


def test_two_walls_keep_their_own_normals_right_up_to_a_jump_in_range() -> None:
    near, far = wall(0.0), wall(np.pi / 2) + np.array([5.0, 3.0])
    normals = surface_normals(np.concatenate([near, far]))
    assert np.abs(normals[:20, 1]) == pytest.approx(1.0)
    assert np.abs(normals[20:, 0]) == pytest.approx(1.0)


def test_scattered_ends_and_single_ends_show_no_surface() -> None:
    assert not surface_normals(wall(0.3, 20, 2 * NEIGHBOUR_M)).any()
    assert not surface_normals(wall(0.3, 3)).any()
    cross = np.tile([[0.1, 0.0], [0.0, 0.1], [-0.1, 0.0], [0.0, -0.1]], (5, 1))
    assert not surface_normals(cross).any()


def test_a_scan_without_an_end_has_no_normal() -> None:
    assert surface_normals(np.zeros((0, 2))).shape == (0, 2)
