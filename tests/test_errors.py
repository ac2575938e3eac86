"""The sentence that answers a wrong name."""

from __future__ import annotations

from twonav_cli.errors import TwonavError, unknown_name


def test_a_near_name_comes_first_and_every_right_one_after_it() -> None:
    error = unknown_name("goal", "kichen", ["bed", "kitchen"])
    assert isinstance(error, TwonavError)
    assert str(error) == "unknown goal 'kichen'; did you mean 'kitchen'? Known: bed, kitchen"


def test_a_name_in_capitals_is_near() -> None:
    assert "did you mean 'Living-Room'" in str(unknown_name("goal", "LIVING-ROM", ["Living-Room"]))


def test_without_a_near_name_only_the_right_ones_are_listed() -> None:
    assert str(unknown_name("start", "xyz", ["s1", "s2"])) == "unknown start 'xyz'. Known: s1, s2"


def test_an_empty_table_is_said_to_be_empty() -> None:
    assert str(unknown_name("scene", "a", [])) == "unknown scene 'a'. Known: none"
