"""What a person may ask of a table, and the command that asks it again."""

from dataclasses import replace

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.experiments.tables.catalog import TABLES, default_repeats, make_table, tables_named
from twonav_cli.experiments.tables.request import TableRequest

REQUEST = TableRequest("table5", repeats=2, seed=4, mazes=3)


@pytest.mark.parametrize(
    ("field", "value", "complaint"),
    [
        ("repeats", 0, "--repeats must be at least 1: 0 was given"),
        ("mazes", -2, "--mazes must be at least 1: -2 was given"),
        ("seed", -1, "--seed must be at least 0: -1 was given"),
        ("discount", 1.5, r"discount must be at least 0 and below 1: 1\.5 was given"),
        ("discount", float("nan"), "discount must be .* nan was given"),
    ],
)
def test_a_number_out_of_its_range_is_one_line(field: str, value: float, complaint: str) -> None:
    REQUEST.check()
    with pytest.raises(TwonavError, match=complaint):
        replace(REQUEST, **{field: value}).check()


def test_a_wrong_request_is_refused_before_anything_runs() -> None:
    def no_make(*_: object) -> list[object]:
        raise AssertionError("something was run")

    with pytest.raises(TwonavError, match="--repeats"):
        make_table(replace(REQUEST, repeats=0), no_make)  # type: ignore[arg-type]  # never called


def test_an_unknown_table_is_answered_with_the_right_ones() -> None:
    with pytest.raises(
        TwonavError, match=r"did you mean 'table5'\? Known: table3, .*, table5, table6, .*, sensitivity, .*, all"
    ):
        tables_named("tabel5")


def test_all_stands_for_every_table_and_a_name_for_itself() -> None:
    assert tables_named("all") == list(TABLES)
    assert tables_named("fig8") == ["fig8"]


def test_the_papers_learners_take_the_papers_preset_and_the_explorers_their_own_discount() -> None:
    discounts = {name: REQUEST.settings(name).discount for name in ("single", "multi", "optimistic")}
    assert discounts == {"single": 0.99, "multi": 0.99, "optimistic": 0.95}


def test_a_discount_that_is_asked_for_holds_for_every_learner_but_not_over_a_swept_one() -> None:
    asked = replace(REQUEST, discount=0.9)
    assert asked.settings("multi").discount == asked.settings("optimistic").discount == 0.9
    assert asked.settings("multi", discount=0.8).discount == 0.8


def test_the_command_names_everything_that_decides_the_table() -> None:
    assert REQUEST.command(on_scene=False) == "twonav reproduce table5 --repeats 2 --seed 4 --mazes 3"
    asked = TableRequest("fig8", discount=0.9, scene="my flat.xml")
    expected = "twonav reproduce fig8 --repeats 10 --seed 0 --scene 'my flat.xml' --discount 0.9"
    assert asked.command(on_scene=True) == expected


def test_the_sweep_is_repeated_less_often() -> None:
    assert (default_repeats("table5"), default_repeats("sensitivity")) == (10, 3)


def test_the_mazes_of_a_seed_are_different_ones() -> None:
    mazes = REQUEST.random_mazes()
    assert len(mazes) == 3
    assert len({maze.blocked.tobytes() for maze in mazes}) == 3
