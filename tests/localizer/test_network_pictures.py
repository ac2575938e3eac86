import cv2
import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from twonav_cli.errors import TwonavError
from twonav_cli.localizer.pictures import network_input, shrunk


@pytest.fixture(scope="module")
def images() -> NDArray[np.uint8]:
    """Smooth colours, grey, black, white and pure ones."""
    rng = np.random.default_rng(7)
    small = rng.integers(0, 256, (6, 9, 9, 3), dtype=np.uint8)
    smooth = np.stack([cv2.resize(picture, (84, 84), interpolation=cv2.INTER_CUBIC) for picture in small])
    smooth[0, :20] = rng.integers(0, 256, (20, 84, 1))
    smooth[1, :3] = np.array([0, 255, 128])[:, None, None]
    smooth[2, :3] = np.eye(3, dtype=np.uint8)[:, None] * 255
    return smooth


def hsv_by_opencv(images: NDArray[np.uint8]) -> NDArray[np.int64]:
    return np.stack([cv2.cvtColor(picture, cv2.COLOR_RGB2HSV) for picture in images]).astype(np.int64)


def hsv_shown(images: NDArray[np.uint8], kind: str, low: float) -> NDArray[np.float64]:
    """What a network is shown, back in hue 0 to 180 and saturation and value 0 to 255."""
    shown = network_input(torch.from_numpy(images), kind).permute(0, 2, 3, 1).double().numpy()
    return (shown - low) / (1.0 - low) * np.array([180.0, 255.0, 255.0])


def assert_alike(found: NDArray[np.float64], expected: NDArray[np.int64]) -> None:
    """OpenCV rounds once on the way too: its hue is up to 0.6 from the exact one."""
    around = np.abs((found[..., 0] - expected[..., 0] + 90.0) % 180.0 - 90.0)
    for difference in (around, np.abs(found[..., 1] - expected[..., 1]), np.abs(found[..., 2] - expected[..., 2])):
        assert difference.max() <= 0.75
        assert (difference <= 0.501).mean() > 0.97


def test_pixels_become_minus_one_to_one_with_red_first() -> None:
    images = torch.zeros(1, 84, 84, 3, dtype=torch.uint8)
    images[0, 10, 20, 0] = 255
    x = network_input(images, "rgb84")
    assert x.shape == (1, 3, 84, 84)
    assert x[0, :, 10, 20].tolist() == pytest.approx([1.0, -1.0, -1.0])


def test_hue_saturation_and_value_are_opencvs(images: NDArray[np.uint8]) -> None:
    assert_alike(hsv_shown(images, "hsv84", -1.0), hsv_by_opencv(images))


def test_a_small_picture_is_opencvs(images: NDArray[np.uint8]) -> None:
    small = np.stack([cv2.resize(picture, (36, 36), interpolation=cv2.INTER_AREA) for picture in images])
    found = shrunk(torch.from_numpy(images).float(), 36).numpy()
    assert np.abs(found - small).max() <= 1.0
    same = (found == small).all(axis=-1)
    assert same.mean() > 0.99
    shown = hsv_shown(images, "hsv36", 0.0)
    assert shown.min() >= 0.0
    assert_alike(shown[same], hsv_by_opencv(small)[same])


@pytest.mark.parametrize("kind", ["rgb84", "hsv84", "hsv36"])
def test_varied_light_depends_on_the_seed_alone_and_leaves_the_pictures_as_they_are(
    images: NDArray[np.uint8], kind: str
) -> None:
    given = torch.from_numpy(images.copy())
    first = network_input(given, kind, 0.2, torch.Generator().manual_seed(1))
    assert torch.equal(first, network_input(given, kind, 0.2, torch.Generator().manual_seed(1)))
    assert not torch.allclose(first, network_input(given, kind), atol=0.01)
    assert torch.equal(given, torch.from_numpy(images))


def test_varied_light_keeps_edges_where_they_are(images: NDArray[np.uint8]) -> None:
    given = torch.from_numpy(images)
    first, plain = network_input(given, "rgb84", 0.2, torch.Generator().manual_seed(1)), network_input(given, "rgb84")
    assert np.corrcoef(first[3, 0].flatten(), plain[3, 0].flatten())[0, 1] == pytest.approx(1.0, abs=1e-4)


def test_an_unknown_kind_of_picture_is_answered_with_the_known_ones(images: NDArray[np.uint8]) -> None:
    with pytest.raises(TwonavError, match="rgb84, hsv84, hsv36"):
        network_input(torch.from_numpy(images), "lab84")
