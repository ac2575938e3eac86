"""What a person may ask of a table of localizers, the training that each network gets, and the catalogue."""

from __future__ import annotations

from dataclasses import replace

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.localizer_tables.budget import QUICK_BATCH, QUICK_IMAGES, budget
from twonav_cli.experiments.localizer_tables.report import BELIEF, NEAREST
from twonav_cli.experiments.localizer_tables.request import (
    OWN_ROW,
    PICTURES,
    PRINTED,
    ROWS,
    LocalizerRequest,
    default_images,
)
from twonav_cli.experiments.paper_figures import TABLE_1, TABLE_2
from twonav_cli.experiments.tables.catalog import LOCALIZER_TABLES, TABLES, tables_named
from twonav_cli.localizer.networks import NETWORKS, OURS, SDAS
from twonav_cli.localizer.paper_networks import CNNS
from twonav_cli.localizer.training_config import training_settings

TABLE_3, TABLE_4 = LocalizerRequest("table3"), LocalizerRequest("table4")
TABLE_4_ROWS = ROWS["table4"]


def test_every_printed_network_is_one_that_can_be_trained() -> None:
    assert {network for rows in PRINTED.values() for _, network in rows} <= set(NETWORKS)
    assert BELIEF == OURS
    assert NEAREST not in NETWORKS


def test_the_papers_tables_1_and_2_are_the_networks_that_are_trained() -> None:
    assert {row.units for row in TABLE_1} == set(SDAS.values())
    assert [row.pooling for row in TABLE_2] == [spec.pooling for spec in CNNS.values()]


def test_a_table_has_the_papers_rows_in_the_papers_order() -> None:
    assert TABLE_3.rows()["apartment"] == ["sda-3x4000"]
    in_kitchen = ["sda-1x1500", "sda-1x4000", "sda-2x1500", "sda-2x4000", "sda-3x1500", "sda-3x4000"]
    assert TABLE_3.rows()["kitchen"] == in_kitchen
    assert {scene: len(rows) for scene, rows in TABLE_4.rows().items()} == {"kitchen": 7, "apartment": 6}
    assert [rows[-1] for rows in TABLE_4.rows().values()] == [OWN_ROW, OWN_ROW]
    assert LocalizerRequest("fig7").rows() == {"apartment": ["sda-3x4000", "inception-9"]}


def test_scene_and_networks_choose_rows() -> None:
    chosen = replace(TABLE_4, scene="apartment", networks=("inception-9", "cnn-7"))
    assert chosen.rows() == {"apartment": ["cnn-7", "inception-9"]}
    assert replace(TABLE_4, networks=("cnn-7",)).rows() == {"kitchen": ["cnn-7"], "apartment": ["cnn-7"]}


@pytest.mark.parametrize(
    ("wrong", "complaint"),
    [
        ({"networks": ("cnn-8",)}, r"unknown network of table4 'cnn-8'; did you mean .*Known: cnn-7, cnn-9"),
        ({"networks": ("sda-3x4000",)}, "unknown network of table4 'sda-3x4000'"),
        ({"scene": "kitchn"}, r"unknown scene of table4 'kitchn'; did you mean 'kitchen'"),
        ({"scene": "kitchen", "networks": ("inception-pool-9",)}, "no row of scene kitchen for inception-pool-9"),
        ({"seed": -1}, "--seed must be at least 0"),
        ({"images": 0}, "--images must be at least 1"),
        ({"device": "gpu"}, "unknown device 'gpu'.*Known: auto, cpu, cuda"),
    ],
)
def test_what_no_row_has_is_one_line(wrong: dict[str, object], complaint: str) -> None:
    TABLE_4.check()
    with pytest.raises(TwonavError, match=complaint):
        replace(TABLE_4, **wrong).check()  # type: ignore[arg-type]


def test_the_command_says_everything_that_was_asked() -> None:
    assert TABLE_3.command() == "twonav reproduce table3 --seed 0"
    asked = LocalizerRequest("table4", 3, True, 500, "cpu", "kitchen", ("cnn-7", "cnn-9"), "geometry", True)
    assert asked.command() == (
        "twonav reproduce table4 --seed 3 --quick --images 500 --scene kitchen --networks cnn-7,cnn-9 "
        "--map-from geometry --device cpu --only-finished"
    )
    assert TABLE_4.only("apartment", "cnn-7").command() == (
        "twonav reproduce table4 --seed 0 --scene apartment --networks cnn-7"
    )


def test_all_are_the_tables_about_mazes_and_the_others_go_by_name() -> None:
    assert LOCALIZER_TABLES == ("table3", "table4", "fig7")
    assert tables_named("all") == list(TABLES)
    assert [tables_named(name) for name in LOCALIZER_TABLES] == [["table3"], ["table4"], ["fig7"]]
    with pytest.raises(TwonavError, match="did you mean 'table3'"):
        tables_named("tabel3")


# How much training


def test_convolutional_networks_get_the_same_pictures_in_every_scene_and_autoencoders_half() -> None:
    cnns = [budget(name, scene, TABLE_4).images for scene, name in TABLE_4_ROWS if name not in ("inception-9", OWN_ROW)]
    assert set(cnns) == {PICTURES["cnn"]} == {2 * PICTURES["sda"]}
    sda = budget("sda-2x1500", "kitchen", TABLE_3)
    assert sda.images == PICTURES["sda"] == budget("sda-3x4000", "apartment", TABLE_3).images
    assert sda.pretraining_images == training_settings("sda-2x1500").pretraining_images > 0
    assert sda.batch == training_settings("sda-2x1500").batch


@pytest.mark.parametrize("network", ["inception-9", OWN_ROW])
def test_the_best_network_of_the_paper_and_ours_see_each_frame_as_often_in_the_apartment(network: str) -> None:
    kitchen, apartment = (budget(network, scene, TABLE_4).images for scene in ("kitchen", "apartment"))
    assert (kitchen, apartment) == (PICTURES["cnn"], 3 * PICTURES["cnn"])


def test_our_network_is_trained_on_the_papers_frames_with_its_own_settings() -> None:
    own = budget(OWN_ROW, "kitchen", TABLE_4)
    assert (own.network, own.peak_rate) == (OURS, training_settings(OURS).peak_rate)


def test_an_autoencoders_layers_get_their_share_of_other_budgets() -> None:
    half = replace(TABLE_3, images=default_images("sda-1x4000", "kitchen") // 2)
    whole = budget("sda-1x4000", "kitchen", TABLE_3)
    assert budget("sda-1x4000", "kitchen", half).pretraining_images == whole.pretraining_images // 2
    assert budget("cnn-7", "kitchen", half).pretraining_images == 0


@pytest.mark.parametrize("network", ["cnn-7", "sda-3x4000"])
def test_a_quick_run_shows_few_pictures_in_small_batches(network: str) -> None:
    quick = budget(network, "apartment", LocalizerRequest("fig7", quick=True, device="cpu"))
    assert (quick.images, quick.batch, quick.device) == (QUICK_IMAGES, QUICK_BATCH, "cpu")
    assert quick.pretraining_images <= 1.1 * QUICK_IMAGES
    assert budget(network, "apartment", LocalizerRequest("fig7", quick=True, images=900)).images == 900
