"""What is said of the map that a command works on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from twonav_cli.errors import TwonavError
from twonav_cli.mapping.floor import read_floor
from twonav_cli.terminal.map_source import notice_of
from twonav_cli.terminal.scenes import run_show


@pytest.mark.parametrize("outdated", [None, Path("runs/kitchen/map")])
def test_one_line_says_why_the_map_is_the_geometrys(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, outdated: Path | None
) -> None:
    monkeypatch.setenv("TWONAV_RUNS", str(tmp_path))
    floor = replace(read_floor("kitchen", "geometry"), outdated=outdated)
    notice = notice_of(floor, "kitchen", None)
    assert notice is not None
    assert "`twonav train --stage map --scene kitchen`" in notice
    assert "\n" not in notice
    said = "the survey in runs/kitchen/map is of another version of the scene, survey again"
    assert (said in notice) == (outdated is not None)
    assert notice_of(floor, "kitchen", "geometry") is None
    assert notice_of(replace(floor, map_source="survey"), "kitchen", None) is None


def test_a_maps_picture_is_answered_with_the_file_to_name() -> None:
    with pytest.raises(TwonavError, match=r"map\.pgm is a map's picture: name the map's \.yaml file"):
        run_show("map.pgm", as_map=True)
