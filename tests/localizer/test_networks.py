import pytest
import torch

from twonav_cli.errors import TwonavError
from twonav_cli.localizer.networks import ARCHITECTURES, build_network, network_input


@pytest.mark.parametrize("name", ARCHITECTURES)
def test_every_network_gives_logits_of_both_codes_and_fits_in_eight_megabytes(name: str) -> None:
    network = build_network(name, 1300, 72).eval()
    position, heading = network(torch.zeros(2, 3, 84, 84))
    assert position.shape == (2, 1300)
    assert heading.shape == (2, 72)
    assert sum(p.numel() for p in network.parameters()) * 2 < 8e6


@pytest.mark.parametrize("name", ARCHITECTURES)
def test_no_network_pools_and_each_has_nine_layers(name: str) -> None:
    network = build_network(name, 10, 72)
    assert not [m for m in network.modules() if "Pool" in type(m).__name__]
    assert 1 + len(network.layers) + 2 == 9


def test_folding_changes_no_answer() -> None:
    torch.manual_seed(0)
    network = build_network("inception-9", 50, 72)
    images = torch.randint(0, 255, (8, 84, 84, 3), dtype=torch.uint8)
    network(network_input(images))  # gives the normalisations something to remember
    network.eval()
    with torch.no_grad():
        for parameter in network.first.norm.parameters():
            parameter.add_(torch.rand_like(parameter))
        before = network(network_input(images))[0]
        network.fold()
        after = network(network_input(images))[0]
    assert before.std() > 1e-3
    assert torch.allclose(before, after, atol=1e-4)


def test_pixels_become_minus_one_to_one_with_red_first() -> None:
    images = torch.zeros(1, 84, 84, 3, dtype=torch.uint8)
    images[0, 10, 20, 0] = 255
    x = network_input(images)
    assert x.shape == (1, 3, 84, 84)
    assert x[0, 0, 10, 20] == pytest.approx(1.0)
    assert x[0, 1, 10, 20] == pytest.approx(-1.0)


def test_a_wrong_name_is_answered_with_the_right_ones() -> None:
    with pytest.raises(TwonavError, match="did you mean 'inception-9'"):
        build_network("inception9", 10, 72)
