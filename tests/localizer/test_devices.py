import pytest
import torch

from twonav_cli.errors import TwonavError
from twonav_cli.localizer.devices import arithmetic, chosen_device, chosen_precision

CPU = torch.device("cpu")
ASKED = ("_is_avx512_bf16_supported", "_is_amx_tile_supported")


def test_auto_takes_the_processor_where_there_is_no_graphics_card(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("torch.cuda.is_available", lambda: False)
    assert chosen_device("auto") == chosen_device("cpu") == CPU
    with pytest.raises(TwonavError, match="take the device cpu or auto"):
        chosen_device("cuda")


@pytest.mark.parametrize(("able", "precision"), [((True, False), "bfloat16"), ((False, True), "bfloat16"),
                                                 ((False, False), "float32")])  # fmt: skip
def test_auto_takes_short_numbers_where_the_processor_has_instructions_for_them(
    monkeypatch: pytest.MonkeyPatch, able: tuple[bool, bool], precision: str
) -> None:
    for name, answer in zip(ASKED, able, strict=True):
        monkeypatch.setattr(torch.cpu, name, lambda answer=answer: answer, raising=False)
    assert chosen_precision("auto", CPU) == precision
    assert chosen_precision("float32", CPU) == "float32"
    assert chosen_precision("bfloat16", CPU) == "bfloat16"


def test_a_torch_that_does_not_say_what_the_processor_can_means_full_precision(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    for name in ASKED:
        monkeypatch.delattr(torch.cpu, name, raising=False)
    assert chosen_precision("auto", CPU) == "float32"


def test_a_network_computes_with_the_precision_that_was_chosen() -> None:
    layer, x = torch.nn.Linear(3, 3), torch.ones(1, 3)
    for precision, dtype in (("float32", torch.float32), ("bfloat16", torch.bfloat16)):
        with arithmetic(CPU, precision):
            assert layer(x).dtype == dtype
