import numpy as np
import pytest
import torch
from torch import nn

from twonav_cli.errors import TwonavError
from twonav_cli.localizer.layers import Convolution, Inception
from twonav_cli.localizer.networks import NETWORKS, SDAS, network_spec
from twonav_cli.localizer.paper_networks import CNNS, Cnn
from twonav_cli.localizer.pictures import network_input
from twonav_cli.localizer.training_config import training_settings

LABELS = np.random.default_rng(4).uniform((0, 0, -3), (6, 4, 3), (200, 3)).astype(np.float32)
IMAGES = torch.randint(0, 256, (4, 84, 84, 3), dtype=torch.uint8, generator=torch.Generator().manual_seed(0))


def built(name: str) -> nn.Module:
    spec = network_spec(name)
    torch.manual_seed(0)
    return spec.build(spec.head_class.fitted(LABELS, training_settings(name)))


def test_every_network_of_tables_1_and_2_is_there_beside_ours() -> None:
    cnns = ["cnn-7", "inception-pool-7", "cnn-9", "inception-9", "inception-pool-9"]
    sdas = ["sda-1x1500", "sda-1x4000", "sda-2x1500", "sda-2x4000", "sda-3x1500", "sda-3x4000"]
    assert sorted(NETWORKS) == sorted(["belief", *cnns, *(f"{name}-hsv" for name in cnns), *sdas])


@pytest.mark.parametrize("name", [name for name in NETWORKS if "4000" not in name])
def test_every_network_makes_a_pose_of_every_picture(name: str) -> None:
    spec = network_spec(name)
    head = spec.head_class.fitted(LABELS, training_settings(name))
    network = spec.build(head).eval()
    with torch.no_grad():
        outputs = network(network_input(IMAGES, spec.pictures))
    assert outputs.shape == (4, head.outputs)
    poses = head.poses(outputs)
    assert poses.shape == (4, 3)
    assert torch.isfinite(poses).all()


@pytest.mark.parametrize("name", CNNS)
def test_a_network_of_table_2_has_as_many_layers_as_its_name_says(name: str) -> None:
    network = built(name)
    assert isinstance(network, Cnn)
    assert len(network.layers) + 2 == int(name[-1])  # the dense layer and the output
    assert network.dense.out_features == 512
    assert network.out.out_features == 4


@pytest.mark.parametrize("name", CNNS)
def test_only_pooling_networks_pool_and_only_the_others_stride(name: str) -> None:
    modules = list(built(name).modules())
    pools = [module for module in modules if isinstance(module, nn.MaxPool2d)]
    strides = [module for module in modules if isinstance(module, nn.Conv2d) and module.stride != (1, 1)]
    assert bool(pools) == ("pool" in name)
    assert bool(strides) == ("pool" not in name)


@pytest.mark.parametrize("name", CNNS)
def test_kernels_are_those_of_table_2(name: str) -> None:
    network = built(name)
    assert isinstance(network, Cnn)
    kernels = {module.kernel_size[0] for module in network.layers.modules() if isinstance(module, nn.Conv2d)}
    assert kernels == ({1, 3, 5} if "inception" in name else {5})
    first, *rest = network.layers
    assert isinstance(first, Convolution)
    assert all(isinstance(layer, Inception) == ("inception" in name) for layer in rest)


@pytest.mark.parametrize("name", SDAS)
def test_an_autoencoder_has_the_layers_and_units_of_table_1(name: str) -> None:
    layers, units = (int(number) for number in name.removeprefix("sda-").split("x"))
    with torch.device("meta"):
        network = network_spec(name).make(4)
    sizes = [module.out_features for module in network.layers]  # type: ignore[union-attr]  # an autoencoder's
    assert sizes == [units] * layers
    assert network.layers[0].in_features == 36 * 36 * 3  # type: ignore[index, union-attr]  # an autoencoder's


@pytest.mark.parametrize("name", ["belief", "cnn-7", "inception-9", "inception-pool-7"])
def test_folding_changes_no_answer(name: str) -> None:
    network = built(name)
    pictures = network_input(IMAGES, "rgb84")
    network(pictures)  # gives the normalisations something to remember
    network.eval()
    with torch.no_grad():
        for module in network.modules():
            if isinstance(module, nn.BatchNorm2d):
                module.weight.add_(0.3 * torch.rand_like(module.weight))
                module.bias.add_(0.3 * torch.rand_like(module.bias))
        before = network(pictures)
        network.fold()  # type: ignore[operator]  # a module's attribute
        after = network(pictures)
    assert before.std() > 1e-3
    assert torch.allclose(before, after, atol=1e-4)


def test_a_wrong_name_is_answered_with_the_right_ones() -> None:
    with pytest.raises(TwonavError, match=r"did you mean 'inception-9'.*sda-3x4000"):
        network_spec("inception9")
